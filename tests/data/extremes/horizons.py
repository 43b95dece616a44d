"""Rows 1, 4, 5, 6, 8: lights that the receiver's horizon cuts, by slices of azimuth.

Take a slice between two meridians, from the horizon up to the height z on the unit sphere.  Its irradiance at the
receiver is z^2 / 2 times the angle between the meridians.  So the irradiance is half the integral of z^2 dphi along the
edge of the visible part; the horizon itself contributes nothing.  Where the zenith is visible, it is pi less that.  The
edges are integrated numerically.  None of them passes near the zenith, where the angle changes fast.
"""
from mpmath import acos, asin, cos, cos_sin, mpf, pi, quad, sin, sqrt, workdps

from polygons import coordinates, cross, dot, norm, sub, unit, vec
from table import Table


def along(path, n, ends):
    """Integrates z^2 dphi over a path, which is a function to a point and the derivative there."""
    def integrand(t):
        p, slope = path(t)
        aside = cross(n, p)
        return dot(p, n) ** 2 / dot(p, p) * dot(aside, slope) / dot(aside, aside)
    return quad(integrand, ends, method="gauss-legendre")


def edge(a, b, n):
    """The same integral along the part of a straight edge that is above the horizon; 0 if none is.

    Its point is a + t e, so each product of the integrand is a polynomial of t.
    """
    ua, ub = dot(a, n), dot(b, n)
    if ua <= 0 and ub <= 0:
        return mpf(0)
    e = sub(b, a)
    crossing = ua / (ua - ub) if (ua < 0) != (ub < 0) else None
    first = crossing if ua < 0 else mpf(0)
    last = crossing if ub < 0 else mpf(1)
    # Finer towards the nearest point of the edge, which may be very near.
    nearest = min(max(-dot(a, e) / dot(e, e), first), last)
    share = norm([x + nearest * y for x, y in zip(a, e)]) / norm(e)
    ends = {first, last, nearest}
    while share < 1:
        ends |= {x for x in (nearest - share, nearest + share) if first < x < last}
        share *= 4
    aside_a, aside_e = cross(n, a), cross(n, e)
    aa, ae, ee, ue = dot(a, a), 2 * dot(a, e), dot(e, e), dot(e, n)
    ss, st, tt = dot(aside_a, aside_a), 2 * dot(aside_a, aside_e), dot(aside_e, aside_e)
    def integrand(t):
        return (ua + t * ue) ** 2 / ((aa + t * (ae + t * ee)) * (ss + t * (st + t * tt)))
    return dot(n, cross(a, e)) * quad(integrand, sorted(ends), method="gauss-legendre")


def polygon(corners, receiver, normal, edges):
    """Irradiance of the part above the horizon, which must not contain the zenith.  `edges` holds known integrals."""
    n = [x / norm(vec(normal)) for x in vec(normal)]
    p = [sub(vec(c), vec(receiver)) for c in corners]
    total = mpf(0)
    for i, a in enumerate(p):
        b = p[(i + 1) % len(p)]
        key = (*a, *b)
        if key not in edges:
            edges[key] = edge(a, b, n)
        total += edges[key]
    return abs(total) / 2


def add_polygon(table, name, size, corners, receiver, normal):
    edges = {}
    table.add(name, size, *[float(x) for c in corners for x in c], *receiver, *normal,
              polygon([corners[0], corners[1], corners[3], corners[2]], receiver, normal, edges),
              polygon(corners[:3], receiver, normal, edges))


def polygons():
    table = Table("horizon_polygons", f"""
Rectangles and triangles (the first three corners) that the receiver's horizon cuts: small ones; wide ones of which a
corner or a strip of the given size is left; ones that are seen from the given height above their plane; and a wide one
that is almost behind the receiver.
""", f"name size {coordinates('p00 p10 p01 p11 receiver normal')} irradiance_lx triangle_irradiance_lx")
    zenith, origin = [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]

    def rectangle(corner, x, y):
        return [corner, [a + b for a, b in zip(corner, x)], [a + b for a, b in zip(corner, y)],
                [a + b + c for a, b, c in zip(corner, x, y)]]

    for k in range(0, 49, 4):
        s = 2.0**-k
        add_polygon(table, "small", s, rectangle([1.0, -0.5 * s, -0.25 * s], [0.0, s, 0.25 * s], [0.0, -0.25 * s, s]),
                    origin, zenith)
        add_polygon(table, "slanted", s, rectangle([1.0, -0.5 * s, -0.75 * s], [s, s, 0.0], [0.0, 0.0, s]), origin,
                    zenith)
    tilt = unit([0.3, -0.5, 0.81])
    for k in range(0, 13, 4):
        s = 2.0**-k
        corner = [c - 0.5 * s for c in unit([0.81, 0.0, -0.3])]
        add_polygon(table, "tilted", s, rectangle(corner, [0.25 * s, s, 0.0], [-0.25 * s, 0.125 * s, s]), origin, tilt)
    for k in range(1, 13, 2):
        s = 2.0**(-3 * k)
        add_polygon(table, "strip", s, rectangle([1.0, -2.0, -1.0], [0.5, 4.0, 0.0], [0.0, 0.0, 1.0 + s]), origin, zenith)
        add_polygon(table, "corner", s, rectangle([1.0, 0.5, s], [0.5, -1.0, -1.0], [0.0, 1.0, -2.0]), origin, zenith)
        add_polygon(table, "grazing", s, rectangle([1.0, -0.5, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]), [0.0, 0.0, s],
                    [0.28, 0.96, 0.0])
        add_polygon(table, "beside", s, rectangle([0.0625, -0.5, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]), [0.0, 0.0, s],
                    [-0.6, 0.8, 0.0])
    for k in range(1, 9):
        s = 2.0**-k
        add_polygon(table, "turned_away", s, rectangle([-1.0, -1.0, 1.0], [600.0, 0.0, 0.0], [0.0, 600.0, 0.0]), origin,
                    unit([s, 0.25 * s, -1.0]))
    return table


def round_edge(center, x, y, n, whole):
    """Integral along the edge of the disk about `center`.  The radius x rises, the radius y is level."""
    rise, up = dot(x, n), dot(center, n)
    # The arc beyond a small part of the turn is equally small, so 1 - cos uses the half angle.
    end = pi if whole else 2 * asin(sqrt((rise + up) / (2 * rise)))
    def path(t):
        c, s = cos_sin(t)
        return ([p + c * a + s * b for p, a, b in zip(center, x, y)], [c * b - s * a for a, b in zip(x, y)])
    return abs(along(path, n, [-end, -end / 2, 0, end / 2, end])) / 2


def disk(radius, center, axis, normal):
    """Irradiance at the origin.  The visible part must not contain the zenith."""
    n, axis = vec(normal), vec(axis)
    n, axis = [c / norm(n) for c in n], [c / norm(axis) for c in axis]
    rising = [a - b * dot(n, axis) for a, b in zip(n, axis)]
    x = [mpf(radius) * c / norm(rising) for c in rising]
    return round_edge(vec(center), x, cross(axis, x), n, False)


def disks():
    table = Table("horizon_disks", f"""
Disks about a centre in the plane of a normal, the axis, seen from the origin by a receiver whose horizon cuts them.
""", f"name size radius_m {coordinates('center axis normal')} irradiance_lx")

    def add(name, size, radius, center, axis, normal):
        table.add(name, size, radius, *center, *axis, *normal, disk(radius, center, axis, normal))

    down = [0.0, 0.0, -1.0]
    for k in range(1, 46, 8):
        s = 2.0**-k
        for share in (-0.75, -0.25, 0.5):
            add("small", s, s, [share * s, 0.25, 1.0], down, [1.0, 0.0, 0.0])
    for k in range(1, 13):
        s = 2.0**(-3 * k)
        add("peeking", s, 1.0, [s - 1.0, 0.25, 1.0], down, [1.0, 0.0, 0.0])
        add("grazing", s, 1.0, [0.25, 2.0, s], down, [1.0, 0.0, 0.0])
        add("beside", s, 1.0, [0.25, 1.0625, s], down, [1.0, 0.0, 0.0])
    for k in range(0, 9):
        s = 2.0**-k
        add("tilted", s, s, unit([2.0, -1.0, 0.125 * s]), unit([-2.0, 1.5, 1.0]), unit([0.0, 0.25 * s, 1.0]))
    for k in range(1, 9):
        s = 2.0**-k
        add("turned_away", s, 600.0, [0.0, 0.0, 1.0], down, unit([s, 0.0, -1.0]))
    return table


def cap(axis, half, normal):
    n, axis = vec(normal), [c / norm(vec(axis)) for c in vec(axis)]
    rising = [a - b * dot(n, axis) for a, b in zip(n, axis)]
    x = [sin(half) * c / norm(rising) for c in rising]
    lx = round_edge([cos(half) * c for c in axis], x, cross(axis, x), n, False)
    return pi - lx if dot(axis, n) > cos(half) else lx


def shares():
    """Heights of the middle above the horizon, in sines of half-angles."""
    return [-(1 - 2.0**-20), -0.875, -0.25, 0.0, 0.25, 0.5]


def spheres():
    table = Table("horizon_spheres", """
Spheres about (x, 0, z) seen from the origin by a receiver that faces along +z, whose horizon cuts them.
""", "radius_m x z irradiance_lx")
    for k in range(1, 42, 8):
        for share in shares():
            radius = 2.0**-k
            center = [1.0, 0.0, share * radius]
            table.add(radius, center[0], center[2], cap(center, asin(radius / norm(vec(center))), [0.0, 0.0, 1.0]))
    for k in range(1, 13, 2):
        for x, z in ((0.96, -0.28), (0.8, -0.6), (0.28, -0.96), (0.96, 0.28), (0.6, 0.8)):
            center = [x * (1 + 2.0**(-3 * k)), 0.0, z * (1 + 2.0**(-3 * k))]
            if abs(z) * (1 + 2.0**(-3 * k)) < 1:
                table.add(1.0, center[0], center[2], cap(center, asin(1 / norm(vec(center))), [0.0, 0.0, 1.0]))
    return table


def suns():
    table = Table("horizon_suns", """
Suns towards (x, 0, z) that give 1 lx on a surface facing them, seen by a receiver that faces along +z, whose horizon
cuts them.
""", "diameter_rad x z irradiance_lx")
    for diameter in [10.0**-k for k in range(0, 15, 2)] + [2.0, 3.0, 3.1, 3.141592653589793]:
        for share in shares():
            half = mpf(diameter) / 2
            x, z = 1.0, float(share * sin(half)) if diameter < 3.14 else share
            if share == 0 and diameter >= 2:  # its edge is near the zenith
                continue
            if abs(z) / sqrt(x * x + mpf(z) ** 2) >= sin(half):
                continue
            table.add(diameter, x, z, cap([x, 0.0, z], half, [0.0, 0.0, 1.0]) / (pi * sin(half) ** 2))
    return table


def tables():
    # The quadrature neglects what is below the last digit of 1.
    with workdps(60):
        yield from (polygons(), disks(), spheres(), suns())
