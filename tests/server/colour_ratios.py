#!/usr/bin/python3
"""Prints a spectral renderer's colours over those of an RGB renderer, for the lights and surfaces of `colour`.

These are the numbers in reference_test.cpp.  Debian packages: python3, colord-data.  Usage: colour_ratios.py

pbrt-v4 turns the RGB of a surface into a reflectance that has this colour under D65 [Jakob19].  It is S(a t^2 + b t + c),
where t runs along the wavelengths and S(x) = 1/2 + x / (2 sqrt(1 + x^2)).  The RGB of a light is divided by twice its
largest channel, turned into a reflectance in the same way, and multiplied by D65.  This script finds the three
coefficients by Newton's method with 5 nm sums over the CIE's tables.  The colour of a surface is that of the product of
the two spectra.  An RGB renderer multiplies the two RGBs.
"""
import math

COLORD = "/usr/share/colord/"
RGB_FROM_XYZ = (
    (3.2409699419045213, -1.5373831775700935, -0.4986107602930033),
    (-0.9692436362808798, 1.8759675015077206, 0.0415550574071756),
    (0.0556300796969936, -0.2039769588889765, 1.0569715142428786),
)
WHITE_XYZ = (0.9504559270516718, 1, 1.0890577507598784)  # of RGB (1, 1, 1)
LIGHTS = ((9, 6, 3), (2, 4, 9))
SURFACES = ((0.5, 0.4, 0.3), (0.2, 0.4, 0.5))


def rows(path):
    lines = [line.rstrip() for line in open(COLORD + path)]
    data = lines[lines.index("BEGIN_DATA") + 1 : lines.index("END_DATA")]
    return [[float(x) for x in line.split()] for line in data]


OBSERVER = rows("cmf/CIE1931-2deg-XYZ.cmf")  # at 360, 365, ... 830 nm
D65 = rows("illuminant/CIE-D65.sp")[0][12:107]  # the table begins at 300 nm


def xyz(spectrum):
    return [sum(o * s for o, s in zip(row, spectrum)) for row in OBSERVER]


def rgb(spectrum):
    """The RGB of a spectrum, scaled so that D65 is (1, 1, 1)."""
    c = [v / w * white for v, w, white in zip(xyz(spectrum), xyz(D65), WHITE_XYZ)]
    return [sum(m * v for m, v in zip(row, c)) for row in RGB_FROM_XYZ]


def times(a, b):
    return [x * y for x, y in zip(a, b)]


def reflectance(coefficients):
    a, b, c = coefficients
    x = [(a * t + b) * t + c for t in (k / 94 for k in range(95))]
    return [0.5 + v / (2 * math.sqrt(1 + v * v)) for v in x]


def solved(matrix, right):
    """Solves by Gauss-Jordan elimination with pivots."""
    m = [row + [r] for row, r in zip(matrix, right)]
    for i in range(3):
        pivot = max(range(i, 3), key=lambda r: abs(m[r][i]))
        m[i], m[pivot] = m[pivot], m[i]
        for r in range(3):
            if r != i:
                m[r] = [x - m[r][i] / m[i][i] * y for x, y in zip(m[r], m[i])]
    return [m[i][3] / m[i][i] for i in range(3)]


def coefficients_of(colour):
    c = [0.0, 0.0, 0.0]
    for step in range(1, 41):  # from grey to the colour, so that Newton's method starts near
        target = [0.3 + (v - 0.3) * step / 40 for v in colour]
        for _ in range(20):
            now = rgb(times(reflectance(c), D65))
            columns = []
            for j in range(3):
                moved = [v + (1e-6 if i == j else 0) for i, v in enumerate(c)]
                columns.append([(v - w) / 1e-6 for v, w in zip(rgb(times(reflectance(moved), D65)), now)])
            change = solved([list(row) for row in zip(*columns)], [v - t for v, t in zip(now, target)])
            c = [v - d for v, d in zip(c, change)]
    return c


for light in LIGHTS:
    largest = 2 * max(light)
    shape = reflectance(coefficients_of([v / largest for v in light]))
    emitted = [largest * v for v in times(shape, D65)]
    for surface in SURFACES:
        seen = rgb(times(emitted, reflectance(coefficients_of(surface))))
        print(light, surface, ["%.5f" % (s / (l * r)) for s, l, r in zip(seen, light, surface)])
