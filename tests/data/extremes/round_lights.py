"""Rows 3, 6 and 8: disks and cylinders, by contour integrals along the visible parts of their edges.

Irradiance is half the integral of n . (p x dp) / |p|^2.  The solid angle is the integral of (1 - cos theta) dphi about
the normal of a disk through its foot, where theta and phi are the angles of the edge.  Where the integrands are periodic
and analytic, the trapezium rule converges geometrically.  Where they are analytic between their ends, Gauss's rule does.
"""
from mpmath import acos, cos, cos_sin, mpf, pi, quad, sin, sqrt, workdps

from polygons import E1, E3, arc, combine, coordinates, cross, dot, norm, sub, unit, vec
from table import Table


def disk(radius, offset, height, normal, steps=240):
    """Solid angle and irradiance at the origin of a disk about (offset, 0, height)."""
    with workdps(100):
        sr = lx = mpf(0)
        n = vec(normal)
        for k in range(steps):
            t = 2 * pi * k / steps
            p = [offset + radius * cos(t), radius * sin(t), height]
            d = [-radius * sin(t), radius * cos(t), mpf(0)]
            rho2 = p[0] ** 2 + p[1] ** 2
            sr += (1 - height / sqrt(rho2 + height ** 2)) * (p[0] * d[1] - p[1] * d[0]) / rho2
            lx += dot(n, cross(p, d)) / dot(p, p) / 2
        return abs(sr * 2 * pi / steps), abs(lx * 2 * pi / steps)


def disks():
    table = Table("disks", """
Disks in the plane z = height_m about (offset_m, 0) seen from the origin by a receiver with a normal: small, grazing,
and so near that they cover the hemisphere.  Solid angle [sr], irradiance from radiance 1 [lx].
""", "name radius_m offset_m height_m normal_x normal_y normal_z solid_angle_sr irradiance_lx")

    def add(name, radius, offset, height, normal):
        table.add(name, radius, offset, height, *normal, *disk(mpf(radius), mpf(offset), mpf(height), normal))

    for k in range(1, 16):
        add("small", 10.0**-k, 0.5, 0.75, unit([0.5, 0.25, 1]))
    for k in range(3, 21):
        add("grazing", 1.0, 3.0, 10.0**-k, [1.0, 0.0, 0.0])
    for offset in (0.0, 0.5):
        for k in range(0, 21, 2):
            add("low", 1e9, offset * 1e9, 1e9 * 10.0**-k, [0.0, 0.0, 1.0])
    return table


def cylinder(radius, z_min, z_max, receiver_x, normal):
    """Irradiance from the outside at (receiver_x, 0, 0)."""
    with workdps(90):
        n = vec(normal)
        tangent = acos(radius / receiver_x)
        origin = [receiver_x, mpf(0), mpf(0)]

        def between_rings(t):
            c, s = cos_sin(t)
            slope, total = [-radius * s, radius * c, mpf(0)], mpf(0)
            for sign, z in ((1, z_min), (-1, z_max)):
                p = sub([radius * c, radius * s, z], origin)
                total += sign * dot(n, cross(p, slope)) / dot(p, p)
            return total

        def line(t):
            a = sub([radius * cos(t), radius * sin(t), z_min], origin)
            b = sub([radius * cos(t), radius * sin(t), z_max], origin)
            m = cross(a, b)
            return arc(a, b) * dot(n, m) / norm(m)

        total = quad(between_rings, [-tangent, 0, tangent])
        return abs(total + line(tangent) - line(-tangent)) / 2, tangent


def cylinders():
    table = Table("cylinders", """
Upright cylinders about the z axis seen from (receiver_m, 0, 0) from outside: small, and from just above the tangent of
one that lies beyond.  The angle from the x axis up to which they are seen, irradiance from radiance 1 on a surface with
a normal [lx].
""", "name radius_m z_min_m z_max_m receiver_m normal_x normal_y normal_z tangent_rad irradiance_lx")

    def add(name, radius, low, high, receiver, normal):
        lx, tangent = cylinder(mpf(radius), mpf(low), mpf(high), mpf(receiver), normal)
        table.add(name, radius, low, high, receiver, *normal, tangent, lx)

    for k in range(1, 16):
        size = 10.0**-k
        add("small", size, -size, 2 * size, 1.0, unit([-1, 0.25, 0.5]))
    for k in range(1, 10):
        add("grazing", 1.0, 1.0, 2.0, 1.0 + 10.0**-k, [0.0, 0.0, 1.0])
    return table


def tubes():
    table = Table("tubes", """
Cylinders about the z axis from z = 1 to 2 seen from the origin: their inside, at cosines of radius / distance.  Solid
angle [sr], irradiance from radiance 1 on a surface that faces along z [lx]: differences of the values of the disks at both
ends.
""", "radius_m solid_angle_sr irradiance_lx")
    with workdps(120):
        for k in range(1, 21):
            radius = 10.0**-k
            r = mpf(radius)
            table.add(radius, 2 * pi * (2 / sqrt(4 + r * r) - 1 / sqrt(1 + r * r)),
                      pi * r * r * (1 / (1 + r * r) - 1 / (4 + r * r)))
    return table


def tilted_disks():
    table = Table("tilted_disks", """
Disks of radius 1 in the plane of E1 = (1, 2, 2) and E2 = (2, 1, -2) about -3 E1, under a map of scale 3, seen from h E3
off that plane, E3 = (2, -2, 1).
""", f"height {coordinates('receiver normal')} solid_angle_sr irradiance_lx")
    for k in range(3, 21):
        receiver = combine((10.0**-k, E3))
        normal = unit([-x for x in E1])
        # The exact place of the rounded receiver, in the frame of the disk, in units of 3.
        r = vec(receiver)
        e1, e3 = [mpf(x) / 3 for x in E1], [mpf(x) / 3 for x in E3]
        e2 = cross(e3, e1)
        x, y, h = dot(r, e1) / 3, dot(r, e2) / 3, dot(r, e3) / 3
        n = vec(normal)
        turned = [-dot(n, e1), -dot(n, e2), -dot(n, e3)]
        assert abs(y) < mpf(10) ** -18
        table.add(10.0**-k, *receiver, *normal, *disk(mpf(1), 3 + x, h, turned))
    return table


def tables():
    yield disks()
    yield cylinders()
    yield tubes()
    yield tilted_disks()
