"""Portals that are tiny, huge or far, or seen from nearly in their plane: the density of lights/models/portal_light.h.

The table of a portal has 64 x 64 cells over two angles, alpha about y and beta about x.  The weight of a cell is the
solid angle of its 4 x 4 parts, each taken at its middle, in whole numbers up to 2^40.  In a window of the table a share
of the samples is uniform, and the rest follows the weights.  Here angles are arc tangents and solid angles come from
tangents.
"""
from mpmath import atan, floor, mpf, pi, sqrt, tan

from table import Table

CELLS, LOOKS = 64, 4
UNIFORM = mpf(1) / 16


def sr_per_square(tan_a, tan_b):
    """Solid angle over area of the square, whose sides are pi in angle."""
    return pi * pi * (1 + tan_a**2) * (1 + tan_b**2) / sqrt(1 + tan_a**2 + tan_b**2) ** 3


def weights():
    fine = [tan(pi * ((mpf(i) + mpf(1) / 2) / (CELLS * LOOKS) - mpf(1) / 2)) for i in range(CELLS * LOOKS)]
    half = CELLS // 2
    table = [[mpf(0)] * CELLS for _ in range(CELLS)]
    # Four quarters are equal, and in each the two triangles.
    for j in range(half):
        for i in range(j + 1):
            w = sum(sr_per_square(fine[i * LOOKS + a], fine[j * LOOKS + b]) for a in range(LOOKS) for b in range(LOOKS))
            for x, y in ((i, j), (j, i)):
                for x, y in ((x, y), (CELLS - 1 - x, y), (x, CELLS - 1 - y), (CELLS - 1 - x, CELLS - 1 - y)):
                    table[y][x] = w
    largest = max(max(row) for row in table)
    return [[1 + floor(w / largest * 2**40) for w in row] for row in table]


def parts(begin, end):
    """The cells that overlap [begin, end], each with the length of the overlap, in cells."""
    begin, end = begin * CELLS, end * CELLS
    return [(i, min(end, i + 1) - max(begin, i)) for i in range(int(begin), min(int(end), CELLS - 1) + 1)]


def density(table, window, tan_a, tan_b):
    (x0, x1), (y0, y1) = window
    sum_ = sum(w * v * table[j][i] for j, w in parts(y0, y1) for i, v in parts(x0, x1))
    cell = table[int((atan(tan_b) / pi + mpf(1) / 2) * CELLS)][int((atan(tan_a) / pi + mpf(1) / 2) * CELLS)]
    by_weight = cell / sum_ * CELLS * CELLS
    uniform = 1 / ((x1 - x0) * (y1 - y0))
    return ((1 - UNIFORM) * by_weight + UNIFORM * uniform) / sr_per_square(tan_a, tan_b)


def tables():
    table = Table("portals", """
A portal from (0, 0, 0) to (side, side, 0) with light from beyond it, a receiver at (x, y, -depth), and the density with
which the direction (wx, wy, wz) through the portal is sampled [1/sr].
""", "side x y depth wx wy wz per_sr")
    cells = weights()
    for side in (1e-6, 1.0, 1e6):
        for depth in (1e-12, 1e-9, 1e-6, 1e-3, 0.1, 1.0, 10.0, 1e3, 1e6, 1e9, 1e12):
            for at in ((0.3, 0.6), (-1.0, 0.5), (2.5, -0.7), (0.5, 1.0001), (-1e3, 1e3)):
                x, y, d = [mpf(float(c * side)) for c in (*at, depth)]
                window = [[atan((edge - c) / d) / pi + mpf(1) / 2 for edge in (0, mpf(side))] for c in (x, y)]
                for to in ((0.417, 0.329), (0.883, 0.713)):
                    way = [mpf(to[0]) * side - x, mpf(to[1]) * side - y, d]
                    length = sqrt(sum(c * c for c in way))
                    way = [float(c / length) for c in way]
                    if not way[2]:
                        continue
                    tan_a, tan_b = [mpf(c) / mpf(way[2]) for c in way[:2]]
                    table.add(side, float(x), float(y), float(d), *way, density(cells, window, tan_a, tan_b))
    yield table
