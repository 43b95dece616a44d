"""Rows 20 and 21: pictures around the sphere, from the definitions of the mappings.

Directions are computed from points of the picture, never the other way round.  The bilinear filter is a sum of tents
over the picture, which is continued across its borders.
"""
from fractions import Fraction

from mpmath import cos, mpf, pi, sin, sqrt

from table import Table, as_float


def texel(i, j):
    """The texels of the tests' pictures.  A third of them are black."""
    return max(0, (3 * i + 5 * j) % 9 - 2)


def direction(mapping, s, t):
    """The unit vector towards the point (s, t) of the picture."""
    s, t = mpf(s), mpf(t)
    if mapping == "latlong":
        return [sin(pi * t) * cos(2 * pi * s), cos(pi * t), sin(pi * t) * sin(2 * pi * s)]
    # [Clarberg08]: the middle is +z, rings are |u| + |v| = r, and fractions of a quarter turn are fractions of a side.
    u, v = 2 * s - 1, 2 * t - 1
    a, b = abs(u), abs(v)
    lower = a + b > 1
    if lower:
        a, b = 1 - b, 1 - a
    r = a + b
    z = 1 - r * r
    phi = pi / 2 * b / r if r else mpf(0)
    x, y = sqrt(1 - z * z) * cos(phi), sqrt(1 - z * z) * sin(phi)
    return [x if u >= 0 else -x, y if v >= 0 else -y, -z if lower else z]


def continued(mapping, w, h, i, j):
    """The texel at (i, j), which may be one texel beyond the border."""
    if mapping == "latlong":
        if not 0 <= j < h:
            i, j = i + w // 2, -1 - j if j < 0 else 2 * h - 1 - j
        return texel(i % w, j)
    if not 0 <= i < w:
        i, j = (-1 - i if i < 0 else 2 * w - 1 - i), h - 1 - j
    if not 0 <= j < h:
        i, j = w - 1 - i, (-1 - j if j < 0 else 2 * h - 1 - j)
    return texel(i, j)


def tent(x):
    return max(mpf(0), 1 - abs(x))


def value(mapping, texel_filter, w, h, s, t):
    s, t = mpf(s), mpf(t)
    if texel_filter == "nearest":
        return mpf(texel(min(int(s * w), w - 1), min(int(t * h), h - 1)))
    return sum(
        continued(mapping, w, h, i, j) * tent(s * w - i - mpf(1) / 2) * tent(t * h - j - mpf(1) / 2)
        for i in range(-1, w + 1)
        for j in range(-1, h + 1))


def row_mean(w, j):
    return mpf(sum(texel(i, j) for i in range(w))) / w


def strips(texel_filter, h):
    """Strips of a latitude-longitude picture: within each, density is linear in the cosine of the polar angle."""
    if texel_filter == "nearest":
        return [mpf(j) / h for j in range(h + 1)]
    return [mpf(0)] + [(mpf(j) + mpf(1) / 2) / h for j in range(h)] + [mpf(1)]


def total(mapping, texel_filter, w, h):
    """The normalisation of densities: the integral of the unnormalised density."""
    if mapping == "equalarea":
        return 4 * pi * sum(row_mean(w, j) for j in range(h)) / h
    at, sum_ = strips(texel_filter, h), mpf(0)
    for k in range(len(at) - 1):
        if texel_filter == "nearest":
            mean = row_mean(w, k)
        else:
            mean = (row_mean(w, max(k - 1, 0)) + row_mean(w, min(k, h - 1))) / 2
        sum_ += mean * 2 * pi * (cos(pi * at[k]) - cos(pi * at[k + 1]))
    return sum_


def density(mapping, texel_filter, w, h, s, t):
    if mapping == "latlong" and texel_filter == "bilinear":
        at = strips(texel_filter, h)
        k = max(k for k in range(len(at) - 1) if at[k] <= t)
        share = (cos(pi * at[k]) - cos(pi * mpf(t))) / (cos(pi * at[k]) - cos(pi * at[k + 1]))
        t = at[k] + share * (at[k + 1] - at[k])
    return value(mapping, texel_filter, w, h, s, t) / total(mapping, texel_filter, w, h)


def places(n):
    """Places in [0, 1]: both ends, both sides of the first and of a middle edge between texels, a centre, and one more."""
    near = mpf(10) ** -9
    edges = [mpf(1) / n, mpf(n // 2) / n]
    return [near, 1 - near] + [e + side * near for e in edges for side in (-1, 1)] + [mpf(3) / 2 / n, mpf("0.7391")]


def looks():
    table = Table("sphere_maps", """
Pictures of w x h texels around the sphere, texel (i, j) max(0, (3 i + 5 j) mod 9 - 2): towards (x, y, z) in the map's
axes the value, and the density of directions drawn by it [1/sr].  Places 1e-9 beside the seam, the poles and the edges
between texels, centres of texels, and one ordinary place.
""", "mapping filter w h x y z value per_sr")
    for mapping, w, h in (("equalarea", 4, 4), ("equalarea", 6, 6), ("latlong", 8, 5)):
        for texel_filter in ("nearest", "bilinear"):
            for s in places(w):
                for t in places(h):
                    table.add(mapping, texel_filter, w, h, *[float(c) for c in direction(mapping, s, t)],
                              value(mapping, texel_filter, w, h, s, t), density(mapping, texel_filter, w, h, s, t))
    return table


def integral(mapping, texel_filter, w, h, weights):
    """Integral over the sphere of a picture of `weights[j][i]`."""
    means = [mpf(sum(Fraction(x) for x in row).numerator) / sum(Fraction(x) for x in row).denominator / w
             for row in weights]
    if mapping == "equalarea":
        return 4 * pi * sum(means) / h
    if texel_filter == "nearest":
        return sum(m * 2 * pi * (cos(pi * j / h) - cos(pi * (j + 1) / h)) for j, m in enumerate(means))
    # Linear in the polar angle between rows of centres: integrate theta sin(theta) by parts.
    sum_ = mpf(0)
    for k in range(h + 1):
        a, b = pi * max(k - mpf(1) / 2, 0) / h, pi * min(k + mpf(1) / 2, h) / h
        above, below = means[max(k - 1, 0)], means[min(k, h - 1)]
        slope = (below - above) * h / pi
        at_zero = above - slope * pi * (k - mpf(1) / 2) / h
        sum_ += 2 * pi * (at_zero * (cos(a) - cos(b)) + slope * ((sin(b) - b * cos(b)) - (sin(a) - a * cos(a))))
    return sum_


N = 8
BRIGHT = (5, 2)  # column, row


def weights_of(background, bright):
    return [[bright if (i, j) == BRIGHT else background for i in range(N)] for j in range(N)]


def measures(mapping):
    """Each row's share of the sphere, exact where it is rational."""
    if mapping == "equalarea":
        return [Fraction(1, N)] * N
    return [(cos(pi * j / N) - cos(pi * (j + 1) / N)) / 2 for j in range(N)]


def chances():
    """Selection probabilities, in rational arithmetic except for the rows' measures of the latitude-longitude mapping."""
    table = Table("bright_texels", """
Pictures of 8 x 8 texels, all `background` but texel (5, 2), which is `bright`: sample values (ux, uy) in the middle of
the range that leads to a texel, its column and row, its selection probability, and the integral of the picture over the
sphere.  Texels are left out where no double lies in the middle of their range.
""", "mapping background bright ux uy column row chance integral")
    for mapping in ("equalarea", "latlong"):
        for background, bright in ((1, 10**9), (1, 10**30), (10**30, 1), (0, 1), (0, 10**9), (0, 10**-30), (1, 1)):
            background, bright = [Fraction(as_float(x)) for x in (background, bright)]
            weights, shares = weights_of(background, bright), measures(mapping)
            exact = (lambda f: f) if mapping == "equalarea" else (lambda f: mpf(f.numerator) / f.denominator)
            rows = [exact(sum(row)) * share for row, share in zip(weights, shares)]
            whole = sum(rows)
            for row in range(N):
                for column in (0, 4, 5, 7):
                    if not weights[row][column]:
                        continue
                    ux, uy = [
                        ((sum(parts[:k]) + parts[k] / 2) / sum(parts), parts[k] / sum(parts))
                        for parts, k in ((weights[row], column), (rows, row))
                    ]
                    ux, uy = [(float(middle), middle, extent) for middle, extent in (ux, uy)]
                    exact_double = lambda u: Fraction(u[0]) if isinstance(u[1], Fraction) else mpf(u[0])
                    if any(abs(exact_double(u) - u[1]) * 4 > u[2] for u in (ux, uy)):
                        continue
                    chance = exact(weights[row][column] / sum(weights[row])) * rows[row] / whole
                    if isinstance(chance, Fraction):
                        chance = mpf(chance.numerator) / chance.denominator
                    table.add(mapping, float(background), float(bright), ux[0], uy[0], column, row, chance,
                              integral(mapping, "nearest", N, N, weights))
    return table


def integrals():
    table = Table("map_integrals", """
The integral over the sphere of the pictures of sphere_maps, and of those of bright_texels (8 x 8, with a background).
""", "mapping filter w h background bright integral")
    for mapping in ("equalarea", "latlong"):
        for texel_filter in ("nearest", "bilinear"):
            w, h = (6, 6) if mapping == "equalarea" else (8, 5)
            weights = [[Fraction(texel(i, j)) for i in range(w)] for j in range(h)]
            table.add(mapping, texel_filter, w, h, -1.0, -1.0, integral(mapping, texel_filter, w, h, weights))
            for background, bright in ((0, 0), (1, 10**9), (1, 10**30), (0, 1), (0, 10**-30), (10**30, 1)):
                background, bright = [Fraction(as_float(x)) for x in (background, bright)]
                table.add(mapping, texel_filter, N, N, float(background), float(bright),
                          integral(mapping, texel_filter, N, N, weights_of(background, bright)))
    return table


def tables():
    yield looks()
    yield chances()
    yield integrals()
