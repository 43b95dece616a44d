"""Rows 3 to 6, 8 and 30: flat lights with corners, from the lengths of arcs and without triple products.

Solid angles use l'Huilier's theorem (the sides of the spherical triangle).  Irradiances use Lambert's formula: the sum
over the edges of the angle that each subtends times the cosine of its plane.  Both cancel.  For lights near the plane
of the receiver 60 digits are as few as 16 are for others, so the computation uses 200.
"""
from mpmath import atan, atan2, mp, mpf, pi, sqrt, tan, workdps

from table import Table

DIGITS = 200


def vec(v):
    return [mpf(x) for x in v]


def sub(a, b):
    return [x - y for x, y in zip(a, b)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def norm(a):
    return sqrt(dot(a, a))


def arc(a, b):
    """Angle between two directions."""
    return atan2(norm(cross(a, b)), dot(a, b))


def triangle_solid_angle(a, b, c):
    x, y, z = arc(b, c), arc(c, a), arc(a, b)
    s = (x + y + z) / 2
    return 4 * atan(sqrt(abs(tan(s / 2) * tan((s - x) / 2) * tan((s - y) / 2) * tan((s - z) / 2))))


def solid_angle(corners, receiver):
    """Solid angle of a flat convex polygon [sr]."""
    with workdps(DIGITS):
        p = [sub(vec(c), vec(receiver)) for c in corners]
        return sum(triangle_solid_angle(p[0], p[i], p[i + 1]) for i in range(1, len(p) - 1))


def irradiance(corners, receiver, normal):
    """Irradiance from a flat polygon of radiance 1 that is completely above the horizon; `normal` of any length."""
    with workdps(DIGITS):
        p = [sub(vec(c), vec(receiver)) for c in corners]
        n = vec(normal)
        assert all(dot(q, n) >= 0 for q in p), (corners, receiver, normal)
        total = mpf(0)
        for i, a in enumerate(p):
            b = p[(i + 1) % len(p)]
            m = cross(a, b)
            if norm(m) > 0:
                total += arc(a, b) * dot(m, n) / norm(m)
        return abs(total) / 2


def of_doubles(v):
    return [float(x) for x in v]


def unit(v):
    """Unit vector, each component rounded to the nearest double."""
    n = norm(vec(v))
    return [float(x / n) for x in vec(v)]


def coordinates(names):
    return " ".join(f"{n}_{axis}" for n in names.split() for axis in "xyz")


# Three vectors at right angles, of length 3, exact in floats: their planes contain no coordinate axis.
E1, E2, E3 = (1, 2, 2), (2, 1, -2), (2, -2, 1)


def combine(*terms):
    """Sum of factors times vectors, rounded once."""
    return [float(sum(mpf(k) * mpf(v[i]) for k, v in terms)) for i in range(3)]


def add_polygon(table, first, corners, receiver, normal):
    table.add(*first, *[x for c in corners for x in c], *receiver, *normal, solid_angle(corners, receiver),
              irradiance(corners, receiver, normal))


def small_triangles():
    table = Table("small_triangles", """
Triangles about the origin seen from a receiver 1 m away: a name, corners, receiver and a normal there, solid angle
[sr], irradiance from radiance 1 [lx].
""", f"name {coordinates('a b c receiver normal')} solid_angle_sr irradiance_lx")
    receiver = unit([0.3, -0.5, 0.81])
    normal = unit([-0.2, 0.6, -0.5])
    x, y = unit([0.8, 0.6, 0.07]), unit([-0.5, 0.7, 0.6])
    # 1 in 1000 out of the plane of the receiver.
    edge_on = combine((1, receiver), (1e-3, x))
    shapes = {
        "faced": [((0.1, x), (0.2, y)), ((1, x), (0.1, y)), ((0.2, x), (0.9, y))],
        "slim": [((-0.5, x),), ((0.5, x),), ((0.1, x), (1e-3, y))],
        "oblique": [((0, x),), ((1, edge_on),), ((0.3, edge_on), (0.9, y))],
    }
    for name, shape in shapes.items():
        for exponent in range(1, 16):
            size = mpf(2) ** (-4 * exponent)
            corners = [combine(*[(mpf(k) * size, v) for k, v in corner]) for corner in shape]
            add_polygon(table, [name], corners, receiver, normal)
    return table


def rectangle(corner, x, y):
    """Corners of a rectangle in the order of bilinear patches."""
    p10, p01 = combine((1, corner), (1, x)), combine((1, corner), (1, y))
    return [list(map(float, corner)), p10, p01, combine((1, p10), (1, y))]


def around(r):
    return [r[0], r[1], r[3], r[2]]


def add_rectangle(table, first, corners, receiver, normal):
    table.add(*first, *[x for c in corners for x in c], *receiver, *normal,
              solid_angle(around(corners), receiver), irradiance(around(corners), receiver, normal))


def small_rectangles():
    table = Table("small_rectangles", """
Rectangles about the origin seen from a receiver 1 m away, in planes that contain no axis, exact in doubles: a name,
corners in the order of bilinear patches, receiver and a normal there, solid angle [sr], irradiance from radiance 1 [lx].
""", f"name {coordinates('p00 p10 p01 p11 receiver normal')} solid_angle_sr irradiance_lx")
    receiver = unit([2, -2.25, 1.125])
    normal = unit([-1, 1.5, -0.75])
    for name, width, height in (("faced", 1, 1), ("strip", 1, 2.0**-10)):
        for exponent in range(2, 31):
            size = 2.0**(-2 * exponent)
            x = combine((size * width, E1))
            y = combine((size * height, E2))
            add_rectangle(table, [name], rectangle(combine((-0.25, x), (-0.5, y)), x, y), receiver, normal)
    return table


def small_quadrilaterals():
    table = Table("small_quadrilaterals", """
Flat quadrilaterals that are not parallelograms, otherwise as in small_rectangles.
""", f"name {coordinates('p00 p10 p01 p11 receiver normal')} solid_angle_sr irradiance_lx")
    receiver, normal = unit([2, -2.25, 1.125]), unit([-1, 1.5, -0.75])
    for exponent in range(1, 31):
        size = 2.0**(-2 * exponent)
        corners = [combine((x * size, E1), (y * size, E2))
                   for x, y in ((-0.25, -0.5), (0.75, -0.25), (0, 0.5), (1.25, 0.75))]
        add_rectangle(table, ["kite"], corners, receiver, normal)
    return table


def edge_on_rectangles():
    table = Table("edge_on_rectangles", """
Rectangles of 3.4e-3 to 2e-8 sr that the receiver, at the origin, sees from nearly within their plane.
""", f"name {coordinates('p00 p10 p01 p11 receiver normal')} solid_angle_sr irradiance_lx")
    normal = unit([1, 0.25, 0.25])
    for k in range(10, 25, 2):
        h = 2.0**-k
        add_rectangle(table, ["aside"], rectangle([1, -0.5, h], [1, 0, 0], [0, 1, 0]), [0.0] * 3, normal)
        add_rectangle(table, ["near"], rectangle([2.0**-4, -0.5, h / 8], [1, 0, 0], [0, 1, 0]), [0.0] * 3,
                      unit([1, 0, 2]))
    return table


def hemispheres():
    table = Table("hemisphere_triangles", """
Triangles of corners up to 1e9 seen from above a point of them, down to 1e-20 of their size away.
""", f"name {coordinates('a b c receiver normal')} solid_angle_sr irradiance_lx")
    for size in (1.0, 1e9):
        for exponent in range(0, 21, 2):
            h = size * 10.0**-exponent
            corners = [[-size, -size, 0.0], [2 * size, -size, 0.0], [-size, 2 * size, 0.0]]
            add_polygon(table, ["plain"], corners, [0.0, 0.0, h], [0.0, 0.0, -1.0])
    for exponent in range(2, 17, 2):
        h = 10.0**-exponent
        corners = [[-1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [-1.0, 2.0, 0.0]]
        add_polygon(table, ["beside"], corners, [0.25, -0.5 * h, h], [0.0, 0.0, -1.0])
        add_polygon(table, ["beside_a_corner"], corners, [-1.0 - h, -0.5 * h, h], [0.0, 0.0, -1.0])
    for exponent in range(0, 13, 2):
        size = 1e9
        corners = [combine((-size, E1), (-size, E2)), combine((2 * size, E1), (-size, E2)),
                   combine((-size, E1), (2 * size, E2))]
        receiver = combine((size * 10.0**-exponent, E3))
        add_polygon(table, ["tilted"], corners, receiver, unit([-x for x in E3]))
        far = [[-1.0, -1.0, 0.0], [2.0, -1.0, 0.0], [size, size, 0.0]]
        add_polygon(table, ["far_corner"], far, [0.0, 0.0, 10.0**-exponent], [0.0, 0.0, -1.0])
    return table


def slivers():
    table = Table("sliver_triangles", """
Triangles 2 long and down to 1e-15 high, seen from about as far away as they are high and nearly from within their
plane, by a receiver that faces them.
""", f"name {coordinates('a b c receiver normal')} solid_angle_sr irradiance_lx")
    for exponent in range(5, 51, 5):
        high = 2.0**-exponent
        corners = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.25, high, 0.0]]
        for beside in (1, 8):
            add_polygon(table, ["beside"], corners, [0.125, -beside * high, high * 2.0**-12], [0.0, 0.0, -1.0])
    return table


def grazing():
    table = Table("grazing_polygons", """
Rectangles and triangles (the first three corners) seen from beside, h above their plane, by a receiver that faces them.
""", f"name height_m {coordinates('p00 p10 p01 p11 receiver normal')} "
      "solid_angle_sr irradiance_lx triangle_solid_angle_sr triangle_irradiance_lx")

    def add(name, h, corners, receiver, normal):
        first = corners[:3]
        table.add(name, h, *[x for c in corners for x in c], *receiver, *normal,
                  solid_angle(around(corners), receiver), irradiance(around(corners), receiver, normal),
                  solid_angle(first, receiver), irradiance(first, receiver, normal))

    plane = rectangle([1, -0.5, 0], [1, 0, 0], [0, 1, 0])
    tilted = rectangle(combine((1, E1), (-0.5, E2)), E1, E2)
    for exponent in range(3, 21):
        h = 10.0**-exponent
        add("plain", h, plane, [0.0, 0.0, h], [1.0, 0.0, 0.0])
        add("tilted", h, tilted, combine((h, E3)), unit(E1))
    return table


def tables():
    yield small_triangles()
    yield small_rectangles()
    yield small_quadrilaterals()
    yield edge_on_rectangles()
    yield hemispheres()
    yield slivers()
    yield grazing()
