"""Row 31: flux of luminaires by the antiderivative of each cell; intensities from sines and cosines of the angles."""
from mpmath import acos, asin, atan2, cos, degrees, mpf, radians, sin, sqrt

from table import Table


def joined(values):
    return ",".join(repr(float(v)) for v in values)


def across(kind, planes):
    """Horizontal angles all around, or over the lit range, each with the plane that it repeats."""
    found = list(enumerate(planes))
    found = [(mpf(angle), i) for i, angle in found]
    if kind == "C":
        if len(planes) == 1:
            return found + [(found[0][0] + 360, 0)]
        while found[-1][0] - found[0][0] < 360:
            last = found[-1][0]
            found += [(2 * last - angle, i) for angle, i in reversed(found[:-1])]
        return found
    if planes[0] == 0:
        return [(-angle, i) for angle, i in reversed(found[1:])] + found
    return found


def flux(kind, angles, planes, candela):
    """Integral of a function linear in both angles: the antiderivative of (a + b x) sin x is b sin x - (a + b x) cos x."""
    lines = across(kind, planes)
    n, total = len(angles), mpf(0)
    for (h0, i0), (h1, i1) in zip(lines, lines[1:]):
        for j in range(n - 1):
            v0, v1 = mpf(angles[j]), mpf(angles[j + 1])
            (a, b), (c, d) = [[mpf(candela[i * n + k]) for k in (j, j + 1)] for i in (i0, i1)]
            # The mean over the turn about the pole, then along the other angle: V, or H of type B.
            if kind == "B":
                start, end, first, last, turn = radians(h0), radians(h1), (a + b) / 2, (c + d) / 2, radians(v1 - v0)
            else:
                start, end, first, last, turn = radians(v0), radians(v1), (a + c) / 2, (b + d) / 2, radians(h1 - h0)
            slope = (last - first) / (end - start)
            if kind == "C":
                along = slope * (sin(end) - sin(start)) - (last * cos(end) - first * cos(start))
            else:
                along = slope * (cos(end) - cos(start)) + (last * sin(end) - first * sin(start))
            total += turn * along
    return total


def intensity(kind, angles, planes, candela, w):
    x, y, z = [mpf(c) for c in w]
    r = sqrt(x * x + y * y + z * z)
    if kind == "C":
        v, h = degrees(acos(z / r)), degrees(atan2(-y, x))
    elif kind == "B":
        v, h = degrees(atan2(x, z)), degrees(asin(y / r))
    else:
        v, h = degrees(asin(-z / r)), degrees(atan2(y, x))
    lines, n = across(kind, planes), len(angles)
    while h < lines[0][0]:
        h += 360
    if h > lines[-1][0] or v < angles[0] or v > angles[-1]:
        return mpf(0)
    k = max(i for i in range(len(lines) - 1) if lines[i][0] <= h)
    j = max(i for i in range(n - 1) if mpf(angles[i]) <= v)
    s = (h - lines[k][0]) / (lines[k + 1][0] - lines[k][0])
    t = (v - mpf(angles[j])) / (mpf(angles[j + 1]) - mpf(angles[j]))

    def at(line, column):
        return mpf(candela[line[1] * n + column])

    return ((at(lines[k], j) * (1 - s) + at(lines[k + 1], j) * s) * (1 - t)
            + (at(lines[k], j + 1) * (1 - s) + at(lines[k + 1], j + 1) * s) * t)


def grids():
    """Yields kind, vertical angles, horizontal angles, candela."""
    halves = {"C": ((0.0, 45.0, 90.0), (90.0, 120.0, 180.0), (0.0, 30.0, 90.0, 150.0, 180.0)),
              "B": ((0.0, 45.0, 90.0), (-90.0, -20.0, 0.0, 60.0, 90.0)),
              "A": ((0.0, 45.0, 90.0), (-90.0, -20.0, 0.0, 60.0, 90.0))}
    planes = {"C": ((0.0,), (0.0, 90.0), (0.0, 20.0, 90.0), (0.0, 70.0, 180.0), (90.0, 100.0, 270.0),
                    (0.0, 90.0, 180.0, 270.0, 360.0)),
              "B": ((0.0, 90.0), (0.0, 10.0, 90.0), (-90.0, 0.0, 90.0), (-90.0, -30.0, 5.0, 90.0)),
              "A": ((0.0, 90.0), (0.0, 10.0, 90.0), (-90.0, 0.0, 90.0), (-90.0, -30.0, 5.0, 90.0))}
    for kind in "CBA":
        for vertical in halves[kind]:
            for horizontal in planes[kind]:
                candela = [float((7 * i * i + 3 * i) % 11) * 100 for i in range(1, len(vertical) * len(horizontal) + 1)]
                if horizontal[-1] == 360:
                    candela[-len(vertical):] = candela[:len(vertical)]
                yield kind, vertical, horizontal, candela
    # Candela of any size.
    for exponent in (-300, -100, -45, -30, -10, 2, 10, 30, 100, 295):
        yield "C", (0.0, 45.0, 90.0), (0.0,), [float(f"{d}e{exponent}") for d in (3, 2, 1)]
    # All light within a narrow beam, about the axis, about the horizon and about a plane.
    for step in (1.0, 1e-2, 1e-4, 1e-6, 1e-7):
        yield "C", (0.0, step, 2 * step, 90.0), (0.0,), [1e6, 5e5, 0.0, 0.0]
        yield "C", (0.0, step, 2 * step, 180.0), (0.0, step, 90.0), [1e6, 5e5, 0.0, 0.0, 1e3, 5e5, 0.0, 0.0] + [0.0] * 4
        yield "B", (-90.0, -step, 0.0, step, 90.0), (-90.0, -step, 0.0, step, 90.0), [0.0] * 12 + [1e6] + [0.0] * 12
        yield "A", (-90.0, -step, 0.0, step, 90.0), (-90.0, -step, 0.0, step, 90.0), [0.0] * 12 + [1e6] + [0.0] * 12
        yield "C", (0.0, 90.0 - step, 90.0), (0.0,), [0.0, 0.0, 1e6]


def directions(kind, angles, planes):
    """Yields a direction in double within each cell that has room for one."""
    lines = across(kind, planes)
    for (h0, _), (h1, _) in list(zip(lines, lines[1:]))[:2]:
        for v0, v1 in zip(angles, angles[1:]):
            h, v = radians(h0 + (h1 - h0) * mpf("0.3")), radians(mpf(v0) + (mpf(v1) - mpf(v0)) * mpf("0.6"))
            if kind == "C":
                w = sin(v) * cos(h), -sin(v) * sin(h), cos(v)
            elif kind == "B":
                w = cos(h) * sin(v), sin(h), cos(h) * cos(v)
            else:
                w = cos(v) * cos(h), cos(v) * sin(h), -sin(v)
            yield [float(c) for c in w]


def tables():
    fluxes = Table("photometric_flux", """
Luminaires as in photometric files, and their flux [lm]: photometric type, vertical and horizontal angles
[degrees], candela (all vertical angles at the first horizontal angle, then at the next).
""", "type vertical horizontal candela flux_lm")
    values = Table("photometric_intensity", """
Intensities [cd] of the same luminaires towards (x, y, z): +z is down, and for types C and A +x is horizontal, as
documented in lights/pictures/photometric_web.h.
""", "type vertical horizontal candela x y z intensity_cd")
    for kind, vertical, horizontal, candela in grids():
        words = kind, joined(vertical), joined(horizontal), joined(candela)
        fluxes.add(*words, flux(kind, vertical, horizontal, candela))
        if max(candela) > 1e35 or max(candela) < 1e-35:
            continue  # beyond the range of floats
        for w in directions(kind, vertical, horizontal):
            value = intensity(kind, vertical, horizontal, candela, w)
            if value > 0:
                values.add(*words, *w, value)
    yield fluxes
    yield values
