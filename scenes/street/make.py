#!/usr/bin/python3
"""Writes the data of the street: houses, its thousands of lights, and the points to measure at.

Debian packages: those of modelling.py.
"""
import math
import pathlib
import random
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import modelling
from houses import FRONT, LENGTH, houses
from lamps import COLD, WARM, WHITE, Lights

KERB = 3.6  # half width of the road
SURFACES = {
    "asphalt": modelling.coated((0.05, 0.05, 0.055), 0.08, 1.33),  # wet
    "line": (0.6, 0.6, 0.58),
    "paving": modelling.coated((0.2, 0.19, 0.18), 0.35, 1.33),
    "paving_dark": modelling.coated((0.15, 0.145, 0.14), 0.35, 1.33),
    "kerb": (0.28, 0.27, 0.26),
    "facade_a": (0.5, 0.24, 0.16),
    "facade_b": (0.58, 0.47, 0.28),
    "facade_c": (0.26, 0.36, 0.4),
    "facade_d": (0.56, 0.52, 0.46),
    "facade_e": (0.42, 0.17, 0.14),
    "facade_f": (0.28, 0.36, 0.25),
    "trim": (0.62, 0.6, 0.55),
    "roof": (0.1, 0.09, 0.09),
    "frame": (0.5, 0.48, 0.44),
    "glass": modelling.coated((0.03, 0.035, 0.04), 0),  # before dark rooms
    "shop_window": modelling.PANE,
    "black": (0.03, 0.03, 0.03),
    "wood": (0.3, 0.19, 0.11),
    "shop": (0.66, 0.62, 0.56),
    "awning_a": (0.55, 0.09, 0.08),
    "awning_b": (0.09, 0.22, 0.36),
    "awning_c": (0.68, 0.62, 0.5),
    "leaf": (0.09, 0.2, 0.05),
    "goods_a": (0.6, 0.15, 0.1),
    "goods_b": (0.12, 0.3, 0.5),
    "goods_c": (0.7, 0.55, 0.15),
    "car": modelling.coated((0.4, 0.05, 0.05), 0.02),
    "car_blue": modelling.coated((0.06, 0.12, 0.28), 0.02),
    "chrome": modelling.named_metal("Cr", 0.05),
    "tower": (0.12, 0.12, 0.14),
}


def road(model):
    model.quad("asphalt", (-KERB, -12, 0), (KERB, -12, 0), (KERB, LENGTH + 60, 0), (-KERB, LENGTH + 60, 0))
    for i in range(28):
        y = -10 + 3.2 * i
        model.box("line", (-0.06, y, 0), (0.06, y + 1.5, 0.004))
    rng = random.Random(1)
    for side in (-1, 1):
        a, b = sorted((side * KERB, side * (KERB + 0.16)))
        model.box("kerb", (a, -12, 0), (b, LENGTH + 60, 0.13))
        for i in range(150):  # slabs
            for j in range(4):
                y, x = -12 + 0.62 * i, KERB + 0.16 + 0.61 * j
                u, v = sorted((side * x, side * (x + 0.6)))
                model.box("paving" if rng.random() < 0.7 else "paving_dark", (u, y, 0), (v, y + 0.61, 0.118 + 0.004 * rng.random()))


STROKES = {  # letters of upright and level strokes: y from, z from, y to, z to, of 2 x 4
    "A": ((0, 0, 0, 4), (2, 0, 2, 4), (0, 4, 2, 4), (0, 2, 2, 2)),
    "B": ((0, 0, 0, 4), (2, 0, 2, 4), (0, 4, 2, 4), (0, 2, 2, 2), (0, 0, 2, 0)),
    "C": ((0, 0, 0, 4), (0, 4, 2, 4), (0, 0, 2, 0)),
    "E": ((0, 0, 0, 4), (0, 4, 2, 4), (0, 2, 1.6, 2), (0, 0, 2, 0)),
    "F": ((0, 0, 0, 4), (0, 4, 2, 4), (0, 2, 1.6, 2)),
    "H": ((0, 0, 0, 4), (2, 0, 2, 4), (0, 2, 2, 2)),
    "I": ((1, 0, 1, 4),),
    "L": ((0, 0, 0, 4), (0, 0, 2, 0)),
    "O": ((0, 0, 0, 4), (2, 0, 2, 4), (0, 4, 2, 4), (0, 0, 2, 0)),
    "P": ((0, 0, 0, 4), (2, 2, 2, 4), (0, 4, 2, 4), (0, 2, 2, 2)),
    "T": ((1, 0, 1, 4), (0, 4, 2, 4)),
}


def neon(lights, model, side, y, z, word, size, colour, level):
    """A word on a facade, read from the street."""
    x = side * (FRONT - 0.2)
    a, b = sorted((x + side * 0.05, x + side * 0.1))
    long = 3.1 * size * len(word)
    model.box("black", (a, y - size, z - size), (b, y + long, z + 5 * size))
    for i, letter in enumerate(word):
        for p, q, r, s in STROKES[letter]:
            # Facing -x, what is read from left to right runs along -y.
            at = [(y + long - size - (3.1 * i + u) * size if side > 0 else y + (3.1 * i + u) * size, z + v * size) for u, v in ((p, q), (r, s))]
            lights.tube(level, colour, (x, *at[0]), (x, *at[1]))


def signs(model, lights):
    red, cyan, green, pink = (3.6, 0.3, 0.15), (0.15, 1.1, 2.2), (0.4, 1.25, 0.3), (2.6, 0.45, 1.6)
    neon(lights, model, 1, 9.0, 4.4, "HOTEL", 0.16, red, 2200)
    neon(lights, model, -1, 15.5, 3.7, "CAFE", 0.15, cyan, 2200)
    neon(lights, model, -1, 4.0, 3.8, "TABAC", 0.14, pink, 2200)
    neon(lights, model, 1, 26.0, 3.7, "PATIO", 0.15, green, 2200)
    # A marquee over the pavement on the left, 30 m on: a box edged with bulbs, chevrons on its front.
    x0, x1, y0, y1, z0, z1 = -FRONT, -KERB + 0.2, 24.0, 31.0, 3.3, 4.3
    model.box("awning_a", (x0, y0, z0), (x1, y1, z1))
    for i in range(60):
        t = i / 59
        for z in (z0 + 0.06, z1 - 0.06):
            lights.bulb(22, WARM, (x1 + 0.03, y0 + (y1 - y0) * t, z), 0.024)
    for i in range(22):
        for z in (z0 + 0.06, z1 - 0.06):
            lights.bulb(22, WARM, (x0 + (x1 - x0) * (i + 0.5) / 22, y0 - 0.03, z), 0.024)
    for i in range(14):
        for j in range(5):
            lights.point(9, WARM, (x0 + (x1 - x0) * (j + 0.5) / 5, y0 + (y1 - y0) * (i + 0.5) / 14, z0 - 0.03))
    for i in range(12):
        y = y0 + 0.3 + (y1 - y0 - 0.6) * i / 12
        lights.triangle(350, (0.3, 1.1, 1.9) if i % 2 else WARM, (x1 + 0.01, y, z0 + 0.25), (x1 + 0.01, y + 0.4, z0 + 0.5), (x1 + 0.01, y, z0 + 0.75))


def lanterns(model, lights):
    for i in range(6):
        for side in (-1, 1):
            x, y = side * (KERB + 0.45), 3.5 + 13.0 * i + (6.5 if side > 0 else 0)
            model.lathe("black", [(0.14, 0), (0.14, 0.25), (0.08, 0.35), (0.055, 0.5), (0.045, 4.9), (0, 4.95)], 14, (x, y, 0.12))
            model.rod("black", (x, y, 4.7), (x - side * 0.9, y, 5.0), 0.03)
            model.lathe("black", [(0, 0.3), (0.05, 0.28), (0.26, 0.06), (0.27, 0.0), (0.25, 0.0), (0.04, 0.25), (0, 0.26)], 18, (x - side * 0.9, y, 4.86))
            lights.lantern((x - side * 0.9, y, 4.82), 0 if side < 0 else 180)


def strings(model, lights):
    """Garlands of bulbs from front to front."""
    rng = random.Random(9)
    for k in range(15):
        y, z, count = 1.0 + 4.9 * k, 6.1 + 0.9 * rng.random(), 44
        skew = 1.4 * (rng.random() - 0.5)
        last = None
        for i in range(count + 1):
            t = 2 * i / count - 1
            p = (FRONT * t, y + skew * t, z - 1.15 * (1 - t * t))
            if last is not None:
                model.rod("black", last, p, 0.006, 4)
                if i < count:
                    lights.bulb(16, WARM, (p[0], p[1], p[2] - 0.05), 0.03)
            last = p


def trees(model, lights):
    """In boxes on the pavement, lamps all over them."""
    rng = random.Random(10)
    for i in range(8):
        side = -1 if i % 2 else 1
        x, y = side * 5.2, 6.4 + 8.1 * i
        model.box("wood", (x - 0.35, y - 0.35, 0.12), (x + 0.35, y + 0.35, 0.6))
        model.rod("wood", (x, y, 0.6), (x, y, 1.5), 0.04)
        leaves = []
        for _ in range(420):
            h, a, r = 2 * rng.random() - 1, 2 * math.pi * rng.random(), 0.62 * rng.random() ** 0.4
            s = math.sqrt(1 - h * h)
            p = modelling.np.array([x + r * s * math.cos(a), y + r * s * math.sin(a), 2.0 + 1.15 * r * h])
            leaves += [p] + [p + modelling.np.array([rng.random() - 0.5 for _ in range(3)]) * 0.2 for _ in (0, 1)]
        model.add("leaf", leaves, modelling.np.arange(len(leaves)))
        for _ in range(105):
            h, a = 2 * rng.random() - 1, 2 * math.pi * rng.random()
            s = math.sqrt(1 - h * h)
            at, colour = (x + 0.66 * s * math.cos(a), y + 0.66 * s * math.sin(a), 2.0 + 0.76 * h), WHITE if rng.random() < 0.8 else WARM
            if i < 3:
                lights.bulb(2.5, colour, at, 0.009)
            else:  # too far off to be more than a point
                lights.point(0.2, colour, at)


def car(model, lights, x, y, surface, towards):
    """`towards`: -1 for one that comes, with its headlamps on, 0 for one that is parked."""
    body = [(-2.1, 0.35), (2.1, 0.35), (2.15, 0.75), (1.2, 0.85), (0.55, 1.35), (-1.0, 1.38), (-1.7, 0.9), (-2.15, 0.8)]
    with model.placed((x, y, 0), -90 if towards < 0 else 90):
        n = len(body)
        vertices = [(u, v, z) for v in (-0.82, 0.82) for u, z in body]
        sides = [f for i in range(n) for j in [(i + 1) % n] for f in ((i, n + j, j), (i, n + i, n + j))]
        caps = [(0, i, i + 1) for i in range(1, n - 1)] + [(n, n + i + 1, n + i) for i in range(1, n - 1)]
        model.add(surface, vertices, sides + caps)
        for v in (-0.825, 0.825):
            model.add("glass", [(0.95, v, 0.9), (0.5, v, 1.27), (-0.95, v, 1.3), (-1.45, v, 0.92)], [(0, 1, 2), (0, 2, 3)])
        model.add("glass", [(1.22, -0.7, 0.87), (1.22, 0.7, 0.87), (0.62, 0.68, 1.33), (0.62, -0.68, 1.33)], [(0, 1, 2), (0, 2, 3)])
        model.add("glass", [(-1.66, -0.68, 0.95), (-1.66, 0.68, 0.95), (-1.06, 0.66, 1.36), (-1.06, -0.66, 1.36)], [(0, 1, 2), (0, 2, 3)])
        model.box("chrome", (-2.2, -0.75, 0.38), (-2.12, 0.75, 0.47))
        model.box("line", (-2.17, -0.26, 0.52), (-2.13, 0.26, 0.64))
        for v in (-0.78, 0.56):
            model.box("goods_a", (-2.18, v, 0.6), (-2.1, v + 0.22, 0.74))
        for u in (-1.3, 1.35):
            for v in (-0.84, 0.64):
                model.rod("black", (u, v, 0.32), (u, v + 0.2, 0.32), 0.32, 20)
                model.rod("chrome", (u, v - 0.005, 0.32), (u, v + 0.205, 0.32), 0.17, 16)
    if towards < 0:
        for v in (-0.6, 0.6):
            lights.spot(9000, WHITE, (x + v, y - 2.2, 0.66), (x + v + 0.4, y - 22, 0.0), 16, 12)
            lights.rectangle(6000, WHITE, (x + v - 0.1, y - 2.17, 0.6), (0.2, 0, 0), (0, 0, 0.12))


def town(model, lights):
    """Towers beyond the end of the street, their windows single rectangles."""
    rng = random.Random(12)
    for x, y, width, tall in ((-17, 112, 9, 34), (-5.5, 126, 10, 44), (6.5, 108, 8, 28), (15, 120, 10, 38)):
        model.box("tower", (x - width / 2, y, 0), (x + width / 2, y + 10, tall))
        for i in range(int(width / 0.95)):
            for j in range(int(tall / 1.9)):
                if rng.random() < 0.56:
                    colour = (WARM, WHITE, COLD)[int(rng.random() * 3)]
                    lights.rectangle(8 + 6 * int(rng.random() * 4), colour, (x - width / 2 + 0.3 + 0.95 * i, y - 0.05, 1.2 + 1.9 * j), (0.55, 0, 0), (0, 0, 0.95))


def lantern(v, h):
    """Of a street: most at 60 degrees from straight down along the kerb, C90 and C270, less towards the houses."""
    along = abs(math.sin(math.radians(h)))
    lobe = math.exp(-(((v - 58) / 17) ** 2)) * (0.25 + 0.75 * along**2)
    return (0.55 * max(0, math.cos(math.radians(v))) + lobe) * min(1, max(0, (86 - v) / 12))


def make():
    model, lights = modelling.Model(SURFACES), Lights()
    road(model)
    houses(model, lights)
    signs(model, lights)
    lanterns(model, lights)
    strings(model, lights)
    trees(model, lights)
    car(model, lights, -1.7, 33, "car", -1)
    for x, y, surface in ((2.75, 12.5, "car_blue"), (-2.75, 9.5, "car"), (2.75, 24, "awning_c"), (2.75, 41, "car")):
        car(model, lights, x, y, surface, 0)
    town(model, lights)
    files = model.files()
    files["lights.pbrt"] = lights.text()
    files["lantern.ies"] = modelling.ies(("LANTERN 5200", "a street lantern, its road along C90"), 5200, lantern, [2.5 * i for i in range(37)], [15 * i for i in range(7)])
    # Road and pavements.
    points = [(-3.3 + 6.6 * i / 7, 1.5 + 70 * j / 49, 0) for j in range(50) for i in range(8)]
    points += [(side * 4.9, 1.0 + 70 * j / 49, 0.13) for j in range(50) for side in (-1, 1)]
    files["points.csv"] = modelling.csv((x, y, z, 0, 0, 1) for x, y, z in points if not under_a_car(x, y) and not (z > 0 and in_a_tree_box(y)))
    return files


def under_a_car(x, y):
    return any(abs(x - u) < 0.95 and abs(y - v) < 2.3 for u, v in ((-1.7, 33), (2.75, 12.5), (-2.75, 9.5), (2.75, 24), (2.75, 41)))


def in_a_tree_box(y):
    return any(abs(y - (6.4 + 8.1 * i)) < 0.5 for i in range(8))


if __name__ == "__main__":
    modelling.main(__file__, make)
