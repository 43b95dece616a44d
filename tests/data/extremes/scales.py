"""Row 28: lights under scaling transforms, from the shapes that result."""
from mpmath import asin, atan, mpf, pi, quad, sin, sqrt, tan

from table import Table

SIZES = (2.0**-40, 2.0**-20, 1e-3, 0.5, 1.0, 3.0, 1e3, 2.0**20, 2.0**40)


def ellipse_area(a, b):
    """Area of an ellipse, from the chords at each angle t of the circle around it: b sin(t) over a cos(t)."""
    return quad(lambda t: 2 * a * b * sin(t) ** 2, [0, pi])


def sphere_per_sr(radius, distance):
    """Uniform density in the cone that the sphere subtends."""
    return 1 / (4 * pi * sin(asin(mpf(radius) / distance) / 2) ** 2)


def rectangle_sr(x, y):
    """Solid angle of the rectangle about the axis with half sides x and y in the plane z = 1."""
    return 4 * atan(x * y / sqrt(1 + x * x + y * y))


def tables():
    table = Table("scaled_lights", """
Under Scale sx sy sz: of radiance 1 a sphere of radius 1, a disk of radius 1, and a cylinder of radius 1 and z from 0 to
1; of intensity 1 a spot of 30 degrees with an edge of 5, and a projection of 60 degrees.  Power [lm]; the density with
which a receiver at (0, 0, 3 sz) samples the sphere, at (0, 0, 2 sz) the disk's middle by area, and at (4 sx, 0, sz / 2)
the cylinder's point (sx, 0, sz / 2) by area [1/sr], and 0 for the others.
""", "light sx sy sz power_lm per_sr")
    degree = pi / 180
    for s in SIZES:
        for mirror in (1, -1):
            m = mpf(s)
            equal = (mirror * s, s, s)
            table.add("sphere", *equal, pi * 4 * pi * m * m, sphere_per_sr(m, 3 * m))
            table.add("disk", *equal, pi * ellipse_area(m, m), (2 * m) ** 2 / ellipse_area(m, m))
            table.add("cylinder", *equal, pi * 2 * pi * m * m, (3 * m) ** 2 / (2 * pi * m * m))
            spot = 2 * pi * (1 - (cosine(25 * degree) + cosine(30 * degree)) / 2)
            table.add("spot", *equal, spot, mpf(0))
            side = tan(30 * degree)
            table.add("projection", *equal, rectangle_sr(side, side), mpf(0))
    for sx, sy, sz in ((2.0, 1.0, 1.0), (1e-3, 1.0, 1.0), (1e3, 1e-3, 1.0), (1.0, 1.0, 1e6), (-3.0, 7.0, 1e-6),
                       (2.0**-30, 2.0**30, -1.0)):
        x, y, z = [abs(mpf(c)) for c in (sx, sy, sz)]
        area = ellipse_area(x, y)
        table.add("disk", sx, sy, sz, pi * area, (2 * z) ** 2 / area)
        side = tan(30 * degree)
        table.add("projection", sx, sy, sz, rectangle_sr(side * x / z, side * y / z), mpf(0))
    for s, sz in ((1.0, 1e-6), (1.0, 1e6), (1e-3, 1e3), (1e6, -2.0), (2.0**-40, 2.0**40)):
        x, z = mpf(s), abs(mpf(sz))
        area = 2 * pi * x * z
        table.add("cylinder", -s, s, sz, pi * area, (3 * x) ** 2 / area)
    yield table


def cosine(angle):
    return 1 - 2 * sin(angle / 2) ** 2
