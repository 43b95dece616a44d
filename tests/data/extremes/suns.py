"""Rows 10 and 29: disks of uniform radiance at infinity, by plain cosines in digits enough."""
from mpmath import cos, mp, mpf, pi, sin

from table import Table

DEGREE = 3.141592653589793 / 180


def tables():
    table = Table("suns", """
Suns of an illuminance of 100 lx: radiance [cd/m2], density of directions in the disk [1/sr] and power through the
disk of a scene of radius 2 m [lm].
""", "diameter_deg diameter_rad radiance per_sr power_lm")
    with mp.workdps(120):
        for degrees in (1e-15, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 0.01, 0.53, 1.0, 30.0, 90.0, 150.0, 179.0, 180.0):
            diameter = degrees * DEGREE if degrees < 180 else 3.141592653589793
            half = mpf(diameter) / 2
            radiance = 100 / (pi * sin(half) ** 2)
            solid_angle = 2 * pi * (1 - cos(half))
            table.add(degrees, diameter, radiance, 1 / solid_angle, radiance * solid_angle * pi * 4)
    yield table
