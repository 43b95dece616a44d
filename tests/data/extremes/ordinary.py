"""Lights and receivers of ordinary sizes: the references of tests/bench/precision_bench.cpp for float and double.

Solid angles use the formulas of the other scripts: l'Huilier's theorem for triangles, corners from the foot for
rectangles, the half-angle for spheres, a contour integral for disks.
"""
from math import floor

from mpmath import acosh, asin, atan2, cos, mpf, pi, sin, sqrt

from polygons import dot, norm, solid_angle, sub, vec
from powers import rectangle_sr
from round_lights import disk
from spots import angle_between, share
from table import Table, as_float

COUNT = 40
RADIUS, CONE, START = 0.005, 1.2, 0.5


def on_grid(x):
    """Rounds so that a float holds the value, and a double holds it 5 km away."""
    return floor(float(x) * 2**20 + 0.5) / 2**20


def fraction(k, step):
    return k * step % 1


def disk_solid_angle(x, y, depth):
    radius, offset = mpf("0.5"), sqrt(mpf(x) ** 2 + mpf(y) ** 2)
    # The rule's error falls by exp(-strip) a step; in a strip of this width the integrand is analytic.
    strip = acosh((radius**2 + offset**2 + mpf(depth) ** 2) / (2 * radius * max(offset, mpf("1e-9"))))
    return disk(radius, offset, mpf(depth), [0, 0, 1], steps=int(80 / min(strip, mpf(1))) + 1)[0]


def cylinder_estimate(receiver, ux, uy):
    """Value over density of the point chosen by area at (ux, uy), the fractions of height and turn."""
    turn = 2 * pi * mpf(uy)
    normal = [cos(turn), sin(turn), mpf(0)]
    point = [mpf(RADIUS) * normal[0], mpf(RADIUS) * normal[1], mpf(RADIUS) * (2 * mpf(ux) - 1)]
    way = sub(vec(receiver), point)
    area = 4 * pi * mpf(RADIUS) ** 2
    return area * dot(way, normal) / norm(way) / dot(way, way)


def tables():
    table = Table("ordinary_lights", """
Lights about the origin, of radiance or intensity 1, that shine down: a spot's half-angle 1.2 and full to 0.5; a
rectangle of 1 m, the triangle of its corners (-1/2, -1/2), (-1/2, 1/2), (1/2, -1/2), a disk of radius 1/2; a sphere and
an upright cylinder of radius 5 mm, the cylinder 1 cm high.  Receivers at (x, y, z), exact in floats, and exact in
doubles 5 km away; a sample value, exact in floats.  For point and spot the illuminance on a surface that faces them
[lx]; for the cylinder the value over the density of the point at ux of its height and uy of a turn [lx]; for all others
the solid angle [sr].
""", "light x y z ux uy truth")
    for k in range(COUNT):
        depth = on_grid(0.01 * 1600 ** ((k + 0.5) / COUNT))
        x, y = [on_grid((2 * fraction(k + 0.5, step) - 1) * depth) for step in (0.6180339887498949, 0.7548776662466927)]
        at = [x, y, -depth]
        ux = as_float(fraction(k + 0.25, 0.5698402909980532))
        # On the visible side.
        facing = float(atan2(y, x) / (2 * pi)) + 0.3 * (fraction(k, 0.4142135623730951) - 0.5)
        uy = as_float(facing % 1)
        d2 = dot(vec(at), vec(at))
        corners = [[-0.5, -0.5, 0], [-0.5, 0.5, 0], [0.5, -0.5, 0]]
        truths = {
            "point": 1 / d2,
            "spot": share(angle_between((0, 0, -1), at), mpf(START), mpf(CONE)) / d2,
            "triangle": solid_angle(corners, at),
            "rectangle": rectangle_sr(*[(mpf(c) + e * mpf("0.5")) / mpf(depth) for c in (x, y) for e in (-1, 1)]),
            "sphere": 4 * pi * sin(asin(mpf(RADIUS) / sqrt(d2)) / 2) ** 2,
            "disk": disk_solid_angle(x, y, depth),
            "cylinder": cylinder_estimate(at, ux, uy),
        }
        for light, truth in truths.items():
            if truth > 0:
                table.add(light, *at, ux, uy, truth)
    yield table
