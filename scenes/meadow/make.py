#!/usr/bin/python3
"""Writes the data of the meadow: sky and sun, terrain, stones, cottage, trees and grass, and the points to measure at.

The sky's luminance: CIE standard general sky, type 12, "CIE standard clear sky, low luminance turbidity" (ISO 15469:2004 /
CIE S 011/E:2003).  Its chromaticity: A. J. Preetham, P. Shirley, B. Smits, A practical analytic model for daylight, SIGGRAPH
1999, appendix 2, turbidity 2.5.  Debian packages: those of modelling.py.
"""
import math
import pathlib
import random
import sys

import numpy as np

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import modelling

SUN_ELEVATION, SUN_AZIMUTH = math.radians(27), math.radians(205)  # azimuth from +x towards +y
SUN_LX, SKY_LX = 78000, 11000
SUN = np.array(
    [
        math.cos(SUN_ELEVATION) * math.cos(SUN_AZIMUTH),
        math.cos(SUN_ELEVATION) * math.sin(SUN_AZIMUTH),
        math.sin(SUN_ELEVATION),
    ]
)
TURBIDITY = 2.5
CAMERA = (0.0, -16.0)
SURFACES = {
    "meadow": (0.11, 0.16, 0.05),
    "grass": modelling.leaf((0.13, 0.21, 0.05), (0.06, 0.1, 0.02)),
    "dry_grass": (0.3, 0.28, 0.11),
    "flower": (0.75, 0.2, 0.12),
    "daisy": (0.8, 0.8, 0.72),
    "hill": (0.08, 0.13, 0.06),
    "stone": (0.34, 0.32, 0.29),
    "plaster": (0.72, 0.66, 0.55),
    "roof": (0.38, 0.15, 0.09),
    "timber": (0.16, 0.1, 0.06),
    "pane": modelling.coated((0.05, 0.06, 0.07), 0),
    "bark": (0.16, 0.12, 0.08),
    "leaf": modelling.leaf((0.1, 0.19, 0.04), (0.07, 0.13, 0.02)),
    "leaf_light": modelling.leaf((0.19, 0.27, 0.06), (0.12, 0.19, 0.03)),
}


def perez(a, b, c, d, e, cos_theta, gamma):
    """The product of gradation and indicatrix, not divided by that of the zenith."""
    return (1 + a * np.exp(b / cos_theta)) * (1 + c * (np.exp(d * gamma) - math.exp(d * math.pi / 2)) + e * np.cos(gamma) ** 2)


def preetham_chromaticity(zenith, coefficients, cos_theta, gamma):
    t, s = TURBIDITY, math.pi / 2 - SUN_ELEVATION
    at_zenith = np.array([t * t, t, 1]) @ np.array(zenith) @ np.array([s**3, s**2, s, 1])
    a, b, c, d, e = (m * t + n for m, n in coefficients)

    def f(cosine, angle):  # the paper's, whose indicatrix has no constant part
        return (1 + a * np.exp(b / cosine)) * (1 + c * np.exp(d * angle) + e * np.cos(angle) ** 2)

    return at_zenith * f(cos_theta, gamma) / f(1.0, s)


def sky(n=256):
    """An equal-area octahedral picture as pbrt-v4 has it, [Clarberg 2008], +z up, in 1000 cd/m2."""
    u, v = np.meshgrid((np.arange(n) + 0.5) / n * 2 - 1, (np.arange(n) + 0.5) / n * 2 - 1)
    inside = 1 - np.abs(u) - np.abs(v)
    r = 1 - np.abs(inside)
    phi = ((np.abs(v) - np.abs(u)) / r + 1) * (math.pi / 4)
    rho = r * np.sqrt(2 - r * r)
    w = np.stack([np.copysign(np.cos(phi), u) * rho, np.copysign(np.sin(phi), v) * rho, np.copysign(1 - r * r, inside)], 2)

    # What is below the horizon is not sky: the luminance of the horizon above it, dimmed to the ground's.
    cos_theta = np.maximum(w[..., 2], 0.01)
    level = w / np.linalg.norm(w, axis=2, keepdims=True)
    gamma = np.arccos((level @ SUN).clip(-1, 1))
    luminance = perez(-1, -0.32, 10, -3, 0.45, cos_theta, gamma)
    above = w[..., 2] > 0
    lux = (luminance * w[..., 2] * above).sum() * 4 * math.pi / n**2
    luminance *= SKY_LX / lux / 1000
    x = preetham_chromaticity(
        [[0.00166, -0.00375, 0.00209, 0], [-0.02903, 0.06377, -0.03202, 0.00394], [0.11693, -0.21196, 0.06052, 0.25886]],
        [(-0.0193, -0.2592), (-0.0665, 0.0008), (-0.0004, 0.2125), (-0.0641, -0.8989), (-0.0033, 0.0452)],
        cos_theta,
        gamma,
    )
    y = preetham_chromaticity(
        [[0.00275, -0.0061, 0.00317, 0], [-0.04214, 0.0897, -0.04153, 0.00516], [0.15346, -0.26756, 0.0667, 0.26688]],
        [(-0.0167, -0.2608), (-0.0950, 0.0092), (-0.0079, 0.2102), (-0.0441, -1.6537), (-0.0109, 0.0529)],
        cos_theta,
        gamma,
    )
    rgb = linear_rgb(x, y) * luminance[..., None]
    ground = (SUN_LX * SUN[2] + SKY_LX) / math.pi / 1000 * np.array(SURFACES["hill"])
    return np.where(above[..., None], np.maximum(rgb, 0), ground)


def linear_rgb(x, y):
    """Rec. 709 of luminance 1."""
    xyz = np.stack([x / y, np.ones_like(x), (1 - x - y) / y], -1)
    rgb_from_xyz = np.array(
        [[3.2409699, -1.5373832, -0.4986108], [-0.9692436, 1.8759675, 0.0415551], [0.0556301, -0.2039770, 1.0569715]]
    )
    return xyz @ rgb_from_xyz.T


LATTICE = np.array([[random.Random(97 * i + j).random() for j in range(64)] for i in range(64)])


def noise(x, y):
    """Between 0 and 1, smooth, its lattice 1 apart and repeated after 64."""
    i, j = np.floor(x).astype(int), np.floor(y).astype(int)
    s, t = x - i, y - j
    s, t = s * s * (3 - 2 * s), t * t * (3 - 2 * t)

    def at(a, b):
        return LATTICE[(i + a) % 64, (j + b) % 64]

    return (at(0, 0) * (1 - s) + at(1, 0) * s) * (1 - t) + (at(0, 1) * (1 - s) + at(1, 1) * s) * t


def ground(x, y):
    """Height: level about the stones, rolling beyond, hills towards the horizon."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    far = np.hypot(x, y)
    rolling = 3.6 * noise(x / 26 + 7.3, y / 26 + 3.1) + 0.7 * noise(x / 6 + 1.7, y / 6 + 9.2) - 2.1
    hills = 62 * noise(x / 190 + 20.4, y / 190 + 11.7) ** 1.5 + 14 * noise(x / 60 + 5.5, y / 60 + 30.2) - 16
    near = np.minimum(far / 30, 1) ** 2
    distant = ((far - 80) / 260).clip(0, 1)
    return rolling * near + hills * distant + 0.10 * noise(x * 0.9, y * 0.9)


def terrain(model):
    """Rings about the camera, as far apart as they are wide."""
    radii = 0.8 * 1.042 ** np.arange(158)
    angles = np.arange(241) * (2 * math.pi / 240)
    r, a = np.meshgrid(radii, angles, indexing="ij")
    x, y = CAMERA[0] + r * np.cos(a), CAMERA[1] + r * np.sin(a)
    points = np.stack([x, y, ground(x, y)], 2)
    split = 112
    model.grid("meadow", points[: split + 1])
    model.grid("hill", points[split:])
    ring = points[0, :-1]
    model.add("meadow", np.concatenate([[ring.mean(axis=0)], ring]), [(0, 1 + i, 1 + (i + 1) % 240) for i in range(240)])


def rough_stone(model, at, size, turn, lean, seed):
    """A block with bent, uneven sides: the grid of a box's faces, moved by noise that its edges share."""
    rng = random.Random(seed)
    shift = 50 * rng.random()
    n = 9
    with model.placed(at, turn, lean):
        for axis in range(3):
            for side in (-1, 1):
                p = np.empty((n, n, 3))
                s = np.linspace(-1, 1, n)
                p[..., axis] = side
                p[..., (axis + 1) % 3], p[..., (axis + 2) % 3] = np.meshgrid(s * side, s)
                # Rounded, then dented.
                p *= (0.86 + 0.14 / np.linalg.norm(p, axis=2, keepdims=True)) * (1 - 0.12 * (np.abs(p[..., 2:]) - 0.4).clip(0) ** 2)
                q = p * np.array(size) / 2
                bump = noise(q[..., 0] * 1.6 + shift, q[..., 1] * 1.6 + q[..., 2] * 1.1) - 0.5
                fine = noise(q[..., 2] * 5 + shift, q[..., 0] * 5 + q[..., 1] * 4) - 0.5
                q = q * (1 + 0.3 * bump + 0.1 * fine)[..., None]
                model.grid("stone", q + (0, 0, size[2] * 0.42))


def stones(model):
    """A ring of eleven, some with lintels, one fallen."""
    radius, count = 7.2, 11
    places = []
    for i in range(count):
        a = 2 * math.pi * i / count + 0.31
        places.append((0.8 + radius * math.cos(a), 8 + radius * math.sin(a), math.degrees(a) + 90))
    for i, (x, y, turn) in enumerate(places):
        z = float(ground(x, y)) - 0.25
        if i == 8:
            rough_stone(model, (x + 0.6, y - 0.5, z + 0.6), (1.3, 0.8, 3.2), turn + 25, 88, i)
            continue
        tall = 3.3 + 0.35 * math.sin(5.0 * i)
        rough_stone(model, (x, y, z), (1.35, 0.75, tall), turn, 2.5 * math.sin(3.0 * i), i)
    for i in (1, 2, 4):
        (x, y, _), (u, v, _) = places[i], places[i + 1]
        middle, turn = ((x + u) / 2, (y + v) / 2), math.degrees(math.atan2(v - y, u - x))
        rough_stone(model, (*middle, float(ground(*middle)) + 3.1), (4.9, 0.85, 0.7), turn, 0, 40 + i)


def cottage(model, x, y, turn):
    z = float(ground(x, y)) - 0.3
    with model.placed((x, y, z), turn):
        length, width, eaves, ridge = 9.5, 5.6, 2.9, 5.6
        model.box("plaster", (-length / 2, -width / 2, 0), (length / 2, width / 2, eaves))
        for side in (-1, 1):
            u = side * length / 2
            gable = [(u, -width / 2, eaves), (u, width / 2, eaves), (u, 0, ridge)]
            model.add("plaster", gable if side > 0 else gable[::-1], [(0, 1, 2)])
            for lift, surface in ((0.0, "timber"), (0.14, "roof")):
                w, low = width / 2 + 0.45, eaves - 0.45 * (ridge - eaves) / (width / 2)
                a = [(-length / 2 - 0.35, side * w, low + lift), (length / 2 + 0.35, side * w, low + lift)]
                b = [(length / 2 + 0.35, 0, ridge + lift), (-length / 2 - 0.35, 0, ridge + lift)]
                model.quad(surface, *(a + b if side < 0 else (a + b)[::-1]))
        for row in range(14):  # courses of tiles
            for side in (-1, 1):
                t = row / 14
                v, h = side * (width / 2 + 0.45) * (1 - t), eaves - 0.43 + (ridge - eaves + 0.43) * t + 0.16
                model.box("roof", (-length / 2 - 0.35, min(v, v - side * 0.06), h), (length / 2 + 0.35, max(v, v - side * 0.06), h + 0.05))
        model.box("stone", (2.6, -0.45, 4.4), (3.5, 0.45, 6.7))
        model.box("roof", (2.75, -0.2, 6.7), (3.35, 0.2, 6.95))
        for u in (-3.2, 1.1, 3.2):
            model.box("timber", (u - 0.55, -width / 2 - 0.06, 1.0), (u + 0.55, -width / 2, 2.2))
            for k in (-0.25, 0.25):
                for m in (1.32, 1.86):
                    model.box("pane", (u + k - 0.2, -width / 2 - 0.065, m - 0.22), (u + k + 0.2, -width / 2 - 0.06, m + 0.22))
        model.box("timber", (-1.5, -width / 2 - 0.08, 0.2), (-0.5, -width / 2, 2.3))
        for u in (-length / 2 - 0.06,):
            model.box("timber", (u, -0.6, 1.2), (u + 0.06, 0.6, 2.2))


def tree(model, x, y, tall, leaves, seed):
    rng = random.Random(seed)
    z = float(ground(x, y)) - 0.2
    crown = []
    with model.placed((x, y, z)):
        model.rod("bark", (0, 0, 0), (0.1, 0, 0.5 * tall), 0.035 * tall, 10, 0.02 * tall)
        for i in range(9):
            turn, up = 2.4 * i + rng.random(), 0.38 + 0.42 * i / 9
            reach = tall * (0.3 - 0.16 * i / 9) * (0.8 + 0.4 * rng.random())
            tip = (reach * math.cos(turn), reach * math.sin(turn), tall * (up + 0.14))
            model.rod("bark", (0.05, 0, tall * (up - 0.05) * 0.9), tip, 0.012 * tall, 6, 0.004 * tall)
            crown.append((tip, tall * (0.13 + 0.07 * rng.random())))
        crown.append(((0, 0, tall * 0.86), tall * 0.16))
        triangles = {"leaf": [], "leaf_light": []}
        for _ in range(leaves):
            centre, radius = crown[int(rng.random() * len(crown))]
            h, a, r = 2 * rng.random() - 1, 2 * math.pi * rng.random(), radius * rng.random() ** 0.35
            s = math.sqrt(1 - h * h)
            at = np.array(centre) + r * np.array([s * math.cos(a), s * math.sin(a), 0.85 * h])
            e, f = np.array([[rng.random() - 0.5 for _ in range(3)] for _ in range(2)]) * 0.12 * tall**0.75
            triangles["leaf" if rng.random() < 0.6 else "leaf_light"] += [at, at + e, at + f]
        for surface, vertices in triangles.items():
            model.add(surface, vertices, np.arange(len(vertices)))


def wall_of_stones(model):
    rng = random.Random(11)
    for i in range(130):
        t = i / 130
        x, y = -34 + 27 * t, 12 + 22 * t + 2.2 * math.sin(5 * t)
        for layer in range(4):
            jitter = [rng.random() for _ in range(4)]
            with model.placed((x + 0.1 * jitter[0], y + 0.1 * jitter[1], float(ground(x, y)) - 0.1 + 0.26 * layer), 38 + 24 * jitter[2]):
                w = 0.2 + 0.1 * jitter[3]
                model.box("stone", (-w, -0.22 + 0.03 * layer, 0), (w, 0.22 - 0.03 * layer, 0.25))


def grass(model):
    """Blades before the camera, thinning out, and flowers."""
    rng = random.Random(5)
    triangles = {name: [] for name in ("grass", "dry_grass", "flower", "daisy")}
    for _ in range(24000):
        r, a = 2.2 + 30 * rng.random() ** 1.6, math.radians(90 + 76 * (rng.random() - 0.5))
        x, y = CAMERA[0] + r * math.cos(a), CAMERA[1] + r * math.sin(a)
        # In patches.
        if rng.random() > 0.25 + 1.1 * float(noise(x * 0.45 + 3, y * 0.45 + 8)):
            continue
        z, tall, turn = float(ground(x, y)) - 0.02, 0.12 + 0.26 * rng.random() ** 2, 2 * math.pi * rng.random()
        bend, wide = 0.12 * (rng.random() - 0.2), 0.006 + 0.0011 * r
        c, s = math.cos(turn) * wide, math.sin(turn) * wide
        kind = "dry_grass" if rng.random() < 0.16 else "grass"
        triangles[kind] += [(x - c, y - s, z), (x + c, y + s, z), (x + bend, y - bend * 0.6, z + tall)]
        if rng.random() < 0.045:
            name, size = ("flower", 0.028) if rng.random() < 0.4 else ("daisy", 0.022)
            size += 0.0012 * r
            p = [(x + size * math.cos(2.1 * k + turn), y + size * math.sin(2.1 * k + turn), z + 0.28 + 0.4 * size * (k % 2)) for k in range(3)]
            triangles[name] += p
    for surface, vertices in triangles.items():
        model.add(surface, vertices, np.arange(len(vertices)))


def leaf_picture():
    """White where a triangle is leaf.  The corners of the triangles have (u, v) = (0, 0), (1, 0) and (1, 1)."""
    side, rng = 128, random.Random(2)
    centres = (np.arange(side) + 0.5) / side
    u, v = np.meshgrid(centres, centres[::-1])
    white = np.zeros((side, side), bool)
    for _ in range(22):
        a, b = sorted((0.08 + 0.84 * rng.random(), 0.08 + 0.84 * rng.random()))
        turn, long = 2 * math.pi * rng.random(), 0.13 + 0.05 * rng.random()
        along = ((u - b) * math.cos(turn) + (v - a) * math.sin(turn)) / long
        across = ((v - a) * math.cos(turn) - (u - b) * math.sin(turn)) / (0.45 * long)
        white |= np.abs(across) < 1 - along**2
    return modelling.png(np.where(white, 255, 0))


def make():
    model = modelling.Model(SURFACES, {"leaf": "leaf.png", "leaf_light": "leaf.png"})
    terrain(model)
    stones(model)
    cottage(model, 17.5, 40, 24)
    wall_of_stones(model)
    for i, (x, y, tall, leaves) in enumerate(((-17, 25, 11, 3400), (27.5, 34, 9, 2200), (8.5, 56, 10, 1800), (-36, 70, 12, 1500), (-26, 58, 9, 1200), (46, 92, 12, 900), (-3, 88, 9, 900))):
        tree(model, x, y, tall, leaves, 60 + i)
    grass(model)
    files = model.files()
    files["leaf.png"] = leaf_picture()
    files["sky.hdr"] = modelling.hdr(sky())
    # CIE 1931 x, y of a black body of 4300 K.
    colour = linear_rgb(np.array(0.3681), np.array(0.3685))
    files["sun.pbrt"] = (
        "# Made by make.py.  As wide as the sun, 0.53 degrees.\n"
        f'LightSource "distant" "rgb L" [{modelling.numbers(colour * SUN_LX, 1)}] "float angulardiameter" [0.53]\n'
        f'  "point3 from" [{modelling.numbers(SUN * 100)}] "point3 to" [0 0 0]\n'
    ).encode()
    # A metre over the ground, level, as a meter on its tripod.
    grid = [(-28 + 56 * i / 23, -14 + 56 * j / 23) for i in range(24) for j in range(24)]
    files["points.csv"] = modelling.csv((x, y, float(ground(x, y)) + 1, 0, 0, 1) for x, y in grid if not in_stone_or_house(x, y))
    return files


def in_stone_or_house(x, y):
    near_ring = abs(math.hypot(x - 0.8, y - 8) - 7.2) < 1.1
    return near_ring or math.hypot(x - 17.5, y - 40) < 6


if __name__ == "__main__":
    modelling.main(__file__, make)
