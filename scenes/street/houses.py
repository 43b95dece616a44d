"""The houses of the street, with shops below and windows above, lit or dark."""
import random

from lamps import COLD, WARM, WHITE

FRONT, LENGTH, FLOOR = 6.2, 78.0, 3.1  # half width of the street between the fronts, its length, a storey


def window(model, lights, side, y, z, width, height, rng):
    """In a facade, with a frame and four panes; lit, or dark."""
    x = side * FRONT
    depth = lambda d: sorted((x, x - side * d))  # from the facade towards the street
    for low, high in (((y - 0.08, z - 0.1), (y + width + 0.08, z)), ((y - 0.08, z + height), (y + width + 0.08, z + height + 0.12))):
        a, b = depth(0.14)
        model.box("trim", (a, *low), (b, *high))
    a, b = depth(0.06)
    for v in (y - 0.06, y + width / 2 - 0.03, y + width):
        model.box("frame", (a, v, z), (b, v + 0.06, z + height))
    model.box("frame", (a, y, z + height * 0.62), (b, y + width, z + height * 0.62 + 0.05))
    kind = rng.random()
    colour = WARM if kind < 0.72 else WHITE if kind < 0.9 else COLD
    lit, level = rng.random() < 0.52, 12 + 38 * rng.random() ** 2
    panes = [(y, z, width / 2 - 0.03, height * 0.62), (y + width / 2 + 0.03, z, width / 2 - 0.03, height * 0.62)]
    panes += [(v, z + height * 0.62 + 0.05, w, height * 0.38 - 0.05) for v, _, w, _ in panes]
    for v, u, w, h in panes:
        if lit:
            # A curtain or the wall behind makes some darker.
            pane = round(level * (0.55 + 0.45 * rng.random()))
            face = x - side * 0.02
            if side > 0:  # towards -x
                lights.rectangle(pane, colour, (face, v + w, u), (0, -w, 0), (0, 0, h))
            else:
                lights.rectangle(pane, colour, (face, v, u), (0, w, 0), (0, 0, h))
        else:
            c, d = depth(0.02)
            model.box("glass", (c, v, u), (d, v + w, u + h))


def shop(model, lights, side, y, width, rng):
    """A lit room of 2.2 m behind a pane of glass, with spots, shelves and goods; an awning and a sign."""
    inner, back, low, high = side * FRONT, side * (FRONT + 2.2), 0.45, 2.75
    facing = lambda x0, x1: sorted((x0, x1))
    a, b = facing(inner, back)
    model.box("shop", (a, y, low - 0.05), (b, y + width, low))
    model.box("shop", (a, y, high), (b, y + width, high + 0.05))
    x = inner - side * 0.01
    model.quad("shop_window", (x, y, low), (x, y + width, low), (x, y + width, high), (x, y, high))
    c, d = facing(back, back + side * 0.05)
    model.box("shop", (c, y, low), (d, y + width, high))
    model.box("shop", (a, y - 0.05, low), (b, y, high))
    model.box("shop", (a, y + width, low), (b, y + width + 0.05, high))
    for i in range(2):
        z = 1.15 + 0.6 * i
        e, f = facing(back, back - side * 0.35)
        model.box("wood", (e, y + 0.1, z), (f, y + width - 0.1, z + 0.03))
    surfaces = ("goods_a", "goods_b", "goods_c", "shop", "wood")
    for i in range(int(width / 0.28)):
        for z in (low, 1.18, 1.78):
            if rng.random() < 0.75:
                h, w = 0.14 + 0.3 * rng.random(), 0.07 + 0.05 * rng.random()
                at = (back - side * (0.18 if z > low else 0.5 + 1.2 * rng.random()), y + 0.25 + 0.28 * i, z)
                if at[1] + w > y + width - 0.05:
                    continue
                surface = surfaces[int(rng.random() * 5)]
                if rng.random() < 0.5:
                    model.lathe(surface, [(0, 0), (w, 0), (w * 1.1, h * 0.5), (w * 0.4, h), (0, h)], 12, at)
                else:
                    model.box(surface, (at[0] - w, at[1] - w, z), (at[0] + w, at[1] + w, z + h))
    colour = (WARM, WHITE, WHITE, COLD)[int(rng.random() * 4)]
    for i in range(5):
        v = y + width * (i + 0.5) / 5
        lights.spot(60, colour, (inner + side * 0.35, v, high - 0.04), (back - side * 0.5, v, low + 0.2), 38, 16)
    if side > 0:
        lights.rectangle(220, colour, (inner + side * 1.2, y + width - 0.3, high - 0.02), (0, 0.6 - width, 0), (-0.1, 0, 0))
    else:
        lights.rectangle(220, colour, (inner + side * 1.2, y + 0.3, high - 0.02), (0, width - 0.6, 0), (0.1, 0, 0))
    awning = ("awning_a", "awning_b", "goods_c")[int(rng.random() * 3)]
    stripes = int(width / 0.4)
    for i in range(stripes):
        v, w = y + width * i / stripes, y + width * (i + 1) / stripes
        out = inner - side * 1.05
        model.quad(awning if i % 2 else "awning_c", (inner, v, 3.0), (inner, w, 3.0), (out, w, 2.62), (out, v, 2.62))
        model.quad(awning if i % 2 else "awning_c", (out, v, 2.62), (out, w, 2.62), (out, w, 2.42), (out, v, 2.42))


def house(model, lights, side, y, width, storeys, surface, rng):
    height, inner = FLOOR * storeys + 0.35, side * FRONT
    a, b = sorted((inner, inner + side * 7))
    deep = inner + side * 2.3
    # Below the first floor stands only what leaves the shop its room.
    opening = (y + 0.5, y + width - 1.5)
    model.box(surface, (a, y, FLOOR - 0.3), (b, y + width, height))
    for low, high in ((y, opening[0] - 0.05), (opening[1] + 0.05, y + width)):
        model.box(surface, (a, low, 0), (b, high, FLOOR - 0.3))
    c, d = sorted((inner, deep))
    model.box("wood", (c, opening[0] - 0.05, 0), (d, opening[1] + 0.05, 0.4))
    e, f = sorted((inner - side * 0.18, inner))
    for z in (FLOOR, height - 0.25):
        model.box("trim", (e, y, z), (f, y + width, z + 0.2))
    shop(model, lights, side, opening[0], opening[1] - opening[0], rng)
    e, f = sorted((inner - side * 0.04, inner))  # the door
    model.box("wood", (e, y + width - 1.25, 0.12), (f, y + width - 0.35, 2.35))
    lights.bulb(300, WARM, (inner - side * 0.2, y + width - 0.8, 2.62), 0.07)
    count = max(2, int(width / 2.1))
    for storey in range(1, storeys):
        for i in range(count):
            v = y + width * (i + 0.5) / count - 0.5
            window(model, lights, side, v, FLOOR * storey + 0.95, 1.0, 1.55, rng)
    ridge = height + 1.2 + 1.2 * rng.random()
    roof = [(a - 0.1, y), (b + 0.1, y)]
    mid = (a + b) / 2
    for u in roof:
        v, w = y, y + width
        model.quad("roof", (u[0], v, height), (u[0], w, height), (mid, w, ridge), (mid, v, ridge))
    for v in (y, y + width):
        model.add(surface, [(a, v, height), (b, v, height), (mid, v, ridge)], [(0, 1, 2)])
    model.box("facade_e", (mid - 0.3, y + 0.8, height), (mid + 0.3, y + 1.4, ridge + 0.9))


def houses(model, lights):
    rng = random.Random(7)
    for side in (-1, 1):
        y, last = -9.0, -1
        while y < LENGTH:
            kind = int(rng.random() * 6)
            kind = (kind + 1) % 6 if kind == last else kind
            last, width, storeys = kind, 5.4 + 2.6 * rng.random(), 3 + int(rng.random() * 2)
            house(model, lights, side, y, width, storeys, "facade_" + "abcdef"[kind], rng)
            y += width
