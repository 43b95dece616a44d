#!/usr/bin/python3
"""A small renderer with mistakes that can be switched on.  It makes files for `lucerna verify`.

    renderer.py DIR [--seed N] [--rows N] [--receivers N] [--mistake NAME]

Writes DIR/scene.pbrt with its pictures, and samples.csv, densities.csv, emission.csv, power.csv, irradiance.csv and
visibility.csv.  It shares no code with Lucerna: its formulas come from textbooks.  Without --mistake, all numbers are
right.  Needs NumPy.
"""
import argparse
import csv
import math
import pathlib

import numpy as np

from lights import (LUMINANCE, Area, AtPoint, Ball, BallLight, Disk, FromFar, Parallelogram, Sky, Sun, Tube, about,
                    dots, unit)
from scene import CANDELA, GONIO, MAP, SCREEN, SLIDE, decode, latlong, mean_over_sphere, texel, write_scene

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
    "distance_109": ("distances that are 9% too large", "ball", "distance", ""),
    "sin_theta": ("a density without sin(theta)", "sky", "density", "sin_theta"),
    "cosine_sky": ("illuminance without the cosine", "sky", "illuminance", "cosine_receiver"),
    "range": ("values cut at a range", "bulb", "value", "range"),
    "window": ("values that fall to 0 at a range", "spot", "value", "range"),
}


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
            if wrong and self.has("distance_109"):
                d = d * 1.09
            if wrong and self.has("sin_theta"):
                # Uniform in both angles, as texels of equal size are.
                u = math.pi * rng.random((len(x), 2))
                pole = [0, 0, 1.0] if name == "sky" else [0, 1.0, 0]
                w = about(np.tile(pole, (len(x), 1)), np.cos(u[:, 0]), 2 * u[:, 1])
                pdf, value = np.full(len(x), 1 / (2 * math.pi**2)), light.radiance(w)
            if wrong and self.has("range"):
                value = value * (d < 3.2)[:, None]
            if wrong and self.has("window"):
                value = value * np.clip(1 - (d / 4) ** 4, 0, 1)[:, None]
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
        powers["gonio"] = 4 * math.pi * 30 * mean_over_sphere(GONIO)[0]
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
        names = ("bulb", "spot", "far", "panel", "ball", "disk", "wedge")
        for name in (*names, "sky") if self.has("cosine_sky") else names:
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
            if self.has("cosine_sky") and name == "sky":
                cosine = cosine > 0
            each = value @ LUMINANCE * cosine / (1 if pdf is None else pdf)
            if self.has("inverse_square_irradiance") and name == "spot":
                each = each * d**2
            unoccluded = each.reshape(n, count).mean(axis=1)
            each = np.where(self.blocked(places, w, d), 0, each).reshape(n, count)
            if self.has("selection_irradiance") and name == "panel":
                each = each / len(self.names)
            mean = each.mean(axis=1)
            # Light or shadow of less than one sample is not found.
            error = np.hypot(each.std(axis=1, ddof=1) / math.sqrt(count), unoccluded / count) if count > 1 else 0 * mean
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


HEADERS = {
    "samples": "x,y,z,light,wx,wy,wz,pdf,r,g,b,distance,selection,nx,ny,nz,lx,ly,lz",
    "densities": "x,y,z,light,wx,wy,wz,pdf,drawn",
    "emission": "x,y,z,light,wx,wy,wz,pdf_position,pdf_direction,r,g,b,nx,ny,nz",
    "power": "light,power",
    "irradiance": "x,y,z,nx,ny,nz,illuminance,light,stderr,gx,gy,gz",
    "visibility": "x,y,z,tx,ty,tz,visible",
}


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
