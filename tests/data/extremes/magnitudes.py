"""Row 9: lights and receivers of all magnitudes, from lengths and angles.  The code uses squares and products."""
from mpmath import acos, asin, atan2, cos, hypot, matrix, mp, mpf, norm, pi, sin

from table import Table, as_float


def pairs():
    """Sizes and distances from 1e-26 to 1e22, and some far beyond the range of floats."""
    for e in range(-26, 23, 3):
        for ratio in (-12, -6, -1, 0, 1, 6, 12, 24, 36):
            if -26 <= e + ratio <= 22:
                yield 10.0**e, 10.0 ** (e + ratio)
    for e in range(-100, 101, 20):
        yield 10.0**e, 3 * 10.0**e
        yield 10.0**e, 10.0 ** (e + 12)


def held(x):
    """Rounded to a float where it is in range of floats, otherwise the double unchanged."""
    return as_float(x) if x == 0 or 1e-37 < abs(x) < 1e38 else x


def vec(*components):
    return matrix([mpf(c) for c in components])


def dot(a, b):
    return sum(a[i] * b[i] for i in range(3))


def cross(a, b):
    return matrix([a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3] for i in range(3)])


def angle(a, b):
    """The angle, from half the chord, so that small angles keep their digits."""
    u, v = a / norm(a), b / norm(b)
    return 2 * atan2(norm(u - v), norm(u + v))


def point_value(position, receiver):
    to_receiver = vec(*receiver) - vec(*position)
    distance = hypot(hypot(to_receiver[0], to_receiver[1]), to_receiver[2])
    return distance, angle(to_receiver, vec(0, 0, 1))


def points():
    table = Table("magnitude_points", """
A light at `px`, `py`, `pz` that points to +z and receivers before it: one over the distance squared, and that times the
smoothstep fall-off of a cone of 60 degrees that begins at its axis.
""", "px py pz x y z per_square falloff_per_square")
    for size, far in pairs():
        position = [held(c * size) for c in (-0.3, -0.2, -0.7)]
        receiver = [held(c * far) for c in (0.2, 0.3, 0.9)]
        distance, theta = point_value(position, receiver)
        # cos a - cos b = 2 sin((b + a) / 2) sin((b - a) / 2)
        cone = pi / 3
        x = sin((cone + theta) / 2) * sin((cone - theta) / 2) / sin(cone / 2) ** 2
        table.add(*position, *receiver, 1 / distance / distance, x * x * (3 - 2 * x) / distance / distance)
    return table


def seen(point, normal, area, receiver):
    """Density by solid angle of a point chosen uniformly by area, from the angles that its surroundings subtend."""
    to_receiver = vec(*receiver) - point
    tilt = angle(to_receiver, normal)
    return norm(to_receiver) ** 2 / abs(cos(tilt)) / area


def girard(corners, receiver):
    """Solid angle of a triangle, as the excess of its three dihedral angles."""
    with mp.workdps(400):
        a, b, c = (c - vec(*receiver) for c in corners)
        ab, bc, ca = cross(a, b), cross(b, c), cross(c, a)
        return angle(ab, -ca) + angle(bc, -ab) + angle(ca, -bc) - pi


def shapes():
    table = Table("magnitude_shapes", """
Shapes of one size about zero as receivers at (x, y, z) see them: their area, and the density of a point chosen by area:
of a triangle (0, 0, 0) (s, 0, s / 4) (s / 8, s, 0) and of a rectangle s by s / 2 in the plane z = 0 the corner at zero, of a disk of radius s there its middle, of a cylinder of radius s from z = -s to s the point (s, 0, -s).
For a sphere of radius s: the density in the cone that it subtends, or over all directions from inside.
""", "shape size x y z area_m2 pdf_per_sr")
    for size, far in pairs():
        s = mpf(held(size))
        size = float(s)
        receiver = [held(c * far) for c in (0.3, 0.2, 0.9)]
        corners = [vec(0, 0, 0), vec(size, 0, size / 4), vec(size / 8, size, 0)]
        normal = cross(corners[1], corners[2])
        area = norm(normal) / 2
        table.add("triangle", size, *receiver, area, seen(corners[0], normal, area, receiver))
        up = vec(0, 0, 1)
        table.add("rectangle", size, *receiver, s * s / 2, seen(vec(0, 0, 0), up, s * s / 2, receiver))
        table.add("disk", size, *receiver, pi * s * s, seen(vec(0, 0, 0), up, pi * s * s, receiver))
        table.add("cylinder", size, *receiver, 4 * pi * s * s,
                  seen(vec(size, 0, -size), vec(1, 0, 0), 4 * pi * s * s, receiver))
        distance = norm(vec(*receiver))
        if abs(distance / s - 1) > 0.01:
            within = 4 * pi if distance < s else 4 * pi * sin(asin(s / distance) / 2) ** 2
            table.add("sphere", size, *receiver, 4 * pi * s * s, 1 / within)
    return table


def solid_angles():
    table = Table("magnitude_solid_angles", """
The triangle and the rectangle of magnitude_shapes: the solid angle that they subtend.
""", "shape size x y z solid_angle_sr")
    for exponent in range(-26, 23, 3):
        for ratio in (0.03, 0.5, 3.0, 40.0):
            size = held(10.0**exponent)
            receiver = [held(c * ratio * 10.0**exponent) for c in (0.3, 0.2, 0.9)]
            a, b, c, d = vec(0, 0, 0), vec(size, 0, 0), vec(size, size / 2, 0), vec(0, size / 2, 0)
            triangle = girard([a, vec(size, 0, size / 4), vec(size / 8, size, 0)], receiver)
            table.add("triangle", size, *receiver, +triangle)
            table.add("rectangle", size, *receiver, +(girard([a, b, c], receiver) + girard([a, c, d], receiver)))
    return table


def portals():
    table = Table("magnitude_portals", """
A portal s by s / 2 from zero in the plane z = 0, seen from (x, y, z) before it: the density of the direction to its middle
where directions are chosen uniformly in the angles about its two sides.
""", "size x y z pdf_per_sr")
    for exponent in range(-26, 23, 3):
        size = held(10.0**exponent)
        # So far away that the whole portal lies in one cell of any division of the angles.
        for ratio in (2e3, 1e6, 1e9):
            receiver = [held(c * ratio * 10.0**exponent) for c in (0.31, 0.23, -0.9)]
            if max(abs(c) for c in receiver) > 1e37:
                continue
            x, y, z = (mpf(c) for c in receiver)
            s = mpf(size)
            across = abs(atan2(s - x, -z) - atan2(-x, -z))
            up = abs(atan2(s / 2 - y, -z) - atan2(-y, -z))
            wx, wy, wz = s / 2 - x, s / 4 - y, -z
            l = norm(matrix([wx, wy, wz]))
            # The lines of equal angles meet at right angles only on the axis, so the sines of both angles enter.
            to_x, to_y = acos(wx / l), acos(wy / l)
            table.add(size, *receiver, (wz / l) / (sin(to_x) * sin(to_y)) ** 2 / (across * up))
    return table


def tables():
    yield points()
    yield shapes()
    yield solid_angles()
    yield portals()
