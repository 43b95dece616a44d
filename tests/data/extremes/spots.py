"""Rows 10, 11 and 12: spots, their angles from the chord between unit vectors, cosines as plain differences.

In 120 digits, so that what cancels leaves enough.
"""
from mpmath import asin, cos, mp, mpf, pi, sqrt, tan

from table import Table

DEGREE = 3.141592653589793 / 180


def dot(a, b):
    return sum(mpf(x) * mpf(y) for x, y in zip(a, b))


def angle_between(a, b):
    """By the chord between the unit vectors."""
    a, b = [[mpf(x) / sqrt(dot(v, v)) for x in v] for v in (a, b)]
    chord = [x - y for x, y in zip(a, b)]
    return 2 * asin(sqrt(dot(chord, chord)) / 2)


def share(angle, start, cone):
    """Of the intensity: smoothstep of the cosine.  [Pharr23, 12.2.1]"""
    if angle <= start:
        return mpf(1)
    if angle >= cone:
        return mpf(0)
    x = (cos(angle) - cos(cone)) / (cos(start) - cos(cone))
    return x * x * (3 - 2 * x)


def solid_angle(start, cone):
    """The integral of the share: half of the edge counts."""
    return 2 * pi * (1 - (cos(start) + cos(cone)) / 2)


def off_axis(axis, across, angle, distance):
    """About `distance` from the light, `angle` off its axis, as doubles; `across` at right angles to the axis."""
    along = [mpf(distance) * x / sqrt(dot(axis, axis)) for x in axis]
    aside = [mpf(distance) * x / sqrt(dot(across, across)) for x in across]
    return [float(a * cos(angle) + b * mp.sin(angle)) for a, b in zip(along, aside)]


AXES = [((0.0, 0.0, -1.0), (1.0, 0.0, 0.0)), ((3.0, -4.0, 12.0), (4.0, 3.0, 0.0)), ((1.0, 1.0, -1.0), (1.0, 0.0, 1.0))]


def cones():
    table = Table("spot_cones", """
Spots at the origin, of intensity 1 along (ax, ay, az), full to `start` and dark from `cone`, seen from (x, y, z):
illuminance on what faces them [lx], density of rays that leave them in that direction [1/sr], and power [lm].
""", "cone_deg cone_rad start_rad ax ay az x y z value_lx per_sr power_lm")
    for degrees in (60.0, 1.0, 0.05, 0.01, 1e-3, 1e-5, 1e-7, 1e-9, 1e-12, 1e-15):
        cone = degrees * DEGREE
        start = cone / 2
        for axis, across in AXES:
            for part in (0.0, 0.25, 0.55, 0.75, 0.9):
                p = off_axis(axis, across, mpf(cone) * part, 3.0)
                angle = angle_between(axis, p)
                # Doubles tell no direction so close to an axis of three digits or more.
                if angle > mpf(cone) * 0.95:
                    continue
                lit, sr = share(angle, mpf(start), mpf(cone)), solid_angle(mpf(start), mpf(cone))
                table.add(degrees, cone, start, *axis, *p, lit / dot(p, p), lit / sr, sr)
    return table


def edges():
    table = Table("spot_edges", """
Spots at the origin, of intensity 1 along -z, whose edge is `delta` wide: from full at `start` to dark at `cone`.  At
(x, 0, z), a part of the way through it, the illuminance on what faces them [lx]; and their power [lm].
""", "delta_rad cone_rad start_rad part x z value_lx power_lm")
    for degrees in (0.5, 30.0, 89.9999, 120.0, 179.9):
        cone = degrees * DEGREE
        for delta in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8):
            start = cone - delta
            if start < 0:
                continue
            for part in (0.25, 0.5, 0.75):
                angle = mpf(start) + (mpf(cone) - mpf(start)) * part
                x, z = float(2 * mp.sin(angle)), float(-2 * cos(angle))
                angle = angle_between((0.0, 0.0, -1.0), (x, 0.0, z))
                lit = share(angle, mpf(start), mpf(cone)) / dot((x, z), (x, z))
                table.add(delta, cone, start, part, x, z, lit, solid_angle(mpf(start), mpf(cone)))
    return table


def narrowest():
    table = Table("spot_narrowest_edges", """
The power [lm] of spots of intensity 1 with the narrowest edges that doubles tell, and without an edge.
""", "cone_rad start_rad power_lm")
    for degrees in (1e-5, 0.5, 30.0, 89.9999, 120.0, 179.9, 180.0):
        cone = degrees * DEGREE if degrees < 180 else 3.141592653589793
        for ulps in (0, 1, 2, 1024, 1 << 20):
            start = cone * (1 - ulps * 2.0**-53)
            table.add(cone, start, solid_angle(mpf(start), mpf(cone)))
    return table


def wide():
    table = Table("spot_wide", """
Spots at the origin, of intensity 1 along -z: illuminance [lx] at (x, 0, z), and power [lm].
""", "cone_deg delta_deg x z value_lx power_lm")
    for degrees in (90.0, 120.0, 180.0):
        for delta in (0.0, 30.0, degrees):
            cone, start = mpf(degrees) * pi / 180, mpf(degrees - delta) * pi / 180
            for at in (0.0, 45.0, 89.0, 91.0, 119.0, 121.0, 179.0, 180.0):
                angle = mpf(at) * pi / 180
                # As float coordinates, which requests have.
                x, z = float(round(1024 * mp.sin(angle))), float(round(-1024 * cos(angle)))
                lit = share(angle_between((0.0, 0.0, -1.0), (x, 0.0, z)), start, cone)
                table.add(degrees, delta, x, z, lit / dot((x, z), (x, z)), solid_angle(start, cone))
    return table


def tables():
    with mp.workdps(120):
        yield cones()
        yield edges()
        yield narrowest()
        yield wide()
