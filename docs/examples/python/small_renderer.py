#!/usr/bin/python3
"""A small renderer with mistakes that can be switched on.  It makes files for `lucerna verify`.

    small_renderer.py DIR [--seed N] [--rows N] [--receivers N] [--mistake NAME] [--list]

Writes DIR/scene.pbrt with its pictures, and samples.csv, densities.csv, emission.csv, power.csv, irradiance.csv and
visibility.csv.  It shares no code with Lucerna: its formulas come from textbooks.  Without --mistake, all numbers are
right.  Needs NumPy.
"""
import argparse
import csv
import math
import pathlib
import struct
import zlib

import numpy as np

LUMINANCE = np.array([0.2126390058715104, 0.7151686787677559, 0.0721923153607337])

# What each mistake is, and what `lucerna verify` must find: the light, the quantity, and the word for the mistake.
MISTAKES = {
    "pi": ("radiant exitance for radiance", "panel", "value", "factor_pi"),
    "2pi": ("a density without 2 pi", "sun", "density", "factor_2pi"),
    "4pi": ("intensity for power", "bulb", "power", "factor_4pi"),
    "683": ("watts for lumens", "disk", "power", "factor_683"),
    "cosine": ("a cosine at the receiver in the value", "panel", "value", "cosine_receiver"),
    "cosine_irradiance": ("illuminance without the cosine", "bulb", "illuminance", "cosine_receiver"),
    "cosine_light": ("a density without the cosine at the light", "disk", "density", "cosine_light"),
    "inverse_square": ("no division by r2", "spot", "value", "inverse_square"),
    "inverse_square_irradiance": ("illuminance without r2", "spot", "illuminance", "inverse_square"),
    "area_measure": ("a density per area", "panel", "density", "measure_area"),
    "area_measure_given": ("given densities per area", "panel", "given density", "measure_area"),
    "geometric_normal": ("the geometric normal for the shading normal", "bulb", "illuminance", "shading_normal"),
    "light_normal": ("the shading normal of the light in a density", "wedge", "density", "shading_normal"),
    "two_sides": ("two sides for one", "panel", "value", "two_sides"),
    "two_sides_power": ("the power of two sides for one", "panel", "power", "two_sides"),
    "one_side": ("one side for two", "pane", "value", "one_side"),
    "radius": ("a diameter for a radius", "ball", "value", "radius_diameter"),
    "radius_power": ("a diameter for a radius in the power", "ball", "power", "radius_diameter"),
    "radius_density": ("a density for a diameter", "ball", "given density", "radius_diameter"),
    "half_angle": ("half the angle of the cone", "spot", "value", "half_full_angle"),
    "full_angle": ("twice the angle of the sun", "sun", "value", "half_full_angle"),
    "degrees": ("degrees for radians", "spot", "value", "degrees"),
    "srgb": ("texels that are not linearised", "map", "value", "srgb"),
    "srgb_colour": ("a colour that is not linearised", "bulb", "value", "srgb"),
    "mirrored": ("a mirrored map", "map", "value", "map_mirrored"),
    "rotated": ("a map that is rotated by 90 degrees", "map", "value", "map_rotated"),
    "rotated_37": ("a map that is rotated by 37 degrees", "gonio", "value", "map_rotated"),
    "mirrored_slide": ("a mirrored slide", "slide", "value", "map_mirrored"),
    "mirrored_screen": ("a mirrored picture on a surface", "screen", "value", "map_mirrored"),
    "selection": ("the probability of choosing the light is 1", "panel", "selection", "selection"),
    "selection_density": ("the probability of choosing the light in the density", "panel", "density", "selection"),
    "selection_irradiance": ("no division by the probability", "panel", "illuminance", "selection"),
    "no_occlusion": ("nothing blocks rays", "all", "visibility", "no_occlusion"),
    "directions": ("directions by area for densities by solid angle", "panel", "directions", "other_density"),
    "triangle": ("a triangle that is not sampled uniformly", "wedge", "directions", ""),
    "emission_cosine": ("a cosine in the emitted radiance", "disk", "emission", "cosine_light"),
    "distance": ("distances in centimetres", "bulb", "distance", "factor_100"),
}


def unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def dots(a, b):
    return np.sum(a * b, axis=-1)


def frame(w):
    """Two unit vectors at right angles to each `w`."""
    other = np.where(np.abs(w[..., :1]) < 0.7, np.array([1.0, 0, 0]), np.array([0, 1.0, 0]))
    a = unit(np.cross(w, other))
    return a, np.cross(w, a)


def about(w, cos_theta, phi):
    """The directions at these angles from `w`."""
    a, b = frame(w)
    s = np.sqrt(np.maximum(0, 1 - cos_theta**2))[..., None]
    return s * np.cos(phi)[..., None] * a + s * np.sin(phi)[..., None] * b + cos_theta[..., None] * w


def decode(x):
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


def write_png(path, texels):
    """Eight bits for each channel of an array (height, width, 3)."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    height, width, _ = texels.shape
    rows = b"".join(b"\0" + row.tobytes() for row in texels)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
                     + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


# The surfaces.  Each has: sample(u) -> points, normals; area; meets(x, d) -> distances along d, inf without a hit.
class Parallelogram:
    def __init__(self, corner, u, v, triangle=False, uneven=False):
        self.corner, self.u, self.v = (np.array(a, float) for a in (corner, u, v))
        cross = np.cross(self.u, self.v)
        self.n = cross / np.linalg.norm(cross)
        self.triangle, self.uneven = triangle, uneven
        self.area = np.linalg.norm(cross) / (2 if triangle else 1)

    def sample(self, u):
        if self.triangle:
            root = u[:, 0] if self.uneven else np.sqrt(u[:, 0])
            a, b = 1 - root, u[:, 1] * root
        else:
            a, b = u[:, 0], u[:, 1]
        return self.corner + a[:, None] * self.u + b[:, None] * self.v, np.broadcast_to(self.n, (len(u), 3))

    def solid_angle(self, x):
        """Of the parallelogram, as two triangles: tan(angle / 2) = |abc| / (1 + ab + bc + ca)."""
        corners = [unit(self.corner + k * self.u + m * self.v - x) for k, m in ((0, 0), (1, 0), (1, 1), (0, 1))]
        total = 0
        for a, b, c in (corners[:3], (corners[0], *corners[2:])):
            over = np.abs(dots(a, np.cross(b, c)))
            total = total + 2 * np.arctan2(over, 1 + dots(a, b) + dots(b, c) + dots(c, a))
        return total

    def uv(self, p):
        uu, uv, vv = self.u @ self.u, self.u @ self.v, self.v @ self.v
        a, b = (p - self.corner) @ self.u, (p - self.corner) @ self.v
        det = uu * vv - uv * uv
        return (a * vv - b * uv) / det, (b * uu - a * uv) / det

    def meets(self, x, d):
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (self.corner - x) @ self.n / (d @ self.n)
            a, b = self.uv(x + t[:, None] * d)
        inside = (a >= 0) & (b >= 0) & ((a + b <= 1) if self.triangle else ((a <= 1) & (b <= 1)))
        return np.where(inside & (t > 1e-6), t, np.inf)


class Disk:
    """Faces down."""

    def __init__(self, center, radius):
        self.center, self.radius = np.array(center, float), radius
        self.n, self.area = np.array([0, 0, -1.0]), math.pi * radius**2

    def sample(self, u):
        r, phi = self.radius * np.sqrt(u[:, 0]), 2 * math.pi * u[:, 1]
        p = self.center + np.stack([r * np.cos(phi), r * np.sin(phi), 0 * r], axis=1)
        return p, np.broadcast_to(self.n, p.shape)

    def meets(self, x, d):
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (self.center[2] - x[:, 2]) / d[:, 2]
            inside = np.linalg.norm(x + t[:, None] * d - self.center, axis=1) <= self.radius
        return np.where(inside & (t > 1e-6), t, np.inf)


class Ball:
    def __init__(self, center, radius):
        self.center, self.radius, self.area = np.array(center, float), radius, 4 * math.pi * radius**2

    def sample(self, u):
        z, phi = 1 - 2 * u[:, 0], 2 * math.pi * u[:, 1]
        s = np.sqrt(np.maximum(0, 1 - z * z))
        n = np.stack([s * np.cos(phi), s * np.sin(phi), z], axis=1)
        return self.center + self.radius * n, n

    def meets(self, x, d):
        o = self.center - x
        along = dots(o, d)
        square = self.radius**2 - (dots(o, o) - along**2)
        root = np.sqrt(np.maximum(0, square))
        t = np.where(along - root > 1e-6, along - root, along + root)
        return np.where((square >= 0) & (t > 1e-6), t, np.inf)


class Tube:
    """An open cylinder along x."""

    def __init__(self, center, radius, half):
        self.center, self.radius, self.half = np.array(center, float), radius, half
        self.area = 2 * math.pi * radius * 2 * half

    def sample(self, u):
        phi = 2 * math.pi * u[:, 1]
        n = np.stack([0 * phi, np.cos(phi), np.sin(phi)], axis=1)
        p = self.center + self.radius * n
        p[:, 0] += self.half * (2 * u[:, 0] - 1)
        return p, n

    def meets(self, x, d):
        o, k = (x - self.center)[:, 1:], d[:, 1:]
        a, b, c = dots(k, k), dots(o, k), dots(o, o) - self.radius**2
        square = b * b - a * c
        best = np.full(len(x), np.inf)
        with np.errstate(divide="ignore", invalid="ignore"):
            for sign in (1, -1):
                t = (-b + sign * np.sqrt(np.maximum(0, square))) / a
                at = np.abs((x + t[:, None] * d - self.center)[:, 0]) <= self.half
                best = np.where((square >= 0) & at & (t > 1e-6), np.minimum(best, t), best)
        return best


class Light:
    """A light by its name.  `li` samples it: directions, densities (None: delta), distances, RGB values, normals."""
    delta = False
    infinite = False

    def rgb(self, level):
        return np.array([level] * 3 if np.isscalar(level) else level, float)


class AtPoint(Light):
    delta = True

    def __init__(self, position, intensity):
        self.position, self.intensity = np.array(position, float), intensity

    def li(self, x, rng):
        to = self.position - x
        d = np.linalg.norm(to, axis=1)
        w = to / d[:, None]
        return w, None, d, self.intensity(-w) / d[:, None] ** 2, None


class FromFar(Light):
    delta, infinite = True, True

    def __init__(self, to_light, level):
        self.to_light, self.level = unit(np.array(to_light, float)), self.rgb(level)

    def li(self, x, rng):
        n = len(x)
        return np.tile(self.to_light, (n, 1)), None, np.full(n, np.inf), np.tile(self.level, (n, 1)), None


class Sun(Light):
    infinite = True

    def __init__(self, to_light, illuminance, diameter_deg):
        self.to_light = unit(np.array(to_light, float))
        self.cos = math.cos(math.radians(diameter_deg / 2))
        # The illuminance on a surface that faces the centre is pi L sin^2.
        self.radiance = self.rgb(illuminance) / (math.pi * (1 - self.cos**2))

    def li(self, x, rng):
        u = rng.random((len(x), 2))
        w = about(np.tile(self.to_light, (len(x), 1)), 1 - u[:, 0] * (1 - self.cos), 2 * math.pi * u[:, 1])
        pdf = np.full(len(x), 1 / (2 * math.pi * (1 - self.cos)))
        return w, pdf, np.full(len(x), np.inf), np.tile(self.radiance, (len(x), 1)), None


class Sky(Light):
    """Radiance from all directions, which are sampled uniformly."""
    infinite = True

    def __init__(self, radiance):
        self.radiance = radiance

    def li(self, x, rng):
        u = rng.random((len(x), 2))
        w = about(np.tile([0, 0, 1.0], (len(x), 1)), 1 - 2 * u[:, 0], 2 * math.pi * u[:, 1])
        return w, np.full(len(x), 1 / (4 * math.pi)), np.full(len(x), np.inf), self.radiance(w), None


class Area(Light):
    """A surface, sampled uniformly by area."""

    def __init__(self, shape, level, sides=1, texture=None):
        self.shape, self.level, self.sides, self.texture = shape, self.rgb(level), sides, texture

    def shines(self, n, w):
        return dots(n, w) > 0 if self.sides == 1 else np.full(len(w), True)

    def radiance(self, p):
        return self.level * (self.texture(*self.shape.uv(p)) if self.texture else np.ones((len(p), 1)))

    def li(self, x, rng):
        p, n = self.shape.sample(rng.random((len(x), 2)))
        d = np.linalg.norm(p - x, axis=1)
        w = (p - x) / d[:, None]
        pdf = d**2 / (self.shape.area * np.abs(dots(n, w)))
        value = self.radiance(p) * self.shines(n, -w)[:, None]
        return w, pdf, d, value, n

    def power(self):
        return math.pi * self.sides * self.shape.area * (self.level @ LUMINANCE)


class BallLight(Area):
    """Sampled uniformly in the cone in which it is seen."""

    def density(self, x):
        to = self.shape.center - x
        d2 = dots(to, to)
        sin2 = np.minimum(self.shape.radius**2 / d2, 1)
        one_less_cos = sin2 / (1 + np.sqrt(1 - sin2))
        return one_less_cos, 1 / (2 * math.pi * one_less_cos)

    def li(self, x, rng):
        u = rng.random((len(x), 2))
        one_less_cos, pdf = self.density(x)
        axis = unit(self.shape.center - x)
        w = about(axis, 1 - u[:, 0] * one_less_cos, 2 * math.pi * u[:, 1])
        d = self.shape.meets(x, w)
        # The edge of the cone only touches the ball.
        d = np.where(np.isfinite(d), d, np.sqrt(np.maximum(0, dots(self.shape.center - x, self.shape.center - x)
                                                           - self.shape.radius**2)))
        n = unit(x + d[:, None] * w - self.shape.center)
        return w, pdf, d, np.tile(self.level, (len(x), 1)), n


def picture(seed, height, width):
    """Texels of eight bits, sRGB-encoded, without symmetry."""
    rng = np.random.default_rng(seed)
    return rng.integers(30, 255, (height, width, 3), dtype=np.uint8)


def texel(texels, u, v, linear=True):
    height, width, _ = texels.shape
    column = np.clip((u * width).astype(int), 0, width - 1)
    row = np.clip((v * height).astype(int), 0, height - 1)
    values = texels[row, column] / 255
    return decode(values) if linear else values


MAP, GONIO, SLIDE, SCREEN = picture(1, 8, 16), picture(2, 8, 16), picture(3, 8, 8), picture(4, 6, 6)
CANDELA = [(0, 300.0), (30, 250.0), (60, 100.0), (90, 20.0)]  # of the luminaire, from straight down


def latlong(w):
    """Longitude about +y from +x to +z, and the angle from +y, both from 0 to 1."""
    return (np.arctan2(w[..., 2], w[..., 0]) / (2 * math.pi)) % 1, np.arccos(np.clip(w[..., 1], -1, 1)) / math.pi


def mean_over_sphere(of, n=400):
    """The mean over directions, by the midpoint rule."""
    cosine, phi = np.meshgrid((np.arange(n) + 0.5) / n * 2 - 1, (np.arange(2 * n) + 0.5) / n * math.pi, indexing="ij")
    s = np.sqrt(1 - cosine**2)
    w = np.stack([s * np.cos(phi), cosine, s * np.sin(phi)], axis=-1).reshape(-1, 3)
    return of(w).mean(axis=0)


class Renderer:
    def __init__(self, mistake=None):
        self.mistake = mistake
        self.lights = self.make_lights()
        self.names = list(self.lights)
        self.surfaces = [Parallelogram([-4, -4, 0], [8, 0, 0], [0, 8, 0])]
        right = Renderer.__new__(Renderer)
        right.mistake = None
        self.surfaces += [light.shape for light in right.make_lights().values() if hasattr(light, "shape")]

    def has(self, *mistakes):
        return self.mistake in mistakes

    def make_lights(self):
        spot_angle, spot_edge = math.radians(30), math.radians(12)
        if self.has("half_angle"):
            spot_angle, spot_edge = spot_angle / 2, spot_edge / 2
        cos_out, cos_in = math.cos(spot_angle), math.cos(spot_angle - spot_edge)
        if self.has("degrees"):
            cos_out, cos_in = math.cos(30), math.cos(18)
        spot_axis = unit(np.array([-2, 2.5, -3.5]))

        def spot(w):
            x = np.clip((w @ spot_axis - cos_out) / (cos_in - cos_out), 0, 1)
            return 40.0 * (x * x * (3 - 2 * x))[:, None] * np.ones(3)

        def sky_map(w):
            if self.has("mirrored"):
                w = w * np.array([-1, 1, 1])
            if self.has("rotated"):
                w = np.stack([-w[:, 2], w[:, 1], w[:, 0]], axis=1)
            return 2 * texel(MAP, *latlong(w), linear=not self.has("srgb"))

        def gonio(w):
            if self.has("rotated_37"):
                c, s = math.cos(math.radians(37)), math.sin(math.radians(37))
                w = np.stack([c * w[:, 0] - s * w[:, 2], w[:, 1], s * w[:, 0] + c * w[:, 2]], axis=1)
            return 30 * texel(GONIO, *latlong(w)).mean(axis=1)[:, None] * np.ones(3)

        def slide(w):
            # It points down, with +x to its right and -y to its top.
            extent = math.tan(math.radians(20))
            with np.errstate(divide="ignore", invalid="ignore"):
                across, upwards = w[:, 0] / -w[:, 2] / extent, -w[:, 1] / -w[:, 2] / extent
            inside = (w[:, 2] < 0) & (np.abs(across) <= 1) & (np.abs(upwards) <= 1)
            if self.has("mirrored_slide"):
                across = -across
            u, v = np.where(inside, (across + 1) / 2, 0), np.where(inside, (1 - upwards) / 2, 0)
            return 60 * texel(SLIDE, u, v) * inside[:, None]

        def downlight(w):
            angle = np.degrees(np.arccos(np.clip(-w[:, 2], -1, 1)))
            degrees, candela = zip(*CANDELA)
            return np.where(angle <= 90, np.interp(angle, degrees, candela), 0)[:, None] * np.ones(3)

        def screen(u, v):
            return texel(SCREEN, 1 - u if self.has("mirrored_screen") else u, 1 - v)

        bulb = np.array([12, 6, 3.0])
        if self.has("srgb_colour"):
            x = bulb / 12
            bulb = 12 * np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
        return {
            "bulb": AtPoint([1, -1, 3], lambda w: np.tile(bulb, (len(w), 1))),
            "spot": AtPoint([2, -2.5, 3.5], spot),
            "far": FromFar([1, -2, 3], 2),
            "sun": Sun([-1, -2, 3], 3, 20 if self.has("full_angle") else 10),
            "sky": Sky(lambda w: np.full((len(w), 3), 0.5)),
            "map": Sky(sky_map),
            "gonio": AtPoint([-1, 1, 3], gonio),
            "slide": AtPoint([0, 0, 3], slide),
            "downlight": AtPoint([-2.5, 2.5, 3], downlight),
            "panel": Area(Parallelogram([1, 1, 3], [0, 1, 0], [1.5, 0, 0]), 12, 2 if self.has("two_sides") else 1),
            "pane": Area(Parallelogram([-1.5, 1, 2], [0, 1, 0], [0, 0, 0.5]), 5, 1 if self.has("one_side") else 2),
            "ball": BallLight(Ball([0.7, -1.2, 2.6], 0.7 if self.has("radius") else 0.35), 12),
            "disk": Area(Disk([-0.7, -1.2, 2.6], 0.4), 20),
            "tube": Area(Tube([0, -2.6, 2.8], 0.06, 1), 14),
            "wedge": Area(Parallelogram([-2, -1, 3], [1, 0, 0], [0, -1, 0], triangle=True,
                                        uneven=self.has("triangle")), 10),
            "screen": Area(Parallelogram([3, 1, 1], [0, 1, 0], [0, 0, 1]), 3, 2, screen),
        }

    def blocked(self, x, w, t_max):
        """Whether a surface lies on the way, before its end."""
        return np.any([s.meets(x, w) < t_max * (1 - 1e-6) for s in self.surfaces], axis=0)

    def receivers(self, n, rng, high=0.2):
        x = rng.random((n, 3)) * [4, 4, 1] + [-2, -2, 0.2]
        x[:, 2] += np.where(rng.random(n) < high, 2.9, 0)
        normal = unit(rng.normal(size=(n, 3)) * 0.3 + [0, 0, 1])
        return x, normal

    def samples(self, n, rng, receivers):
        """Rows of samples: each chooses a light with equal probabilities."""
        places, normals = self.receivers(receivers, rng)
        at = rng.integers(receivers, size=n)
        chosen = rng.integers(len(self.names), size=n)
        for k, name in enumerate(self.names):
            rows = at[chosen == k]
            x, normal = places[rows], normals[rows]
            light = self.lights[name]
            w, pdf, d, value, n_light = light.li(x, rng)
            selection = 1 / len(self.names)
            cos_light = np.abs(dots(n_light, w)) if n_light is not None else None
            wrong = self.mistake and MISTAKES[self.mistake][1] == name
            shading = n_light
            if wrong and self.has("pi"):
                value = value * math.pi
            if wrong and self.has("2pi"):
                pdf = pdf * 2 * math.pi
            if wrong and self.has("cosine"):
                value = value * np.maximum(0, dots(normal, w))[:, None]
            if wrong and self.has("cosine_light"):
                pdf = pdf * cos_light
            if wrong and self.has("inverse_square"):
                value = value * d[:, None] ** 2
            if wrong and self.has("area_measure"):
                pdf = np.full(len(x), 1 / light.shape.area)
            if name == "wedge":
                # The normals of a smooth mesh.
                shading = unit(n_light + 0.4 * rng.normal(size=n_light.shape))
                if wrong and self.has("light_normal"):
                    pdf = d**2 / (light.shape.area * np.abs(dots(shading, w)))
            if wrong and self.has("selection_density"):
                pdf = pdf * selection
            if wrong and self.has("directions"):
                pdf = np.where(np.any(value > 0, axis=1), 1 / light.shape.solid_angle(x), pdf)
            if self.has("selection"):
                selection = 1
            if wrong and self.has("distance"):
                d = d * 100
            for i in range(len(x)):
                yield [*x[i], name, *w[i], 0 if pdf is None else pdf[i], *value[i], d[i], selection, *normal[i],
                       *(shading[i] if shading is not None else (0, 0, 1))]

    def densities(self, n, rng):
        """The densities of directions that are drawn half from the light and half from all directions."""
        for name in ("sun", "sky", "panel", "ball", "disk"):
            light = self.lights[name]
            x, _ = self.receivers(n, rng, 0)
            w, pdf, _, _, _ = light.li(x, rng)
            uniform = rng.random(n) < 0.5
            u = rng.random((n, 2))
            other = about(np.tile([0, 0, 1.0], (n, 1)), 1 - 2 * u[:, 0], 2 * math.pi * u[:, 1])
            w = np.where(uniform[:, None], other, w)
            pdf = self.density(name, x, w)
            drawn = 0.5 * pdf + 0.5 / (4 * math.pi)
            if self.has("radius_density") and name == "ball":
                pdf = self.density(name, x, w, BallLight(Ball(light.shape.center, 0.7), 12))
            if self.has("area_measure_given") and name == "panel":
                pdf = np.where(pdf > 0, 1 / light.shape.area, 0)
            for i in range(n):
                yield [*x[i], name, *w[i], pdf[i], drawn[i]]

    def density(self, name, x, w, light=None):
        light = light or self.lights[name]
        if name == "sky":
            return np.full(len(x), 1 / (4 * math.pi))
        if name == "sun":
            return np.where(w @ light.to_light >= light.cos, 1 / (2 * math.pi * (1 - light.cos)), 0)
        t = light.shape.meets(x, w)
        hit = np.isfinite(t)
        if name == "ball":
            return np.where(hit, light.density(x)[1], 0)
        t = np.where(hit, t, 0)
        return np.where(hit & light.shines(np.tile(light.shape.n, (len(x), 1)), -w),
                        t**2 / (light.shape.area * np.abs(w @ light.shape.n)), 0)

    def emission(self, n, rng):
        for name in ("bulb", "panel", "pane", "ball", "disk"):
            light = self.lights[name]
            u = rng.random((n, 2))
            if light.delta:
                p, normal = np.tile(light.position, (n, 1)), np.tile([0, 0, 1.0], (n, 1))
                d = about(normal, 1 - 2 * u[:, 0], 2 * math.pi * u[:, 1])
                pdf_position, pdf_direction = np.zeros(n), np.full(n, 1 / (4 * math.pi))
                value = light.intensity(d)
            else:
                p, normal = light.shape.sample(rng.random((n, 2)))
                if light.sides == 2:
                    normal = normal * np.where(rng.random(n) < 0.5, 1, -1)[:, None]
                cosine = np.sqrt(u[:, 0])
                d = about(normal, cosine, 2 * math.pi * u[:, 1])
                pdf_position = np.full(n, 1 / light.shape.area)
                pdf_direction = cosine / math.pi / light.sides
                value = np.tile(light.level, (n, 1))
                if self.has("emission_cosine") and name == "disk":
                    value = value * cosine[:, None]
            for i in range(n):
                yield [*p[i], name, *d[i], pdf_position[i], pdf_direction[i], *value[i], *normal[i]]

    def power(self):
        powers = {}
        for name in ("panel", "pane", "ball", "disk", "tube", "wedge"):
            powers[name] = self.lights[name].power()
        powers["bulb"] = 4 * math.pi * (np.array([12, 6, 3]) @ LUMINANCE)
        cos_out, cos_in = math.cos(math.radians(30)), math.cos(math.radians(18))
        powers["spot"] = 2 * math.pi * 40 * ((1 - cos_in) + (cos_in - cos_out) / 2)
        powers["gonio"] = 4 * math.pi * (mean_over_sphere(self.lights["gonio"].intensity) @ LUMINANCE)
        powers["screen"] = 2 * math.pi * 3 * (decode(SCREEN / 255).mean(axis=(0, 1)) @ LUMINANCE)
        # Straight lines between angles: integrals of (a + b theta) sin(theta).
        flux = 0
        for (t0, i0), (t1, i1) in zip(CANDELA, CANDELA[1:]):
            t0, t1 = math.radians(t0), math.radians(t1)
            b = (i1 - i0) / (t1 - t0)
            a = i0 - b * t0
            flux += a * (math.cos(t0) - math.cos(t1))
            flux += b * ((math.sin(t1) - t1 * math.cos(t1)) - (math.sin(t0) - t0 * math.cos(t0)))
        powers["downlight"] = 2 * math.pi * flux
        factors = {"4pi": 1 / (4 * math.pi), "683": 1 / 683, "two_sides_power": 2, "radius_power": 4}
        if self.mistake in factors:
            powers[MISTAKES[self.mistake][1]] *= factors[self.mistake]
        for name, power in powers.items():
            yield [name, power]

    def irradiance(self, n, rng, per_receiver=1024):
        for name in ("bulb", "spot", "far", "panel", "ball", "disk", "wedge"):
            light = self.lights[name]
            x, normal = self.receivers(n, rng, 0)
            geometric = unit(normal + 0.3 * rng.normal(size=normal.shape))
            count = 1 if light.delta else per_receiver
            places = np.repeat(x, count, axis=0)
            w, pdf, d, value, _ = light.li(places, rng)
            used = geometric if self.has("geometric_normal") and name == "bulb" else normal
            cosine = np.maximum(0, dots(np.repeat(used, count, axis=0), w))
            if self.has("cosine_irradiance") and name == "bulb":
                cosine = np.ones(len(w))
            each = value @ LUMINANCE * cosine / (1 if pdf is None else pdf)
            if self.has("inverse_square_irradiance") and name == "spot":
                each = each * d**2
            each = np.where(self.blocked(places, w, d), 0, each).reshape(n, count)
            if self.has("selection_irradiance") and name == "panel":
                each = each / len(self.names)
            mean = each.mean(axis=1)
            # An obstacle that hides less than one sample is not found.
            error = 0 * mean if light.delta else np.hypot(each.std(axis=1, ddof=1) / math.sqrt(count), mean / count)
            for i in range(n):
                yield [*x[i], *normal[i], mean[i], name, error[i], *geometric[i]]

    def visibility(self, n, rng):
        a, b = self.receivers(n, rng, 0)[0], rng.random((n, 3)) * [6, 6, 3.5] + [-3, -3, 0.1]
        d = np.linalg.norm(b - a, axis=1)
        seen = ~self.blocked(a, (b - a) / d[:, None], d)
        if self.has("no_occlusion"):
            seen[:] = True
        for i in range(n):
            yield [*a[i], *b[i], int(seen[i])]


SCENE = """# The lights of small_renderer.py.
WorldBegin
Shape "bilinearmesh" "point3 P" [-4 -4 0  4 -4 0  -4 4 0  4 4 0]
LightSource "point" "rgb I" [12 6 3] "point3 from" [1 -1 3] "string name" "bulb"
LightSource "spot" "rgb I" [40 40 40] "point3 from" [2 -2.5 3.5] "point3 to" [0 0 0]
  "float coneangle" [30] "float conedeltaangle" [12] "string name" "spot"
LightSource "distant" "rgb L" [2 2 2] "point3 from" [1 -2 3] "point3 to" [0 0 0] "string name" "far"
LightSource "distant" "rgb L" [3 3 3] "point3 from" [-1 -2 3] "point3 to" [0 0 0] "float angulardiameter" [10]
  "string name" "sun"
LightSource "infinite" "rgb L" [0.5 0.5 0.5] "string name" "sky"
LightSource "infinite" "string filename" "map.png" "float scale" [2] "string mapping" "latlong" "string name" "map"
AttributeBegin
  Translate -1 1 3
  LightSource "goniometric" "string filename" "gonio.png" "float scale" [30] "string mapping" "latlong"
    "string name" "gonio"
AttributeEnd
AttributeBegin
  Translate 0 0 3
  Rotate 180 1 0 0
  LightSource "projection" "string filename" "slide.png" "float fov" [40] "float scale" [60] "string name" "slide"
AttributeEnd
AttributeBegin
  Translate -2.5 2.5 3
  Rotate 180 1 0 0
  LightSource "goniometric" "string filename" "downlight.ies" "string name" "downlight"
AttributeEnd
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [12 12 12] "string name" "panel"
  Shape "bilinearmesh" "point3 P" [1 1 3  1 2 3  2.5 1 3  2.5 2 3]
AttributeEnd
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [5 5 5] "bool twosided" true "string name" "pane"
  Shape "bilinearmesh" "point3 P" [-1.5 1 2  -1.5 2 2  -1.5 1 2.5  -1.5 2 2.5]
AttributeEnd
AttributeBegin
  Translate 0.7 -1.2 2.6
  AreaLightSource "diffuse" "rgb L" [12 12 12] "string name" "ball"
  Shape "sphere" "float radius" [0.35]
AttributeEnd
AttributeBegin
  Translate -0.7 -1.2 2.6
  Rotate 180 1 0 0
  AreaLightSource "diffuse" "rgb L" [20 20 20] "string name" "disk"
  Shape "disk" "float radius" [0.4]
AttributeEnd
AttributeBegin
  Translate 0 -2.6 2.8
  Rotate 90 0 1 0
  AreaLightSource "diffuse" "rgb L" [14 14 14] "string name" "tube"
  Shape "cylinder" "float radius" [0.06] "float zmin" [-1] "float zmax" [1]
AttributeEnd
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [10 10 10] "string name" "wedge"
  Shape "trianglemesh" "point3 P" [-2 -1 3  -1 -1 3  -2 -2 3] "integer indices" [0 1 2]
AttributeEnd
AttributeBegin
  AreaLightSource "diffuse" "string filename" "screen.png" "float scale" [3] "bool twosided" true
    "string filter" "nearest" "string name" "screen"
  Shape "bilinearmesh" "point3 P" [3 1 1  3 2 1  3 1 2  3 2 2]
AttributeEnd
"""

HEADERS = {
    "samples": "x,y,z,light,wx,wy,wz,pdf,r,g,b,distance,selection,nx,ny,nz,lx,ly,lz",
    "densities": "x,y,z,light,wx,wy,wz,pdf,drawn",
    "emission": "x,y,z,light,wx,wy,wz,pdf_position,pdf_direction,r,g,b,nx,ny,nz",
    "power": "light,power",
    "irradiance": "x,y,z,nx,ny,nz,illuminance,light,stderr,gx,gy,gz",
    "visibility": "x,y,z,tx,ty,tz,visible",
}


def write_scene(folder):
    (folder / "scene.pbrt").write_text(SCENE)
    for name, texels in (("map", MAP), ("gonio", GONIO), ("slide", SLIDE), ("screen", SCREEN)):
        write_png(folder / f"{name}.png", texels)
    angles, candela = zip(*CANDELA)
    (folder / "downlight.ies").write_text(
        "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 4 1 1 2 0 0 0\n1 1 0\n" + " ".join(map(str, angles)) + "\n0\n"
        + " ".join(map(str, candela)) + "\n")


def write_tables(folder, seed, rows, receivers, mistake=None, digits=9, only=None):
    rng = np.random.default_rng(seed)
    renderer = Renderer(mistake)
    tables = {
        "samples": lambda: renderer.samples(rows, rng, receivers),
        "densities": lambda: renderer.densities(rows // 16, rng),
        "emission": lambda: renderer.emission(rows // 16, rng),
        "power": renderer.power,
        "irradiance": lambda: renderer.irradiance(12, rng),
        "visibility": lambda: renderer.visibility(rows // 16, rng),
    }
    for kind, table in tables.items():
        if only and kind not in only:
            continue
        with open(folder / f"{kind}.csv", "w", newline="", encoding="utf-8") as file:
            file.write(HEADERS[kind] + "\n")
            csv.writer(file, lineterminator="\n").writerows(
                [value if isinstance(value, str) else f"{value:.{digits}g}" for value in row] for row in table())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rows", type=int, default=6400)
    parser.add_argument("--receivers", type=int, default=200)
    parser.add_argument("--mistake", choices=MISTAKES)
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    write_scene(arguments.folder)
    write_tables(arguments.folder, arguments.seed, arguments.rows, arguments.receivers, arguments.mistake)


if __name__ == "__main__":
    main()
