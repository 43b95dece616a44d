"""Rows 1 and 2: the cone that a sphere subtends, from its half-angle.  The code uses sines and cosines."""
from mpmath import asin, mpf, pi, sin

from polygons import combine, dot, norm, unit, vec
from table import Table


def tables():
    cone = Table("sphere_cone", """
A sphere seen from outside: 1 - cos of the half-angle asin(radius / distance), as 2 sin^2(angle / 2), and the
uniform density in it [1/sr].
""", "radius_m distance_m one_minus_cos pdf_per_sr")
    for exponent in range(-40, 1):
        for mantissa in (1.0, 1.1, 1.9375):
            radius, distance = mantissa * 2.0**exponent, 2.0
            one_minus_cos = 2 * sin(asin(mpf(radius) / mpf(distance)) / 2) ** 2
            cone.add(radius, distance, one_minus_cos, 1 / (2 * pi * one_minus_cos))
    yield cone

    near = Table("sphere_near", """
A sphere about the origin seen from just outside, at about the given relative gap: half-angle of its cone as in
sphere_cone, density in it [1/sr], irradiance from radiance 1 on a surface that faces the centre up to rounding [lx].
""", "radius_m gap receiver_x receiver_y receiver_z normal_x normal_y normal_z pdf_per_sr irradiance_lx")
    axis = unit([0.36, -0.48, 0.8])
    for decade in range(-6, 7, 2):
        radius = 1.3 * 10.0**decade
        for exponent in range(1, 16):
            gap = 10.0**-exponent
            receiver = combine((mpf(radius) * (1 + mpf(gap)), axis))
            distance = norm(vec(receiver))
            if not distance > radius:
                continue
            normal = unit([-x for x in axis])
            half = asin(radius / distance)
            near.add(radius, gap, *receiver, *normal, 1 / (4 * pi * sin(half / 2) ** 2),
                     pi * (radius / distance) ** 2 * -dot(vec(normal), vec(receiver)) / distance)
    yield near
