"""Rows 10, 11 and 12: spots, with angles from the chord between unit vectors and cosines as plain differences.

Computed in 120 digits, so that enough are left after cancellation.  Powers are integrated over the angle numerically.
"""
from functools import cache

from mpmath import asin, cos, mp, mpf, pi, quad, sin, sqrt

from table import Table

DEGREE = 3.141592653589793 / 180


def dot(a, b):
    return sum(mpf(x) * mpf(y) for x, y in zip(a, b))


def angle_between(a, b):
    """Angle, from the chord between the unit vectors."""
    a, b = [[mpf(x) / sqrt(dot(v, v)) for x in v] for v in (a, b)]
    chord = [x - y for x, y in zip(a, b)]
    return 2 * asin(sqrt(dot(chord, chord)) / 2)


def smoothstep(x):
    return x * x * (3 - 2 * x)


def share(angle, start, cone, profile=smoothstep):
    """Share of the intensity, a profile of the cosine.  [Pharr23, 12.2.1]"""
    if angle <= start:
        return mpf(1)
    if angle >= cone:
        return mpf(0)
    return profile((cos(angle) - cos(cone)) / (cos(start) - cos(cone)))


@cache
def solid_angle(start, cone, profile=smoothstep):
    """Integral of the share over all directions, ring by ring."""
    within = quad(sin, [0, start], method="gauss-legendre")
    edge = quad(lambda t: sin(t) * share(t, start, cone, profile), [start, cone], method="gauss-legendre")
    return 2 * pi * (within + edge)


def off_axis(axis, across, angle, distance):
    """A point in double about `distance` from the light, `angle` off its axis towards `across` at right angles to it."""
    along = [mpf(distance) * x / sqrt(dot(axis, axis)) for x in axis]
    aside = [mpf(distance) * x / sqrt(dot(across, across)) for x in across]
    return [float(a * cos(angle) + b * mp.sin(angle)) for a, b in zip(along, aside)]


AXES = [((0.0, 0.0, -1.0), (1.0, 0.0, 0.0)), ((3.0, -4.0, 12.0), (4.0, 3.0, 0.0)), ((1.0, 1.0, -1.0), (1.0, 0.0, 1.0))]


def cones():
    table = Table("spot_cones", """
Spots at the origin, of intensity 1 along (ax, ay, az), full to `start` and dark from `cone`, seen from (x, y, z):
illuminance on a surface that faces them [lx], density of rays that leave them in that direction [1/sr], and power [lm].
""", "cone_deg cone_rad start_rad ax ay az x y z value_lx per_sr power_lm")
    for degrees in (60.0, 1.0, 0.05, 0.01, 1e-3, 1e-5, 1e-7, 1e-9, 1e-12, 1e-15):
        cone = degrees * DEGREE
        start = cone / 2
        for axis, across in AXES:
            for part in (0.0, 0.25, 0.55, 0.75, 0.9):
                p = off_axis(axis, across, mpf(cone) * part, 3.0)
                angle = angle_between(axis, p)
                # No double direction is so close to an axis with components of three digits or more.
                if angle > mpf(cone) * 0.95:
                    continue
                lit, sr = share(angle, mpf(start), mpf(cone)), solid_angle(mpf(start), mpf(cone))
                table.add(degrees, cone, start, *axis, *p, lit / dot(p, p), lit / sr, sr)
    return table


def angle_of_share(u, start, cone):
    """The angle that contains the share `u` of the light, by Newton's method on the integral from the axis."""
    whole = solid_angle(start, cone)
    within = lambda t: 2 * pi * (quad(sin, [0, min(t, start)], method="gauss-legendre")
                                 + quad(lambda a: sin(a) * share(a, start, cone), [start, max(t, start)],
                                        method="gauss-legendre"))
    low, high = mpf(0), cone
    angle = cone * sqrt(mpf(u)) * mpf("0.7")
    for _ in range(60):
        excess = within(angle) - u * whole
        low, high = (angle, high) if excess < 0 else (low, angle)
        step = excess / (2 * pi * sin(angle) * share(angle, start, cone))
        angle -= step
        if not low < angle < high:
            angle = (low + high) / 2
        elif abs(step) < angle * mpf(10) ** -40:
            break
    return angle


def rays():
    table = Table("spot_rays", """
Rays of spots of intensity 1 along (ax, ay, az), full to `start` and dark from `cone`: the angle to the axis within which
the share `u` of the light lies, and power [lm].
""", "cone_deg cone_rad start_rad ax ay az u angle_rad power_lm")
    with mp.workdps(60):
        for degrees in (179.9, 60.0, 1.0, 0.01, 1e-5, 1e-7, 1e-9, 1e-12, 1e-15):
            cone = degrees * DEGREE
            start = cone / 2
            for u in (0.01, 0.1, 0.5, 0.9, 0.999):
                angle = angle_of_share(mpf(u), mpf(start), mpf(cone))
                for axis, _ in AXES:
                    table.add(degrees, cone, start, *axis, u, angle, solid_angle(mpf(start), mpf(cone)))
    return table


def edges():
    table = Table("spot_edges", """
Spots at the origin, of intensity 1 along -z, whose edge is `delta` wide: from full at `start` to dark at `cone`.  At
(x, 0, z), part of the way through it, the illuminance on a surface that faces them [lx]; and their power [lm].
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
The power [lm] of spots of intensity 1 with the narrowest edges that doubles can hold, and without an edge.
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
                # In float coordinates, as in requests.
                x, z = float(round(1024 * mp.sin(angle))), float(round(-1024 * cos(angle)))
                lit = share(angle_between((0.0, 0.0, -1.0), (x, 0.0, z)), start, cone)
                table.add(degrees, delta, x, z, lit / dot((x, z), (x, z)), solid_angle(start, cone))
    return table


def backs():
    table = Table("spot_backs", """
Spots at the origin, of intensity 1 along (ax, ay, az), that shine almost everywhere: full to `start` and dark from `cone`,
which is about `dark` from the backward direction.  Illuminance [lx] at (x, y, z), about `behind` off that direction.
""", "dark_rad cone_rad start_rad ax ay az behind_rad x y z value_lx")
    whole = 3.141592653589793
    for dark in (1e-2, 1.1e-3, 9e-4, 1e-4, 1e-6, 1e-9, 1e-12, 0.0):
        cone = float(pi - dark) if dark else whole
        # The double nearest to pi stands for pi.
        edge = pi - mpf(cone) if dark else mpf(0)
        for delta in (0.0, 1e-3, cone):
            start = cone - delta
            ends = [pi if a == whole else mpf(a) for a in (start, cone)]
            for axis, across in AXES:
                places = [edge * k for k in (mpf("0.5"), mpf("0.99"), mpf("1.01"), 2, 10)] if dark else []
                places += [mpf(10) ** -k for k in (15, 12, 9, 6)] + [mpf("0.003")]
                for behind in places:
                    p = off_axis([-a for a in axis], across, behind, 3.0)
                    # The angle of the rounded point replaces the intended one.  Points are left out where doubles are too
                    # coarse: so close to an axis with components of three digits or more, or nearly in the edge.
                    back = angle_between([-a for a in axis], p)
                    if abs(back - behind) > behind / 1000 or abs(back - edge) < edge / 200:
                        continue
                    lit = share(pi - back, *ends) if back > edge else mpf(0)
                    table.add(dark, cone, start, *axis, float(behind), *p, lit / dot(p, p))
    return table


def tables():
    with mp.workdps(120):
        yield cones()
        yield edges()
        yield narrowest()
        yield wide()
        yield rays()
        yield backs()
