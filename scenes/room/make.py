#!/usr/bin/python3
"""Writes the data of the room: photometric files, building and furniture, downlights, and the points to measure at.

Debian packages: those of modelling.py.
"""
import math
import pathlib
import random
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import modelling

WIDTH, DEPTH, HEIGHT = 9.0, 6.5, 3.2
WINDOW = (2.6, 0.9), (5.8, 2.5)  # x, z in the far wall
TABLES = (2.2, 4.5, 6.8)  # x of their middles
TABLE_Y = 3.1
SURFACES = {
    "wall": (0.78, 0.76, 0.72),
    "ceiling": (0.85, 0.85, 0.84),
    "feature": (0.16, 0.24, 0.27),
    "skirting": (0.7, 0.7, 0.68),
    "board_a": modelling.coated((0.42, 0.28, 0.17), 0.15),
    "board_b": modelling.coated((0.36, 0.235, 0.14), 0.15),
    "board_c": modelling.coated((0.47, 0.325, 0.2), 0.15),
    "board_d": modelling.coated((0.31, 0.2, 0.12), 0.15),
    "oak": modelling.coated((0.55, 0.4, 0.25), 0.4),
    "white": (0.82, 0.82, 0.8),
    "black": (0.04, 0.04, 0.045),
    "steel": modelling.named_metal("Cr", 0.15),
    "rug": (0.35, 0.12, 0.1),
    "rug_line": (0.7, 0.62, 0.5),
    "seat": (0.55, 0.2, 0.08),
    "leaf": modelling.leaf((0.1, 0.26, 0.07), (0.05, 0.13, 0.02)),
    "glass": modelling.PANE,
    "soil": (0.1, 0.07, 0.05),
    "pot": modelling.coated((0.72, 0.7, 0.66), 0.05),
    "red": (0.62, 0.1, 0.07),
    "blue": (0.08, 0.17, 0.45),
    "yellow": (0.78, 0.58, 0.1),
    "green": (0.15, 0.36, 0.2),
    "paper": (0.8, 0.78, 0.74),
}
# What stands higher than the working plane: low and high corner in x, y.
TALL = []


def building(model):
    (left, sill), (right, head) = WINDOW
    model.box("ceiling", (0, 0, HEIGHT), (WIDTH, DEPTH, HEIGHT + 0.2))
    model.box("wall", (-0.2, 0, 0), (0, DEPTH, HEIGHT))
    model.box("feature", (WIDTH, 0, 0), (WIDTH + 0.2, DEPTH, HEIGHT))
    model.box("wall", (0, -0.2, 0), (WIDTH, 0, HEIGHT))
    for low, high in (((0, 0), (left, HEIGHT)), ((right, 0), (WIDTH, HEIGHT)), ((left, 0), (right, sill)), ((left, head), (right, HEIGHT))):
        model.box("wall", (low[0], DEPTH, low[1]), (high[0], DEPTH + 0.3, high[1]))
    model.box("white", (left - 0.05, DEPTH - 0.12, sill - 0.04), (right + 0.05, DEPTH, sill))
    for i in range(5):  # mullions
        x = left + (right - left) * i / 4
        model.box("white", (x - 0.03, DEPTH + 0.16, sill), (x + 0.03, DEPTH + 0.22, head))
    for z in (sill, sill + 1.05, head - 0.05):
        model.box("white", (left, DEPTH + 0.16, z), (right, DEPTH + 0.22, z + 0.05))
    model.quad("glass", (left, DEPTH + 0.19, sill), (right, DEPTH + 0.19, sill), (right, DEPTH + 0.19, head), (left, DEPTH + 0.19, head))
    for low, high in (((0, DEPTH - 0.015), (WIDTH, DEPTH)), ((0, 0), (0.015, DEPTH)), ((WIDTH - 0.015, 0), (WIDTH, DEPTH))):
        model.box("skirting", (*low, 0), (*high, 0.09))
    boards(model)
    rng = random.Random(3)
    for i in range(26):  # the town, dark before the sky
        x, tall, wide = -45 + 5 * i, 3.2 + 4.6 * rng.random() ** 2, 3 + 4 * rng.random()
        model.box("black", (x, 60 + 10 * rng.random(), -8), (x + wide, 75, tall - 5))


def boards(model):
    """Of four shades, 14 cm wide, along x, with joints of a millimetre above black."""
    rng = random.Random(1)
    model.quad("black", (0, 0, -0.004), (WIDTH, 0, -0.004), (WIDTH, DEPTH, -0.004), (0, DEPTH, -0.004))
    for row in range(47):
        y, x = row * 0.14, -1.8 * rng.random()
        while x < WIDTH:
            end = x + 1.6 + 0.9 * rng.random()
            shade = "board_" + "abcd"[int(rng.random() * 4)]
            a, b = max(x, 0), min(end, WIDTH)
            u, v = y + 0.001, min(y + 0.139, DEPTH)
            model.quad(shade, (a, u, 0), (b - 0.001, u, 0), (b - 0.001, v, 0), (a, v, 0))
            x = end


def table(model, x):
    with model.placed((x, TABLE_Y, 0)):
        model.box("oak", (-0.45, -1.1, 0.71), (0.45, 1.1, 0.74))
        for y in (-0.95, 0.95):
            for u in (-0.36, 0.36):
                model.rod("black", (u, y, 0.71), (u * 1.1, y * 1.05, 0), 0.022)
            model.box("black", (-0.38, y - 0.02, 0.68), (0.38, y + 0.02, 0.71))


def chair(model, x, y, turn):
    with model.placed((x, y, 0), turn):
        model.box("seat", (-0.22, -0.22, 0.44), (0.22, 0.22, 0.48))
        back = [[(-0.22 + 0.44 * i / 8, 0.21 + 0.05 * math.sin(math.pi * i / 8) + 0.08 * j, 0.55 + 0.32 * j) for i in range(9)] for j in (0, 1)]
        model.grid("seat", modelling.np.array(back))
        for u in (-0.19, 0.19):
            model.rod("steel", (u, -0.19, 0.44), (u * 1.15, -0.23, 0), 0.012)
            model.rod("steel", (u, 0.21, 0.88), (u, 0.19, 0.44), 0.012)
            model.rod("steel", (u, 0.19, 0.44), (u * 1.15, 0.23, 0), 0.012)


def desk_things(model, x, rng):
    """A screen, a keyboard, paper, books and a mug, on a table's two places."""
    for y in (-0.55, 0.55):
        with model.placed((x, TABLE_Y + y, 0.74), 90):
            model.box("black", (-0.12, -0.09, 0), (0.12, 0.09, 0.012))
            model.box("black", (-0.02, -0.02, 0.012), (0.02, 0.0, 0.16))
            model.box("black", (-0.27, -0.035, 0.12), (0.27, -0.02, 0.45))
            model.box("steel", (-0.26, -0.0355, 0.13), (0.26, -0.035, 0.44))
            model.box("white", (-0.21, -0.33, 0), (0.21, -0.2, 0.018))
        TALL.append((x - 0.12, TABLE_Y + y - 0.3, x + 0.12, TABLE_Y + y + 0.3))
        with model.placed((x + 0.26, TABLE_Y + y - 0.15, 0.74), 15 * rng.random()):
            model.box("paper", (-0.105, -0.15, 0), (0.105, 0.15, 0.004))
    TALL.append((x - 0.2, TABLE_Y - 0.2, x + 0.16, TABLE_Y + 0.16))
    height = 0.74
    for colour in ("blue", "paper", "red"):
        with model.placed((x - 0.02, TABLE_Y - 0.02, height), 30 * rng.random()):
            model.box(colour, (-0.09, -0.12, 0), (0.09, 0.12, 0.03))
        height += 0.03
    model.lathe("yellow", [(0, 0), (0.04, 0), (0.04, 0.09), (0.035, 0.09), (0.035, 0.01), (0, 0.01)], 20, (x - 0.3, TABLE_Y + 0.1, 0.74))


def shelf(model, rng):
    """Of 2 x 2.1 m against the far wall, with books."""
    x, y, width, depth, height = 0.25, DEPTH - 0.32, 2.0, 0.32, 2.1
    TALL.append((x - 0.05, y - 0.05, x + width + 0.05, DEPTH))
    for i in range(6):
        z = (height - 0.03) * i / 5
        model.box("oak", (x, y, z), (x + width, y + depth, z + 0.03))
    for u in (0, width / 2 - 0.012, width - 0.025):
        model.box("oak", (x + u, y, 0), (x + u + 0.025, y + depth, height))
    model.box("white", (x, y + depth - 0.012, 0), (x + width, y + depth, height))
    colours = ("red", "blue", "paper", "yellow", "green", "black", "white", "seat", "paper")
    for level in range(5):
        z = (height - 0.03) * level / 5 + 0.03
        for side in (0.03, width / 2 + 0.02):
            at, end = x + side, x + side + width / 2 - 0.1 - 0.35 * rng.random()
            while at < end:
                thick, tall = 0.018 + 0.03 * rng.random(), 0.22 + 0.13 * rng.random()
                front = y + 0.03 + 0.03 * rng.random()
                model.box(colours[int(rng.random() * len(colours))], (at, front, z), (at + thick, front + 0.2, z + tall))
                at += thick + 0.002


def picture(model, y, kind):
    """0.9 x 1.1 m on the right wall, in a frame; seen from the room, its own x runs along -y."""
    with model.placed((WIDTH, y, 1.62), -90):
        # Own frame: x along -y of the room, y into the wall.
        model.box("black", (-0.49, -0.035, -0.6), (0.49, 0, 0.6))
        model.box("paper", (-0.45, -0.04, -0.56), (0.45, -0.035, 0.56))
        if kind == 0:
            for i in range(5):
                model.box(("blue", "green", "yellow", "red", "black")[i], (-0.36 + 0.15 * i, -0.045, -0.4), (-0.26 + 0.15 * i, -0.04, -0.1 + 0.12 * i))
        elif kind == 1:
            for r, colour, depth in ((0.36, "red", 0.042), (0.25, "paper", 0.044), (0.16, "blue", 0.046)):
                outline = [(r * math.cos(2 * math.pi * i / 40), r * math.sin(2 * math.pi * i / 40)) for i in range(40)]
                model.add(colour, [(0, -depth, 0)] + [(u, -depth, v) for u, v in outline], [(0, 1 + i, 1 + (i + 1) % 40) for i in range(40)])
        else:
            for low, high, colour in (((-0.4, -0.5), (0.02, 0.16), "yellow"), ((0.07, -0.12), (0.4, 0.5), "red"), ((-0.4, 0.22), (0.02, 0.5), "blue"), ((0.07, -0.5), (0.4, -0.18), "black")):
                model.box(colour, (low[0], -0.045, low[1]), (high[0], -0.04, high[1]))


def plant(model, x, y, rng):
    TALL.append((x - 0.4, y - 0.4, x + 0.4, y + 0.4))
    model.lathe("pot", [(0, 0), (0.17, 0), (0.22, 0.42), (0.2, 0.42), (0.19, 0.36), (0, 0.36)], 32, (x, y, 0))
    model.lathe("soil", [(0.19, 0.37), (0, 0.37)], 32, (x, y, 0))
    for i in range(42):
        turn, reach, rise = 2 * math.pi * rng.random(), 0.2 + 0.5 * rng.random(), 0.5 + 0.8 * rng.random()
        width = 0.035 + 0.02 * rng.random()
        c, s = math.cos(turn), math.sin(turn)
        rows = []
        for k in range(9):
            t = k / 8
            r, z = 0.05 + reach * t, 0.37 + rise * (1.55 * t - t * t * (0.55 + 0.5 * reach))
            w = width * math.sin(math.pi * min(1, 0.12 + 0.88 * t)) + 0.002
            rows.append([(x + c * r - s * w, y + s * r + c * w, z), (x + c * r, y + s * r, z - 0.3 * w), (x + c * r + s * w, y + s * r - c * w, z)])
        model.grid("leaf", modelling.np.array(rows))


def furniture(model):
    rng = random.Random(2)
    for x in TABLES:
        table(model, x)
        desk_things(model, x, rng)
        for side, turn in ((-1, 90), (1, -90)):
            for y in (-0.55, 0.55):
                chair(model, x + side * (0.62 + 0.12 * rng.random()), TABLE_Y + y + 0.1 * (rng.random() - 0.5), turn + 24 * (rng.random() - 0.5))
    shelf(model, rng)
    for y, kind in ((1.6, 0), (3.1, 1), (4.6, 2)):
        picture(model, y, kind)
    plant(model, 8.35, 5.85, rng)
    # A rug before the far wall, with stripes, and a bench on it.
    model.box("rug", (3.0, 5.0, 0), (6.4, 6.2, 0.012))
    for x in (3.15, 3.3, 6.05, 6.2):
        model.box("rug_line", (x, 5.0, 0.012), (x + 0.05, 6.2, 0.013))
    model.box("oak", (3.7, 5.5, 0.4), (5.6, 5.95, 0.45))
    for x in (3.85, 5.4):
        model.box("black", (x, 5.53, 0.0), (x + 0.05, 5.92, 0.4))


def luminaires(model):
    """What the pendants hang by, the downlights' rings, and where the downlights are."""
    for x in TABLES:
        with model.placed((x, TABLE_Y, 2.1)):
            # The panel hangs in wire: a housing a finger's breadth from it would be lit by a sliver of it.
            for v in (-0.77, 0.77):
                model.rod("steel", (-0.06, v, 0), (0.06, v, 0), 0.008)
                model.rod("black", (0, v, 0), (0, v, HEIGHT - 2.1), 0.003, 6)
    text = "# Made by make.py.  Straight down is +z of a light's space.\n"
    for x, lean, places in ((WIDTH - 1.1, 20, (0.9, 2.35, 3.85, 5.35)), (0.9, 0, (0.9, 2.4, 3.9, 5.4))):
        for y in places:
            model.lathe("white", [(0.055, 0.0), (0.075, 0.0), (0.075, -0.012), (0.055, -0.012), (0.05, 0.0)], 24, (x, y, HEIGHT))
            text += f"AttributeBegin\n  Translate {x:g} {y:g} {HEIGHT - 0.02:g}\n  Rotate {180 - lean:g} 0 1 0\n"
            text += '  LightSource "goniometric" "string filename" "downlight.ies" "rgb I" [1.2 0.97 0.68]\nAttributeEnd\n'
    return text.encode()


def downlight(v, h):
    """A reflector's beam with half its intensity at 24 degrees, and a little beyond the shielding angle."""
    return math.exp(-math.log(2) * (v / 24) ** 2.4) * min(1, max(0, (78 - v) / 20)) + 0.004 * max(0, math.cos(math.radians(v)))


def pendant(v, h):
    """A batwing below, wider across the luminaire (C0), and more than a third of the light upwards."""
    across = 0.5 + 0.5 * math.cos(math.radians(2 * h))
    c = math.cos(math.radians(v))
    if v <= 90:
        return c * (1 + (0.35 + 0.65 * across) * math.sin(math.radians(v)) ** 2)
    return -c * (0.6 + (0.2 + 0.6 * across) * math.sin(math.radians(v)) ** 2)


def make():
    TALL.clear()
    model = modelling.Model(SURFACES)
    building(model)
    furniture(model)
    lights = luminaires(model)
    files = model.files()
    files["downlights.pbrt"] = lights
    files["downlight.ies"] = modelling.ies(("DOWNLIGHT 900", "a recessed reflector, 48 degrees"), 900, downlight, [2.5 * i for i in range(37)])
    files["pendant.ies"] = modelling.ies(("PENDANT 4500", "a linear pendant, up and down"), 4500, pendant, [5 * i for i in range(37)], [15 * i for i in range(7)], (0.08, 1.5, 0))
    # The working plane, where nothing stands in it, half a metre from the walls.
    plane = [(0.5 + 8 * i / 32, 0.5 + 5.5 * j / 22) for i in range(33) for j in range(23)]
    files["points.csv"] = modelling.csv(
        (x, y, 0.8, 0, 0, 1) for x, y in plane if not any(a < x < c and b < y < d for a, b, c, d in TALL)
    )
    return files


if __name__ == "__main__":
    modelling.main(__file__, make)
