"""Row 25: small angles, computed from half chords.  The code uses arc tangents."""
from mpmath import asin, mpf, pi

from polygons import norm, sub, vec
from table import Table


def unit_of(v):
    return [x / norm(v) for x in v]


def angle(a, b):
    return 2 * asin(norm(sub(unit_of(a), unit_of(b))) / 2)


def tables():
    hinges = Table("hinges", """
Two triangles with a common edge, their normals (0, 0, 1) and along (0, t, 1): the widest angle between either and the
mean of both by area [rad].  And the polar angle [degrees] of the direction (t, 0, 1) times the square of its cosine.
""", "t widest_rad degrees_by_square")
    for k in range(1, 81):
        t = 2.0**-k * (1 + (k % 3) / 8)
        first, second = vec([0, 0, 1]), vec([0, t, 1])
        mean = [a + b for a, b in zip(first, second)]
        widest = max(angle(first, mean), angle(second, mean))
        polar = angle(vec([t, 0, 1]), first)
        hinges.add(t, widest, polar * 180 / pi / (1 + mpf(t) ** 2))
    yield hinges
