"""Row 1: the cone that a sphere subtends, by its half-angle and not by sines and cosines of the code."""
from mpmath import asin, mpf, pi, sin

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
