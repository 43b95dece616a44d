"""Rows 10 and 29: disks of uniform radiance at infinity, integrated numerically over the rings of the disk."""
from mpmath import cos, mpf, pi, quad, sin

from table import Table

DEGREE = 3.141592653589793 / 180


def tables():
    table = Table("suns", """
Suns of an illuminance of 100 lx: radiance [cd/m2], density of directions in the disk [1/sr] and power through the
disk of a scene of radius 2 m [lm].
""", "diameter_deg diameter_rad radiance per_sr power_lm")
    scene = quad(lambda r: 2 * pi * r, [0, 2])
    for degrees in (1e-15, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 0.01, 0.53, 1.0, 30.0, 90.0, 150.0, 179.0, 180.0):
        diameter = degrees * DEGREE if degrees < 180 else 3.141592653589793
        half = mpf(diameter) / 2
        # All light of a ring `t` off the middle arrives at the angle t on a surface that faces the middle.
        solid_angle = quad(lambda t: 2 * pi * sin(t), [0, half])
        radiance = 100 / quad(lambda t: 2 * pi * sin(t) * cos(t), [0, half])
        table.add(degrees, diameter, radiance, 1 / solid_angle, radiance * solid_angle * scene)
    yield table
