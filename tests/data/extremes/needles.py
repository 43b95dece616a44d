"""Row 34: thin triangles.  Area by Heron's formula, solid angle from the angles of the spherical triangle."""
from mpmath import acos, mpf, pi, sqrt

from table import Table


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def length(a):
    return sqrt(dot(a, a))


def area(p, q, r):
    a, b, c = length(minus(q, p)), length(minus(r, q)), length(minus(p, r))
    s = (a + b + c) / 2
    return sqrt(s * (s - a) * (s - b) * (s - c))


def solid_angle(corners):
    """Solid angle, as the excess of the angles between the planes through the eye."""
    excess = -pi
    for i in range(3):
        a, b, c = corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]
        n, m = cross(a, b), cross(a, c)
        excess += acos(dot(n, m) / (length(n) * length(m)))
    return excess


def tables():
    needles = Table("needles", """
Triangles a, b, c of which one side is `ratio` times as long as the height over it, their area, and their solid
angle from e.
""", "ratio ax ay az bx by bz cx cy cz ex ey ez area_m2 solid_angle_sr")
    for exponent in range(3, 15):
        width = 2.0 ** -round(exponent * 3.321928)
        for a, b, c, e in (
                ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.5, width, 0.0), (0.25, 0.5, 1.0)),
                ((0.0, 0.0, 0.0), (1.0, 1.0, 0.5), (0.0, width, 0.0), (0.5, -1.0, 1.5)),
                ((-0.5, 0.0, 1.0), (0.5, 0.0, 1.0), (2.0, width, 1.0), (0.0, 0.25, 0.0))):
            exact = [[mpf(x) for x in p] for p in (a, b, c, e)]
            seen = [minus(p, exact[3]) for p in exact[:3]]
            needles.add(f"1e{exponent}", *a, *b, *c, *e, area(*exact[:3]), solid_angle(seen))
    yield needles
