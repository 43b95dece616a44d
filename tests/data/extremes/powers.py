"""Row 29: powers, by numerical integration where the code has closed forms, by other closed forms where it sums.

Luminous flux [lm] of lights of radiance, intensity or illuminance 1.
"""
from mpmath import atan, cos, mp, mpf, pi, quad, sin, sqrt

from maps import texel
from spots import smoothstep, solid_angle
from table import Table

DEGREE = 3.141592653589793 / 180


def spots():
    table = Table("spot_powers", """
Spots of intensity 1, their share of it integrated over the angle numerically: smoothstep of the cosine [lm], and the
square and the fourth power of the same.
""", "cone_rad start_rad smoothstep_lm quadratic_lm quartic_lm")
    for degrees, delta in ((30.0, 5.0), (30.0, 30.0), (1e-5, 5e-6), (1e-5, 1e-5), (0.01, 0.001), (1.0, 1.0), (60.0, 0.25),
                           (90.0, 10.0), (120.0, 20.0), (179.0, 1.0), (180.0, 0.5), (180.0, 180.0)):
        cone = degrees * DEGREE if degrees < 180 else 3.141592653589793
        start = (degrees - delta) * DEGREE if degrees < 180 else 3.141592653589793 - delta * DEGREE
        start = max(start, 0.0)
        with mp.workdps(90):
            powers = [solid_angle(mpf(start), mpf(cone), profile) for profile in (smoothstep, lambda x: x**2, lambda x: x**4)]
        table.add(cone, start, *powers)
    return table


def corner_sr(x, y):
    """Solid angle of the rectangle from the axis to (x, y) in the plane z = 1, with the sign of x y."""
    return atan(x * y / sqrt(1 + x * x + y * y))


def rectangle_sr(x0, x1, y0, y1):
    return corner_sr(x1, y1) - corner_sr(x0, y1) - corner_sr(x1, y0) + corner_sr(x0, y0)


def projections():
    table = Table("projection_powers", """
Projections of intensity 1 [lm]: evenly lit; of a picture of 4 x 3 texels, texel (i, j) max(0, (3 i + 5 j) mod 9 - 2),
with the nearest filter.
""", "fov_deg fov_rad aspect even_lm picture_lm")
    with mp.workdps(120):
        for fov_deg in (1e-5, 0.01, 1.0, 30.0, 90.0, 150.0, 179.0, 179.999):
            for aspect in (1e-3, 1.0 / 3, 0.5, 1.0, 4.0 / 3, 3.0, 64.0, 1e3):
                fov = fov_deg * DEGREE
                shorter = mp.tan(mpf(fov) / 2)
                x = shorter * max(mpf(aspect), 1)
                y = shorter / min(mpf(aspect), 1)
                picture = mpf(0)
                for j in range(3):
                    for i in range(4):
                        # Rows go down, which does not change the sum.
                        picture += texel(i, j) * rectangle_sr(x * (2 * i - 4) / 4, x * (2 * i - 2) / 4,
                                                              y * (2 * j - 3) / 3, y * (2 * j - 1) / 3)
                table.add(fov_deg, fov, aspect, rectangle_sr(-x, x, -y, y), picture)
    return table


def bilinear_cell(x0, x1, y0, y1, corners):
    """Integral of a bilinear function between corner values, times cos^3: in closed form over y, numerically over x."""
    v00, v10, v01, v11 = corners

    def line(x):
        s = (x - x0) / (x1 - x0)
        at0, at1 = v00 + (v10 - v00) * s, v01 + (v11 - v01) * s
        slope = (at1 - at0) / (y1 - y0)
        r2 = 1 + x * x
        antiderivative = lambda y: ((at0 - slope * y0) * y / r2 - slope) / sqrt(r2 + y * y)
        return antiderivative(y1) - antiderivative(y0)

    return quad(line, [x0, x1] if x0 * x1 >= 0 else [x0, 0, x1])


def bilinear_projections():
    table = Table("bilinear_projection_powers", """
The same picture with the bilinear filter, continued beyond its border [lm].
""", "fov_deg fov_rad aspect picture_lm")
    with mp.workdps(40):
        for fov_deg, aspect in ((1.0, 3.0), (90.0, 4.0 / 3), (90.0, 64.0), (150.0, 1.0 / 3)):
            fov = fov_deg * DEGREE
            shorter = mp.tan(mpf(fov) / 2)
            x, y = shorter * max(mpf(aspect), 1), shorter / min(mpf(aspect), 1)
            at = lambda i, j: mpf(texel(min(max(i, 0), 3), min(max(j, 0), 2)))
            xs = [-x] + [x * (2 * i - 3) / 4 for i in range(4)] + [x]
            ys = [-y] + [y * (2 * j - 2) / 3 for j in range(3)] + [y]
            sum_ = mpf(0)
            for j in range(4):
                for i in range(5):
                    sum_ += bilinear_cell(xs[i], xs[i + 1], ys[j], ys[j + 1],
                                          (at(i - 1, j - 1), at(i, j - 1), at(i - 1, j), at(i, j)))
            table.add(fov_deg, fov, aspect, sum_)
    return table


def patch_area(corners):
    """Area of the patch p(u, v) through p00, p10, p01, p11: the integral of |dp/du x dp/dv| over the square."""
    p00, p10, p01, p11 = [[mpf(c) for c in p] for p in corners]

    def element(u, v):
        du = [(b - a) * (1 - v) + (d - c) * v for a, b, c, d in zip(p00, p10, p01, p11)]
        dv = [(c - a) * (1 - u) + (d - b) * u for a, b, c, d in zip(p00, p10, p01, p11)]
        n = (du[1] * dv[2] - du[2] * dv[1], du[2] * dv[0] - du[0] * dv[2], du[0] * dv[1] - du[1] * dv[0])
        return sqrt(sum(c * c for c in n))

    # The integrand is smooth far beyond the square: with this many nodes the error is 1e-35.
    nodes = gauss(40)
    return sum(w * z * element(x, y) for x, w in nodes for y, z in nodes)


def gauss(n):
    """Gauss nodes and weights on [0, 1], by Newton's method from the usual start."""
    rule = []
    for k in range(1, n + 1):
        x = cos(pi * (k - mpf(1) / 4) / (n + mpf(1) / 2))
        for _ in range(6):
            p0, p1 = mpf(1), x
            for m in range(2, n + 1):
                p0, p1 = p1, ((2 * m - 1) * x * p1 - (m - 1) * p0) / m
            slope = n * (x * p1 - p0) / (x * x - 1)
            x -= p1 / slope
        rule.append(((1 + x) / 2, 1 / ((1 - x * x) * slope * slope)))
    return rule


def heron(a, b, c):
    """Area of a triangle from its sides."""
    s = (a + b + c) / 2
    return sqrt(s * (s - a) * (s - b) * (s - c))


def areas():
    table = Table("area_powers", """
Area lights of radiance 1, one-sided, of `size` m: pi times the area, integrated over the parts of the shape, or from
the sides of its triangles [lm].
    sphere    radius 1, z from -1/2 to 3/4, swept over 2 rad
    disk      radius 1 with a hole of radius 1/4, swept over 2 rad
    cylinder  radius 1/2, z from 0 to 3, swept over 2 rad
    triangle  (0, 0, 0), (1, 0, 0), (0, 2, 2)
    flat      patch (0, 0, 0), (2, 0, 0), (0, 1, 0), (2, 1, 0)
    bent      patch (0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 1/2)
""", "shape size power_lm")
    numeric = {
        # Rings by the polar angle.
        "sphere": 2 * quad(sin, [mp.acos(mpf(3) / 4), mp.acos(mpf(-1) / 2)]),
        "disk": 2 * quad(lambda r: r, [mpf(1) / 4, 1]),
        # The length of the arc times that of its strips.
        "cylinder": quad(lambda t: sqrt(sin(t) ** 2 + cos(t) ** 2) / 2, [0, 2]) * quad(lambda z: mpf(1), [0, 3]),
        "triangle": heron(mpf(1), sqrt(mpf(8)), mpf(3)),
        "flat": 2 * heron(mpf(1), mpf(2), sqrt(mpf(5))),
    }
    for name, area in numeric.items():
        for exponent in (-60, -30, -20, -10, 0, 10, 20, 30, 60):
            table.add(name, 2.0**exponent, pi * area * mpf(4) ** exponent)
    bent = patch_area(((0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0.5)))
    for exponent in (-20, 0, 20):
        table.add("bent", 2.0**exponent, pi * bent * mpf(4) ** exponent)
    return table


def others():
    table = Table("other_powers", """
Lights of intensity, radiance or illuminance 1 [lm]: a point; radiance from everywhere, and parallel rays, through the
disk of a scene of radius `size` m; a beam of `size` by 3 `size` m.  By the integral over directions, of the sine of the
polar angle, over the disk, of its rings, and the beam's two triangles by their sides.
""", "light size power_lm")
    sphere = 2 * pi * quad(sin, [0, pi])
    for exponent in (-60, -30, -10, 0, 10, 30, 60):
        size = 2.0**exponent
        disk = quad(lambda r: 2 * pi * r, [0, size])
        table.add("point", size, sphere)
        table.add("infinite", size, sphere * disk)
        table.add("distant", size, disk)
        table.add("beam", size, 2 * heron(mpf(size), 3 * mpf(size), sqrt(mpf(10)) * size))
    return table


WEB_VERTICAL = (0, 10, 30, 60, 90, 180)
WEB_HORIZONTAL = (0, 90, 135, 270, 360)


def pictures():
    table = Table("picture_powers", """
A luminaire whose intensity at vertical angle a of 0 10 30 60 90 180 and horizontal angle b of 0 90 135 270 360
degrees is 1 + (7 a + 3 b) mod 11, b = 360 as b = 0, times `size`; and a whole sphere of radius `size` m that shows the
picture of 4 x 3 texels, texel (i, j) max(0, (3 i + 5 j) mod 9 - 2), row 0 about its pole [lm].
""", "light size power_lm")
    for exponent in (-30, 0, 30):
        size = mpf(2) ** exponent
        flux = mpf(0)
        for a0, a1 in zip(WEB_VERTICAL, WEB_VERTICAL[1:]):
            for b0, b1 in zip(WEB_HORIZONTAL, WEB_HORIZONTAL[1:]):
                at = lambda a, b: 1 + (7 * a + 3 * (b % 360)) % 11
                above, below = [mpf(at(a, b0) + at(a, b1)) / 2 for a in (a0, a1)]
                t0, t1 = [pi * a / 180 for a in (a0, a1)]
                flux += (b1 - b0) * pi / 180 * quad(
                    lambda t: (above + (below - above) * (t - t0) / (t1 - t0)) * sin(t), [t0, t1])
        table.add("web", 2.0**exponent, size * flux)
        rows = sum(mpf(sum(texel(i, j) for i in range(4))) / 4 * (cos(pi * j / 3) - cos(pi * (j + 1) / 3))
                   for j in range(3))
        table.add("painted", 2.0**exponent, pi * size**2 * 2 * pi * rows)
    return table


def portals():
    table = Table("portal_powers", """
Portals of `side` by 3 `side` m before a sky of radiance 1, and before the latitude-longitude picture of 8 x 5 texels,
texel (i, j) max(0, (3 i + 5 j) mod 9 - 2): light comes in along the normal n, an axis of the map [lm].
""", "sky n side power_lm")
    w, h = 8, 5
    up = side_on = mpf(0)
    for j in range(h):
        t0, t1 = pi * j / h, pi * (j + 1) / h
        # Integrals of the cosine to +y above the horizon, and of the sine, for the cosine to +x.
        of_row = (sin(min(t1, pi / 2)) ** 2 - sin(min(t0, pi / 2)) ** 2) / 2
        of_sine = ((t1 - sin(2 * t1) / 2) - (t0 - sin(2 * t0) / 2)) / 2
        for i in range(w):
            p0, p1 = 2 * pi * i / w, 2 * pi * (i + 1) / w
            up += texel(i, j) * of_row * (p1 - p0)
            if i < w // 4 or i >= w - w // 4:
                side_on += texel(i, j) * of_sine * (sin(p1) - sin(p0))
    for side in (1e-6, 1.0, 1e6):
        area = 3 * mpf(side) ** 2
        table.add("even", "x", side, pi * area)
        table.add("picture", "y", side, up * area)
        table.add("picture", "x", side, side_on * area)
    return table


def tables():
    yield pictures()
    yield portals()
    yield others()
    yield spots()
    yield projections()
    yield bilinear_projections()
    yield areas()
