"""The lights of the street, as text of a scene."""
import math

import modelling

WARM, WHITE, COLD = (1.33, 0.94, 0.55), (1.12, 0.98, 0.84), (0.85, 1.0, 1.4)  # of luminance about 1


class Lights:
    """The text of lights.pbrt.  Lights of one level stand together: a level is said once."""

    def __init__(self):
        self.groups, self.single = {}, []

    def area(self, level, colour, shape):
        """`level`: luminance [cd/m2] by which the colour is multiplied."""
        key = modelling.numbers((level * c for c in colour), 100)
        self.groups.setdefault(key, []).append(shape)

    def rectangle(self, level, colour, corner, across, up):
        """Shines to the side of across x up."""
        a, u, v = (modelling.np.array(p, float) for p in (corner, across, up))
        points = modelling.numbers([c for p in (a, a + u, a + v, a + u + v) for c in p], 1000)
        self.area(level, colour, f'  Shape "bilinearmesh" "point3 P" [{points}]\n')

    def triangle(self, level, colour, a, b, c):
        points = modelling.numbers([*a, *b, *c], 1000)
        self.area(level, colour, f'  Shape "trianglemesh" "point3 P" [{points}] "integer indices" [0 1 2]\n')

    def bulb(self, lumens, colour, at, radius):
        """A sphere."""
        level = lumens / (math.pi * 4 * math.pi * radius**2)
        self.area(level, colour, f'  AttributeBegin Translate {modelling.numbers(at, 1000)} Shape "sphere" "float radius" [{radius:g}] AttributeEnd\n')

    def tube(self, level, colour, a, b, radius=0.012):
        """A cylinder upright or along y, the ways that neon is bent here."""
        turn = "" if abs(b[2] - a[2]) > abs(b[1] - a[1]) else " Rotate -90 1 0 0"
        long = max(abs(b[2] - a[2]), abs(b[1] - a[1]))
        low = a if a[1] + a[2] < b[1] + b[2] else b
        shape = f'"float radius" [{radius:g}] "float zmin" [0] "float zmax" [{modelling.number(long, 1000)}]'
        self.area(level, colour, f'  AttributeBegin Translate {modelling.numbers(low, 1000)}{turn} Shape "cylinder" {shape} AttributeEnd\n')

    def point(self, candela, colour, at):
        level = modelling.numbers((candela * c for c in colour), 10000)
        self.single.append(f'LightSource "point" "rgb I" [{level}] "point3 from" [{modelling.numbers(at, 1000)}]\n')

    def spot(self, candela, colour, at, to, cone, edge):
        level = modelling.numbers((candela * c for c in colour), 100)
        places = f'"point3 from" [{modelling.numbers(at, 1000)}] "point3 to" [{modelling.numbers(to, 1000)}]'
        self.single.append(f'LightSource "spot" "rgb I" [{level}] {places} "float coneangle" [{cone}] "float conedeltaangle" [{edge}]\n')

    def lantern(self, at, turn):
        self.single.append(
            f"AttributeBegin\n  Translate {modelling.numbers(at, 1000)}\n  Rotate {turn} 0 0 1\n  Rotate 180 1 0 0\n"
            '  LightSource "goniometric" "string filename" "lantern.ies" "rgb I" [1.3 0.95 0.58]\nAttributeEnd\n'
        )

    def text(self):
        parts = ["# Made by make.py.\n", *self.single]
        for level, shapes in self.groups.items():
            parts.append(f'AttributeBegin\n  AreaLightSource "diffuse" "rgb L" [{level}]\n{"".join(shapes)}AttributeEnd\n')
        return "".join(parts).encode()
