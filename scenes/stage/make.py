#!/usr/bin/python3
"""Writes the data of the stage: scenery, slides, spots and projectors, and the points to measure at.

Debian packages: those of modelling.py.
"""
import math
import pathlib
import random
import sys

import numpy as np

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import modelling

WIDTH, DEPTH, GRID = 14.0, 9.0, 7.2  # of the stage; height of its bridges.  The curtain's line is y = 0.
SURFACES = {
    "boards": modelling.coated((0.36, 0.28, 0.21), 0.3),
    "boards_dark": modelling.coated((0.31, 0.235, 0.175), 0.3),
    "backdrop": (0.75, 0.75, 0.75),
    "velvet": (0.34, 0.03, 0.04),
    "gold": modelling.named_metal("Au", 0.3),
    "masonry": (0.52, 0.48, 0.42),
    "masonry_dark": (0.38, 0.35, 0.31),
    "black": (0.03, 0.03, 0.03),
    "steel": modelling.metal((0.5, 0.5, 0.52), 0.25),
    "wood": modelling.coated((0.36, 0.23, 0.13), 0.2),  # painted
    "dress": (0.72, 0.66, 0.6),
    "sash": (0.5, 0.07, 0.09),
    "skin": (0.58, 0.42, 0.33),
    "coat": (0.14, 0.17, 0.3),
    "hair": (0.08, 0.05, 0.03),
    "leaf": (0.14, 0.27, 0.08),
    "pot": modelling.coated((0.5, 0.24, 0.14), 0.1),
    "seat": (0.2, 0.03, 0.04),
    "heads": (0.06, 0.05, 0.045),
}


def house(model):
    """Floor, backdrop, wings, proscenium, curtain, and the first rows of the house."""
    rng = random.Random(1)
    for i in range(70):
        x = -WIDTH / 2 + 0.2 * i
        model.quad("boards" if rng.random() < 0.6 else "boards_dark", (x, -1.2, 0), (x + 0.197, -1.2, 0), (x + 0.197, DEPTH, 0), (x, DEPTH, 0))
    model.quad("black", (-20, -1.2, -0.01), (20, -1.2, -0.01), (20, DEPTH + 1, -0.01), (-20, DEPTH + 1, -0.01))
    model.box("wood", (-WIDTH / 2, -1.25, -1.1), (WIDTH / 2, -1.2, 0.02))
    model.quad("backdrop", (-8.5, DEPTH - 0.4, 0), (8.5, DEPTH - 0.4, 0), (8.5, DEPTH - 0.4, 8.6), (-8.5, DEPTH - 0.4, 8.6))
    for side in (-1, 1):
        for y in (2.2, 4.4, 6.6):  # legs
            folds(model, "black", (side * 6.0, y), (side * 8.5, y + 0.2), 0, 8.2, 9, 0.07)
        folds(model, "velvet", (side * 4.7, 0.15), (side * 7.6, 0.35), 0.02, 7.4, 13, 0.16)
        a, b = sorted((side * 6.6, side * 9.5))
        model.box("masonry_dark", (a, -0.75, -1.1), (b, -0.05, 9.5))
        with model.placed((side * 6.45, -0.8, 0)):
            column = [(0.34, -0.1), (0.34, 0.25), (0.27, 0.4), (0.24, 0.55), (0.21, 5.4), (0.25, 5.55), (0.36, 5.8), (0.36, 6.0), (0, 6.0)]
            model.lathe("gold", column, 28)
    model.box("masonry_dark", (-9.5, -0.75, 6.9), (9.5, -0.05, 9.5))
    model.box("gold", (-6.6, -0.85, 6.6), (6.6, -0.75, 6.95))
    folds(model, "velvet", (-6.6, 0.05), (6.6, 0.05), 5.75, 7.4, 33, 0.12, scallops=11)
    model.box("black", (-20, DEPTH, -1.2), (20, DEPTH + 0.1, 11))
    # The first rows of the balcony, from behind.
    for row in range(2):
        y, z = -9.4 - 1.05 * row, 0.82 + 0.2 * row
        for i in range(17):
            x = -8.2 + 1.0 * i + 0.5 * row
            model.box("seat", (x - 0.3, y - 0.06, z), (x + 0.3, y + 0.06, z + 0.92))
            if rng.random() < 0.75:
                lean = 0.08 * (rng.random() - 0.5)
                model.ball("heads", (x + lean, y + 0.2, z + 1.26 + 0.08 * rng.random()), 0.115, 16)
                model.lathe("heads", [(0.24, 0.45), (0.25, 0.85), (0.2, 0.98), (0.07, 1.06), (0.06, 1.2)], 16, (x, y + 0.22, z))
    model.box("black", (-10, -8.6, 0.4), (10, -8.4, 1.35))
    model.quad("black", (-20, -14, -1.2), (20, -14, -1.2), (20, -1.2, -1.2), (-20, -1.2, -1.2))


def folds(model, surface, a, b, low, high, count, depth, scallops=0):
    """A curtain from a to b, (x, y), in `count` folds; its hem in arcs where `scallops` says how many."""
    n = count * 8
    t = np.arange(n + 1) / n
    a, b = np.array(a), np.array(b)
    across = np.array([-(b - a)[1], (b - a)[0]]) / np.linalg.norm(b - a)
    wave = depth * np.sin(2 * math.pi * count * t) * (1 + 0.25 * np.sin(5.3 * count * t / 3))
    hem = low - 0.45 * np.abs(np.sin(math.pi * scallops * t)) if scallops else np.full(n + 1, float(low))
    rows = []
    for k in range(7):
        s = k / 6
        xy = a + (b - a) * t[:, None] + across * (wave * (1 - 0.45 * s))[:, None]
        rows.append(np.concatenate([xy, (hem + (high - hem) * s)[:, None]], 1))
    model.grid(surface, np.array(rows))


def arch(model, x, y, turn, width, height):
    """A wall 0.5 m thick with a round-headed opening, of stones."""
    with model.placed((x, y, 0), turn):
        half, spring, thick = width / 2, height - width / 2, 0.5
        for side in (-1, 1):
            for i in range(int(spring / 0.4)):
                z = spring * i / int(spring / 0.4)
                e = 0.012 if i % 2 else 0.0
                u, v = sorted((side * half, side * (half + 0.62 + e)))
                model.box("masonry" if i % 2 else "masonry_dark", (u, -thick / 2 - e, z), (v, thick / 2 + e, z + spring / int(spring / 0.4) - 0.015))
        count = 13
        for i in range(count):
            a, b = math.pi * i / count + 0.006, math.pi * (i + 1) / count - 0.006
            outline = [(r * math.cos(t), spring + r * math.sin(t)) for r, t in ((half, a), (half + 0.62, a), (half + 0.62, b), (half, b))]
            with model.placed(lean=90):  # a prism along -y
                model.prism("masonry" if i % 2 else "masonry_dark", outline, -thick / 2, thick / 2)
        model.box("masonry", (-half - 0.75, -thick / 2 - 0.08, height + 0.62), (half + 0.75, thick / 2 + 0.08, height + 0.85))


def stairs(model):
    """Nine steps up to a terrace on the left, with a balustrade."""
    for i in range(9):
        model.box("masonry" if i % 2 else "masonry_dark", (-2.6 - 0.32 * (i + 1), 5.0, 0), (-2.6 - 0.32 * i, 7.0, 0.17 * (i + 1)))
    top = 0.17 * 9
    model.box("masonry", (-7.4, 5.0, 0), (-5.48, 7.0, top))
    for i in range(8):
        baluster(model, (-7.2 + 0.24 * i, 5.12, top))
    model.box("masonry", (-7.35, 5.02, top + 0.72), (-5.4, 5.22, top + 0.82))
    for i in range(9):
        baluster(model, (-2.76 - 0.32 * i, 5.12, 0.17 * (i + 1)))
    model.rod("masonry", (-2.6, 5.12, 0.17 + 0.74), (-5.6, 5.12, top + 0.82), 0.07, 4)


def baluster(model, at):
    model.lathe("masonry", [(0.06, 0), (0.06, 0.06), (0.03, 0.1), (0.065, 0.28), (0.03, 0.5), (0.05, 0.66), (0.05, 0.74)], 12, at)


def people(model):
    # The soprano.
    at = (0.9, 2.3, 0)
    gown = [(0.62, 0.01), (0.56, 0.2), (0.42, 0.55), (0.27, 0.85), (0.155, 1.08), (0.18, 1.28), (0.2, 1.4), (0.12, 1.46), (0.05, 1.47)]
    angles = np.arange(73) * (2 * math.pi / 72)
    rows = [[(at[0] + r * math.cos(a) * (1 + 0.07 * math.cos(12 * a) * (z < 0.9)), at[1] + r * math.sin(a) * (1 + 0.07 * math.cos(12 * a) * (z < 0.9)), z) for a in angles] for r, z in gown]
    model.grid("dress", np.array(rows))
    model.lathe("sash", [(0.172, 1.02), (0.17, 1.08), (0.166, 1.13)], 32, at)
    head(model, at, 1.63)
    for side, hand in ((-1, (-0.62, -0.25, 1.5)), (1, (0.6, -0.3, 1.62))):
        elbow = (at[0] + side * 0.4, at[1] - 0.02, 1.22)
        model.rod("dress", (at[0] + side * 0.17, at[1], 1.38), elbow, 0.06, 12, 0.045)
        model.rod("skin", elbow, (at[0] + hand[0], at[1] + hand[1], hand[2]), 0.042, 12, 0.03)
        model.ball("skin", (at[0] + hand[0], at[1] + hand[1], hand[2]), 0.05, 14)
    # The tenor on the stairs, hat in hand.
    at = (-3.45, 5.9, 0.17 * 3)
    model.lathe("coat", [(0.24, 0.5), (0.19, 0.95), (0.23, 1.3), (0.2, 1.42), (0.1, 1.48), (0, 1.49)], 32, at)
    for u in (-0.1, 0.1):
        model.rod("black", (at[0] + u, at[1], at[2]), (at[0] + u * 0.8, at[1], at[2] + 0.6), 0.075, 14, 0.09)
    head(model, at, at[2] + 1.66)
    for side, hand in ((-1, (-0.3, -0.12, 0.78)), (1, (0.52, -0.28, 1.35))):
        shoulder, elbow = (at[0] + side * 0.2, at[1], at[2] + 1.38), (at[0] + side * 0.34, at[1] - 0.06, at[2] + 1.08)
        model.rod("coat", shoulder, elbow, 0.07, 12, 0.055)
        model.rod("coat", elbow, (at[0] + hand[0], at[1] + hand[1], at[2] + hand[2]), 0.052, 12, 0.04)
        model.ball("skin", (at[0] + hand[0], at[1] + hand[1], at[2] + hand[2]), 0.05, 14)


def head(model, at, z):
    model.rod("skin", (at[0], at[1], z - 0.2), (at[0], at[1], z), 0.055, 12)
    with model.placed((at[0], at[1], z)):
        model.lathe("skin", [(0, -0.13), (0.06, -0.11), (0.09, -0.04), (0.1, 0.03), (0.08, 0.11), (0, 0.14)], 24)
        model.lathe("hair", [(0.115, 0.0), (0.118, 0.06), (0.09, 0.14), (0, 0.17)], 24, (0, 0.025, 0))


def properties(model):
    """A fountain's basin, trees in tubs, a bench, steps of a terrace on the right."""
    basin = [(0, 0), (1.05, 0), (1.1, 0.12), (0.98, 0.2), (0.95, 0.5), (1.05, 0.55), (1.05, 0.62), (0.88, 0.62), (0.86, 0.3), (0, 0.28)]
    model.lathe("masonry", basin, 48, (3.5, 4.4, 0))
    bowl = [(0.13, 0.28), (0.1, 0.6), (0.16, 0.7), (0.09, 0.85), (0.1, 1.1), (0.5, 1.3), (0.52, 1.36), (0.46, 1.36), (0.1, 1.22), (0.08, 1.5), (0.12, 1.62), (0, 1.75)]
    model.lathe("masonry", bowl, 40, (3.5, 4.4, 0))
    rng = random.Random(4)
    for x, y in ((-4.6, 3.1), (5.2, 2.6), (1.55, 6.9)):
        model.lathe("pot", [(0, 0), (0.24, 0), (0.34, 0.5), (0.36, 0.5), (0.36, 0.56), (0.3, 0.56), (0.28, 0.48), (0, 0.48)], 28, (x, y, 0))
        model.rod("wood", (x, y, 0.45), (x, y, 1.3), 0.04)
        leaves = []
        for _ in range(1500):
            h, a, r = 2 * rng.random() - 1, 2 * math.pi * rng.random(), 0.55 * rng.random() ** 0.25
            s = math.sqrt(1 - h * h)
            p = np.array([x + r * s * math.cos(a), y + r * s * math.sin(a), 1.75 + 1.2 * r * h])
            leaves += [p] + [p + np.array([rng.random() - 0.5 for _ in range(3)]) * 0.17 for _ in (0, 1)]
        model.add("leaf", leaves, np.arange(len(leaves)))
    model.box("wood", (-1.9, 3.4, 0.42), (-0.4, 3.8, 0.47))
    for x in (-1.75, -0.6):
        model.box("wood", (x, 3.44, 0), (x + 0.06, 3.76, 0.42))


def truss(model, y, z):
    """A lattice girder across the stage."""
    for dy, dz in ((-0.15, 0), (0.15, 0), (0, 0.26)):
        model.rod("steel", (-7.5, y + dy, z + dz), (7.5, y + dy, z + dz), 0.025, 6)
    for i in range(50):
        x = -7.5 + 0.3 * i
        for p, q in (((-0.15, 0), (0, 0.26)), ((0, 0.26), (0.15, 0)), ((0.15, 0), (-0.15, 0))):
            model.rod("steel", (x, y + p[0], z + p[1]), (x + 0.3, y + q[0], z + q[1]), 0.011, 4)


def housing(model, at, to):
    """A lamp's can about its beam, behind where the light begins."""
    at, to = np.array(at, float), np.array(to, float)
    d = (to - at) / np.linalg.norm(to - at)
    model.rod("steel", at - 0.05 * d, at - 0.42 * d, 0.11, 14, 0.08)


def lights(model):
    """(colour of luminance about 1, cd, from, to, half angle, edge) of the spots, and three projectors."""
    amber, blue, rose, steel, white = (1.7, 0.85, 0.25), (0.35, 0.85, 4.4), (2.3, 0.6, 0.85), (0.75, 1.02, 1.5), (1.12, 0.98, 0.86)
    spots = [
        (white, 26000, (-1.5, -11, 7.6), (0.9, 2.3, 0.95), 3.6, 0.25),  # the follow spot
        (amber, 7500, (-5.0, 1.6, GRID), (-4.2, 5.9, 1.0), 15, 9),
        (amber, 5500, (-2.4, 1.6, GRID), (-2.6, 6.6, 1.6), 14, 9),
        (blue, 5200, (5.2, 1.6, GRID), (4.0, 6.4, 2.2), 20, 12),
        (blue, 5200, (-6.2, 4.2, GRID), (-1.5, 7.2, 1.5), 20, 12),
        (steel, 5000, (3.2, 4.2, GRID), (3.5, 4.4, 0.6), 13, 6),
        (rose, 5600, (6.2, 4.2, GRID), (1.2, 6.9, 1.8), 18, 12),
        (rose, 4200, (0.2, 1.6, GRID), (-1.2, 3.4, 0.3), 14, 8),
        (steel, 6500, (4.8, 6.9, GRID), (0.9, 2.3, 1.2), 12, 7),  # from behind, for the outline
        (steel, 5200, (-4.8, 6.9, GRID), (-3.4, 5.9, 1.5), 12, 7),
        (amber, 2600, (-6.0, -1.6, 6.2), (-5.6, 0.3, 3.2), 24, 14),  # curtain and columns
        (amber, 2600, (6.0, -1.6, 6.2), (5.6, 0.3, 3.2), 24, 14),
        (white, 1500, (-4.2, -7.0, 5.0), (-3.2, 0.0, 6.6), 30, 20),  # what hangs above the stage
        (white, 1500, (4.2, -7.0, 5.0), (3.2, 0.0, 6.6), 30, 20),
    ]
    text = "# Made by make.py.\n"
    for colour, candela, at, to, cone, edge in spots:
        if at[1] > 0:
            housing(model, at, to)
        level = modelling.numbers((candela * c for c in colour), 1)
        text += (
            f'LightSource "spot" "rgb I" [{level}] "point3 from" [{modelling.numbers(at)}] "point3 to" [{modelling.numbers(to)}]\n'
            f'  "float coneangle" [{cone}] "float conedeltaangle" [{edge}]\n'
        )
    projectors = [
        ("slide.png", (0.9, 0.98, 1.25), 14000, (0.0, 1.9, GRID), (0.0, DEPTH - 0.4, 3.9), 62, "bilinear"),
        ("leaves.png", (0.8, 1.15, 0.5), 15000, (-3.4, 1.4, GRID), (-1.0, 2.9, 0.0), 42, "bilinear"),
        ("window.png", (1.25, 0.98, 0.6), 12000, (6.6, 3.6, GRID), (3.1, 2.0, 0.0), 26, "nearest"),
    ]
    for name, colour, candela, at, to, fov, edges in projectors:
        housing(model, at, to)
        level = modelling.numbers((candela * c for c in colour), 1)
        text += (
            f"AttributeBegin\n{aimed(at, to)}"
            f'  LightSource "projection" "string filename" "{name}" "rgb I" [{level}] "float fov" [{fov}] "string filter" "{edges}"\nAttributeEnd\n'
        )
    return text.encode()


def aimed(at, to):
    """The Transform that takes +z to the line from `at` to `to`, +y as far up as that allows, +x to its right."""
    n = np.array(to, float) - np.array(at, float)
    n /= np.linalg.norm(n)
    right = np.cross(n, (0, 0, 1))
    right /= np.linalg.norm(right)
    up = np.cross(right, n)
    columns = [*right, 0, *up, 0, *n, 0, *at, 1]
    return f"  ConcatTransform [{modelling.numbers(columns, 10**9)}]\n"


def slide(width=320, height=200):
    """The sky by the sea: stars, a moon over a headland, and its glitter on the water."""
    rng = random.Random(21)
    y, x = np.mgrid[0:height, 0:width]
    u, v = x / height, 1 - y / height  # v up
    horizon = 0.34
    t = ((v - horizon) / (1 - horizon)).clip(0, 1)
    dusk = np.stack([0.34 - 0.3 * t**0.5, 0.3 - 0.2 * t**0.6, 0.52 - 0.2 * t], 2)
    moon_u, moon_v = 1.02, 0.74
    glow = np.exp(-np.hypot(u - moon_u, v - moon_v) / 0.16)[..., None]
    picture = dusk + glow * np.array([0.35, 0.32, 0.24])
    for _ in range(220):
        i, j = int(rng.random() * height * 0.6), int(rng.random() * width)
        picture[i, j] += 0.25 + 0.7 * rng.random() ** 3
    disk = (1 - (np.hypot(u - moon_u, v - moon_v) - 0.085) * height / 1.5).clip(0, 1)[..., None]
    spots = 0.12 * np.sin(u * 61 + 2 * np.sin(v * 47)) * np.sin(v * 53)
    picture = picture * (1 - disk) + disk * (np.array([1.0, 0.96, 0.82]) + spots[..., None])
    for k in range(5):  # clouds
        cu, cv, long = 1.6 * rng.random(), 0.5 + 0.35 * rng.random(), 0.2 + 0.25 * rng.random()
        bank = np.exp(-(((u - cu) / long) ** 2) - ((v - cv) / 0.022) ** 2) * (0.7 + 0.3 * np.sin(40 * u + k))
        picture = picture * (1 - 0.6 * bank[..., None]) + bank[..., None] * np.array([0.2, 0.19, 0.26])
    depth = ((horizon - v) / horizon).clip(0, 1)
    ripples = 0.5 + 0.5 * np.sin(900 / (1 + 14 * depth) * (0.12 + v)) * np.sin(u * 90 / (0.4 + depth) + 13 * np.sin(v * 70))
    track = np.exp(-(((u - moon_u) / (0.05 + 0.16 * depth)) ** 2)) * ripples
    sea = np.array([0.05, 0.085, 0.16]) * (1 - 0.4 * depth[..., None]) + track[..., None] * np.array([0.8, 0.75, 0.6])
    picture = np.where((v < horizon)[..., None], sea, picture)
    headland = horizon + 0.16 * np.exp(-(((u - 0.2) / 0.26) ** 2)) + 0.012 * np.sin(37 * u) * (u < 0.55) + 0.05 * np.exp(-(((u - 1.6) / 0.13) ** 2))
    land = (v < headland) & (v > horizon - 0.012 * (u < 0.6))
    picture[land] = (0.02, 0.025, 0.045)
    return srgb(picture)


def leaves(n=192):
    """Light through foliage: overlapping leaves cut out of black, soft at the rim."""
    rng = random.Random(22)
    y, x = np.mgrid[0:n, 0:n]
    u, v = (x + 0.5) / n * 2 - 1, (y + 0.5) / n * 2 - 1
    light = np.ones((n, n))
    for _ in range(120):
        cu, cv, turn, long = 2.2 * rng.random() - 1.1, 2.2 * rng.random() - 1.1, 2 * math.pi * rng.random(), 0.13 + 0.13 * rng.random()
        a = (u - cu) * math.cos(turn) + (v - cv) * math.sin(turn)
        b = (v - cv) * math.cos(turn) - (u - cu) * math.sin(turn)
        shape = 1 - np.abs(b) / (0.36 * long * (1 - (a / long) ** 2).clip(1e-3, 1)) - (np.abs(a) > long)
        light *= 1 - (shape * 4).clip(0, 1)
    rim = ((1 - np.hypot(u, v)) * 9).clip(0, 1)
    return srgb(light * rim)


def window(n=160):
    """A tall window of two by four panes, the upper ones in a round head."""
    y, x = np.mgrid[0:n, 0:n]
    u, v = ((x + 0.5) / n * 2 - 1) * 1.8, 1 - (y + 0.5) / n * 2
    inside = (np.abs(u) < 0.8) & (v > -0.95) & ((v < 0.15) | (np.hypot(u, v - 0.15) < 0.8))
    bars = (np.abs(u) < 0.05) | (np.abs((v + 0.95) % 0.48 - 0.24) > 0.215)
    return srgb(np.where(inside & ~bars, 1.0, 0.0))


def srgb(linear):
    c = linear.clip(0, 1)
    return np.floor(np.where(c <= 0.0031308, 12.92 * c, 1.055 * np.maximum(c, 1e-9) ** (1 / 2.4) - 0.055) * 255 + 0.41421)


def make():
    model = modelling.Model(SURFACES)
    house(model)
    arch(model, 4.6, 7.3, -14, 2.0, 3.6)
    arch(model, 1.7, 7.7, 0, 2.0, 3.6)
    stairs(model)
    people(model)
    properties(model)
    for y in (1.6, 4.2, 6.9):
        truss(model, y, GRID + 0.15)
    text = lights(model)
    files = model.files()
    files["lights.pbrt"] = text
    files["slide.png"] = modelling.png(slide())
    files["leaves.png"] = modelling.png(leaves())
    files["window.png"] = modelling.png(window())
    floor = [(-6.2 + 12.4 * i / 23, -0.8 + 8.4 * j / 15, 0, 0, 0, 1) for i in range(24) for j in range(16)]
    # Upright, a metre and a half over the boards, towards the house; and the backdrop.
    faces = [(-5.5 + 11 * i / 15, 0.6 + 0.9 * j, 1.5, 0, -1, 0) for i in range(16) for j in range(3)]
    cloth = [(-6.5 + 13 * i / 15, DEPTH - 0.4, 0.6 + 6.2 * j / 7, 0, -1, 0) for i in range(16) for j in range(8)]
    files["points.csv"] = modelling.csv([p for p in floor if not on_scenery(*p[:2])] + faces + cloth)
    return files


def on_scenery(x, y):
    on_stairs = x < -2.5 and 4.9 < y < 7.1
    in_basin = math.hypot(x - 3.5, y - 4.4) < 1.15
    under_gown = math.hypot(x - 0.9, y - 2.3) < 0.7
    in_tub = any(math.hypot(x - u, y - v) < 0.4 for u, v in ((-4.6, 3.1), (5.2, 2.6), (1.55, 6.9)))
    in_arch = y > 6.9 and x > 0
    return on_stairs or in_basin or under_gown or in_tub or in_arch


if __name__ == "__main__":
    modelling.main(__file__, make)
