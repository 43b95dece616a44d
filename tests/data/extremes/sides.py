"""Row 27: which side of an area light emits under mirrors, by pbrt-v4's rule for the normals that it samples.

Triangles and patches [Pharr23, 6.5 and 6.6]: the cross product of the edges in world space.  Where the mesh has
normals, it is turned to their side.  They transform by the inverse transpose, and ReverseOrientation reverses them.
Without normals, ReverseOrientation or a transform that swaps handedness reverses it, but both together do not.
Spheres, disks and cylinders [Pharr23, 6.2 to 6.4]: the outward normal of object space (+z for a disk) transforms by the
inverse transpose, and ReverseOrientation reverses it.  A diffuse light emits on the side of its normal.
[Pharr23, 12.4]
"""
from fractions import Fraction

from table import Table


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def columns(m):
    return [[row[j] for row in m] for j in range(3)]


def determinant(m):
    x, y, z = columns(m)
    return dot(cross(x, y), z)


def linear(m, v):
    return [dot(row[:3], v) for row in m]


def point(m, p):
    return [dot(row[:3], p) + row[3] for row in m]


def normal(m, n):
    """Transforms a normal by the inverse transpose: cross products of the columns of m over the determinant."""
    x, y, z = columns(m)
    d = determinant(m)
    return [sum(c[i] * k for c, k in zip((cross(y, z), cross(z, x), cross(x, y)), n)) / d for i in range(3)]


FLAT = {
    "triangle": [(0, 0, 0), (1, 0, 0), (0, 1, 0)],
    "patch": [(-1, -1, 0), (1, -1, 0), (-1, 1, 0), (1, 1, 0)],
}
NORMALS = {"none": None, "front": (0, 0, 1), "back": (0, 0, -1), "leaning": (2, -1, 1)}

#: For a point of the shape, in object space: the point, its outward normal, a receiver before it and one behind it.
SURFACES = {
    "triangle": ((0.25, 0.25, 0), (0, 0, 1), (0.25, 0.25, 0.5), (0.25, 0.25, -0.5)),
    "patch": ((0, 0, 0), (0, 0, 1), (0, 0, 0.5), (0, 0, -0.5)),
    "disk": ((0, 0, 0), (0, 0, 1), (0, 0, 0.5), (0, 0, -0.5)),
    "sphere": ((0, 0, 1), (0, 0, 1), (0, 0, 3), (0, 0, 0.25)),
    "cylinder": ((1, 0, 0), (1, 0, 0), (3, 0, 0), (0.25, 0, 0)),
}


def turned(m):
    """A rotation about z by the angle of the 3-4-5 triangle, then one about x, then a translation."""
    for r in ([[0.6, -0.8, 0], [0.8, 0.6, 0], [0, 0, 1]], [[1, 0, 0], [0, 0.28, -0.96], [0, 0.96, 0.28]]):
        m = [[dot(row, [k[j] for k in m]) for j in range(3)] for row in r]
    return [row + [shift] for row, shift in zip(m, (1.0, 2.0, -3.0))]


def diagonal(x, y, z):
    return [[x, 0, 0], [0, y, 0], [0, 0, z]]


EQUAL = [(x, y, z) for x in (1, -1) for y in (1, -1) for z in (1, -1)] + [(-2, 2, 2), (-0.001, -0.001, -0.001)]
UNEQUAL = [(-1, 2, 3), (1, 1, -1000), (-0.001, 1, 1)]


def transforms(shape):
    for scales in EQUAL:
        yield turned(diagonal(*scales))
    if shape == "cylinder":
        for scales in ((1, 1, -1000), (-2, 2, 3)):
            yield turned(diagonal(*scales))
    elif shape != "sphere":
        for scales in UNEQUAL:
            yield turned(diagonal(*scales))
        yield turned([[1, 0.5, 0.25], [0, -1, 2], [0, 0, 1]])


def tables():
    table = Table("emitting_sides", """
Area lights under the transform m: the shape, its normals, reversed or not; whether light reaches (x, y, z), and whether
it would by the cross product in world space alone, reversed by ReverseOrientation.
""", "shape normals reversed m00 m01 m02 m03 m10 m11 m12 m13 m20 m21 m22 m23 x y z lit by_winding")
    for shape, (at, outward, *receivers) in SURFACES.items():
        for name in NORMALS if shape in FLAT else ["none"]:
            for reverse in (False, True):
                for floats in transforms(shape):
                    m = [[Fraction(x) for x in row] for row in floats]
                    swaps = determinant(m) < 0
                    mapped = normal(m, outward)
                    if shape in FLAT:
                        corners = [point(m, p) for p in FLAT[shape]]
                        winding = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]))
                        n = winding
                        if NORMALS[name]:
                            side = normal(m, NORMALS[name])
                            side = [-c for c in side] if reverse else side
                            n = n if dot(n, side) > 0 else [-c for c in n]
                        elif reverse != swaps:
                            n = [-c for c in n]
                    else:
                        n = [-c for c in mapped] if reverse else mapped
                        winding = [-c for c in mapped] if swaps else mapped
                    winding = [-c for c in winding] if reverse else winding
                    for r in receivers:
                        r = [float(c) for c in point(m, r)]
                        way = minus([Fraction(c) for c in r], point(m, at))
                        table.add(shape, name, str(int(reverse)), *[float(c) for row in floats for c in row], *r,
                                  str(int(dot(n, way) > 0)), str(int(dot(winding, way) > 0)))
    yield table
