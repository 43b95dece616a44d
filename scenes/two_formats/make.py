#!/usr/bin/python3
"""Writes one furnished room twice: as scene.pbrt, and as scene.gltf with scene.bin.

Both files have the same numbers, and both describe the same light.  So Lucerna must answer alike for both; the test
tests/e2e/two_formats_test.py compares the answers.  Lengths in metres, y up, in both files.

The room holds only what both formats describe by the same formulas.  Left out, since the formulas differ:
- metals: glTF approximates Fresnel's equations, the conductors of pbrt-v4 do not;
- varnish, plastic and rough glass: the diffuse part and the coat of glTF are not those of "coateddiffuse", and glTF's
  transmission is that of a thin sheet, "dielectric" is a solid body;
- round shapes and textured lights of other shapes than triangles: glTF has only triangles.

Debian packages: those of modelling.py.
"""
import json
import math
import pathlib
import re
import sys

import numpy as np

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import modelling

WIDTH, HEIGHT, DEPTH = 4.0, 2.6, 3.2  # x, y, z; the window is in the wall z = 0
WINDOW = (1.0, 0.9), (2.2, 2.0)  # x, y
IES = "../wallwasher.ies"
FILM = 960, 720  # glTF has no resolution: Lucerna's height is 720
SAMPLES = 64
VERTICAL_FOV_DEG = 62

# Diffuse reflectances, linear RGB.
COLOURS = {
    "white": (0.8, 0.8, 0.78),
    "red": (0.62, 0.12, 0.08),
    "green": (0.12, 0.45, 0.14),
    "blue": (0.2, 0.28, 0.5),
    "wood": (0.5, 0.32, 0.18),
    "lamp": (0, 0, 0),
}
PANE_INDEX = 1.5
PANEL_CD_M2 = (800, 720, 640)


class Place:
    """Where something stands: a scale, then a rotation by degrees about an axis, then a translation."""

    def __init__(self, at=(0, 0, 0), turn_deg=0, axis=(0, 1, 0), scale=(1, 1, 1)):
        self.at, self.turn_deg, self.axis, self.scale = at, turn_deg, axis, scale

    def pbrt(self):
        lines = [f"Translate {plain(self.at)}"]
        lines += [f"Rotate {plain([self.turn_deg])} {plain(self.axis)}"] if self.turn_deg else []
        lines += [f"Scale {plain(self.scale)}"] if self.scale != (1, 1, 1) else []
        return lines

    def gltf(self):
        """With rounded quaternions, so that all machines write the same bytes."""
        node = {"translation": list(self.at)}
        if self.turn_deg:
            half, length = math.radians(self.turn_deg) / 2, math.hypot(*self.axis)
            node["rotation"] = exact(a / length * math.sin(half) for a in self.axis) + exact([math.cos(half)])
        if self.scale != (1, 1, 1):
            node["scale"] = list(self.scale)
        return node


# The lights in the order of both files: name, place, and the level.
LIGHTS = [
    ("bulb", "point", Place((3.3, 1.7, 2.4)), {"cd": 40, "colour": (1, 0.8, 0.55)}),
    ("spot", "spot", Place((0.6, 2.5, 2.6), -75, (1, 0.2, 0)), {"cd": 300, "colour": (1, 0.95, 0.9), "cones_deg": (18, 25)}),
    ("sun", "distant", Place((0, 0, 0), -140, (1, 0.15, 0)), {"lx": 900, "colour": (1, 0.97, 0.9)}),
    ("wallwasher", "ies", Place((3.4, 2.4, 1), -90, (1, 0, 0)), {"factor": 0.25, "colour": (1, 0.9, 0.75)}),
]
CAMERA = Place((2.1, 1.5, 3.1), -8, (1, 0.1, 0))


def exact(values):
    """Nine decimals."""
    return [float(modelling.number(v, 1e9)) for v in values]


def plain(values):
    return " ".join(f"{v:.10g}" for v in values)


class Part:
    """Triangles of one material.  Positions and (u, v) are float32, as in scene.bin."""

    def __init__(self, name, material):
        self.name, self.material = name, material
        self.positions, self.uv, self.indices, self.count = [], [], [], 0

    def quad(self, a, b, c, d, uv=None):
        """Seen counterclockwise from outside.  `uv`: the largest u and v, at the corner `c`."""
        self.positions += [a, b, c, d]
        self.uv += [(0, 0), (uv[0], 0), uv, (0, uv[1])] if uv else []
        self.indices += [self.count + i for i in (0, 1, 2, 0, 2, 3)]
        self.count += 4
        return self

    def box(self, low, high):
        (x, y, z), (u, v, w) = low, high
        self.quad((x, y, w), (u, y, w), (u, v, w), (x, v, w))
        self.quad((u, y, z), (x, y, z), (x, v, z), (u, v, z))
        self.quad((u, y, w), (u, y, z), (u, v, z), (u, v, w))
        self.quad((x, y, z), (x, y, w), (x, v, w), (x, v, z))
        self.quad((x, v, w), (u, v, w), (u, v, z), (x, v, z))
        return self.quad((x, y, z), (u, y, z), (u, y, w), (x, y, w))


def building():
    """Walls face inwards."""
    w, h, d = WIDTH, HEIGHT, DEPTH
    (left, sill), (right, head) = WINDOW
    floor = Part("floor", "tiles").quad((0, 0, d), (w, 0, d), (w, 0, 0), (0, 0, 0), (5, 4))
    ceiling = Part("ceiling", "white").quad((0, h, 0), (w, h, 0), (w, h, d), (0, h, d))
    ceiling.quad((w, 0, d), (0, 0, d), (0, h, d), (w, h, d))  # the wall behind the camera
    wall = Part("window wall", "blue")
    for x, y, u, v in ((0, 0, left, h), (right, 0, w, h), (left, 0, right, sill), (left, head, right, h)):
        wall.quad((x, y, 0), (u, y, 0), (u, v, 0), (x, v, 0))
    red = Part("left wall", "red").quad((0, 0, d), (0, 0, 0), (0, h, 0), (0, h, d))
    green = Part("right wall", "green").quad((w, 0, 0), (w, 0, d), (w, h, d), (w, h, 0))
    pane = Part("pane", "pane").quad((left, sill, -0.05), (right, sill, -0.05), (right, head, -0.05), (left, head, -0.05))
    return [floor, ceiling, wall, red, green, pane]


def furniture():
    table = Part("table", "wood").box((1.4, 0.7, 0.9), (2.6, 0.74, 1.6))
    for x in (1.45, 2.5):
        for z in (0.95, 1.5):
            table.box((x, 0, z), (x + 0.05, 0.7, z + 0.05))
    leaf = Part("leaf", "leaf")
    leaf.quad((1.75, 0.74, 1.15), (2.1, 0.74, 1.35), (2.05, 1.25, 1.4), (1.7, 1.25, 1.2), (1, 1))
    return [table, leaf]


def stool():
    return Part("stool", "white").box((-0.2, 0.4, -0.2), (0.2, 0.45, 0.2)).box((-0.05, 0, -0.05), (0.05, 0.4, 0.05))


STOOLS = [
    ("near stool", Place((1.0, 0, 1.7), 30)),
    ("far stool", Place((3.1, 0, 1.1), -20, scale=(1.25, 1.5, 1))),
]


def panel():
    h = HEIGHT - 0.02
    return Part("panel", "lamp").quad((1.5, h, 1.2), (2.5, h, 1.2), (2.5, h, 1.8), (1.5, h, 1.8))


def tiles():
    """8 x 8 texels of sRGB."""
    rows, columns = np.mgrid[0:8, 0:8]
    light = (rows // 4 + columns // 4) % 2 == 0
    shade = (rows * 7 + columns * 13) % 5 * 6
    return np.where(light[..., None], (222, 214, 196), (126, 96, 84)) - shade[..., None]


def holes():
    """16 x 16 texels of alpha, each 255 or 0."""
    rows, columns = np.mgrid[0:16, 0:16]
    solid = abs(columns - 7.5) < 1 + 3.1 * np.sqrt(np.minimum(rows, 15 - rows))
    solid &= ~((rows % 4 == 3) & (abs(columns - 7.5) > 1))
    return solid * 255


def float32_text(value):
    return np.format_float_positional(np.float32(value), unique=True, trim="-")


def pbrt_shape(part):
    points = "  ".join(" ".join(float32_text(x) for x in p) for p in part.positions)
    lines = [f'  Shape "trianglemesh" "integer indices" [{plain(part.indices)}]', f'    "point3 P" [{points}]']
    if part.uv:  # v grows upwards in pbrt-v4
        lines.append(f'    "point2 uv" [{"  ".join(f"{float32_text(u)} {float32_text(1 - v)}" for u, v in part.uv)}]')
    if part.material == "leaf":
        lines[-1] += ' "texture alpha" "holes"'
    return lines


def attributes(*groups):
    return ["AttributeBegin", *("  " + line.strip() if i == 0 else line for g in groups for i, line in enumerate(g)), "AttributeEnd"]


def pbrt_light(name, kind, place, level):
    colour = f'"rgb {"L" if kind == "distant" else "I"}" [{plain(level["colour"])}]'
    towards = {
        "point": "",
        "spot": '"point3 from" [0 0 0] "point3 to" [0 0 -1]',
        "distant": '"point3 from" [0 0 1] "point3 to" [0 0 0]',
        "ies": f'"string filename" "{IES}"',
    }[kind]
    if kind == "spot":
        inner, outer = level["cones_deg"]
        towards += f' "float coneangle" {outer:g} "float conedeltaangle" {outer - inner:.10g} "string profile" "quadratic"'
    scale = level.get("cd") or level.get("lx") or level["factor"]
    lines = place.pbrt() + (["Rotate 180 1 0 0"] if kind == "ies" else [])
    lines += [f'LightSource "{"goniometric" if kind == "ies" else kind}" "string name" "{name}"']
    return attributes([], ["  " + line for line in lines], [f"    {colour} \"float scale\" {scale:g} {towards}".rstrip()])


def pbrt():
    width, height = FILM
    lines = ["# Made by make.py: the same room as scene.gltf."]
    lines += [f'Film "rgb" "integer xresolution" {width} "integer yresolution" {height} "string sensor" "cie1931"']
    lines += ['  "string filename" "two_formats.exr" "bool savefp16" false']
    lines += ['PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5']
    lines += [f'Sampler "zsobol" "integer pixelsamples" {SAMPLES}', 'Integrator "path" "integer maxdepth" 1000']
    lines += ["# The camera looks along -z of its place, and camera space is left-handed.", "Scale 1 1 -1"]
    lines += [f"Rotate {-CAMERA.turn_deg:g} {plain(CAMERA.axis)}", f"Translate {plain(-x for x in CAMERA.at)}"]
    lines += [f'Camera "perspective" "float fov" {VERTICAL_FOV_DEG}', "WorldBegin", ""]
    for light in LIGHTS:
        lines += pbrt_light(*light)
    lines += ["", 'Texture "tiles" "spectrum" "imagemap" "string filename" "tiles.png" "string filter" "bilinear"']
    lines += ['Texture "holes" "float" "imagemap" "string filename" "holes.png" "string filter" "point"']
    for name, colour in COLOURS.items():
        lines.append(f'MakeNamedMaterial "{name}" "string type" "diffuse" "rgb reflectance" [{plain(colour)}]')
    lines += ['MakeNamedMaterial "tiles" "string type" "diffuse" "texture reflectance" "tiles"']
    lines += [f'MakeNamedMaterial "leaf" "string type" "diffuse" "rgb reflectance" [{plain(COLOURS["green"])}]']
    lines += [f'MakeNamedMaterial "pane" "string type" "thindielectric" "float eta" {PANE_INDEX}', ""]
    for part in building() + furniture():
        lines += [f'NamedMaterial "{part.material}"', *(line[2:] for line in pbrt_shape(part))]
    lines += ["", 'ObjectBegin "stool"', f'  NamedMaterial "{stool().material}"', *pbrt_shape(stool()), "ObjectEnd"]
    for _, place in STOOLS:
        lines += attributes([], ["  " + line for line in place.pbrt()], ['  ObjectInstance "stool"'])
    light = [f'  AreaLightSource "diffuse" "rgb L" [{plain(PANEL_CD_M2)}] "string name" "panel"', '  NamedMaterial "lamp"']
    lines += ["", *attributes([], light, pbrt_shape(panel()))]
    return ("\n".join(lines) + "\n").encode()


class Gltf:
    def __init__(self):
        self.bytes, self.views, self.accessors, self.meshes, self.nodes = b"", [], [], [], []
        self.materials = []

    def accessor(self, values, kind, component, target, bounds=False):
        array = np.asarray(values, "<f4" if component == 5126 else "<u2")
        self.views.append({"buffer": 0, "byteOffset": len(self.bytes), "byteLength": array.nbytes, "target": target})
        self.bytes += array.tobytes() + b"\0" * (-array.nbytes % 4)
        accessor = {"bufferView": len(self.views) - 1, "componentType": component, "count": len(array), "type": kind}
        if bounds:
            accessor["min"], accessor["max"] = ([float(float32_text(x)) for x in f(array, axis=0)] for f in (np.min, np.max))
        self.accessors.append(accessor)
        return len(self.accessors) - 1

    def mesh(self, part):
        attributes = {"POSITION": self.accessor(part.positions, "VEC3", 5126, 34962, True)}
        if part.uv:
            attributes["TEXCOORD_0"] = self.accessor(part.uv, "VEC2", 5126, 34962)
        names = [material["name"] for material in self.materials]
        primitive = {
            "attributes": attributes,
            "indices": self.accessor(part.indices, "SCALAR", 5123, 34963),
            "material": names.index(part.material),
        }
        self.meshes.append({"name": part.name, "primitives": [primitive]})
        return len(self.meshes) - 1

    def diffuse(self, name, colour=None, texture=None, **more):
        """glTF's material is diffuse if it is no metal and reflects nothing at its surface."""
        pbr = {"metallicFactor": 0}
        if colour:
            pbr["baseColorFactor"] = [*colour, 1]
        if texture is not None:
            pbr["baseColorTexture"] = {"index": texture}
        extensions = {"KHR_materials_specular": {"specularFactor": 0}, **more.pop("extensions", {})}
        self.materials.append({"name": name, "pbrMetallicRoughness": pbr, "extensions": extensions, **more})


def gltf_light(name, kind, place, level):
    """The definition in the extension at the root, and the node's part."""
    if kind == "ies":
        return {"uri": IES}, {"multiplier": level["factor"], "color": list(level["colour"])}
    light = {"name": name, "type": {"distant": "directional"}.get(kind, kind)}
    light |= {"color": list(level["colour"]), "intensity": level.get("cd") or level["lx"]}
    if kind == "spot":
        inner, outer = exact(math.radians(a) for a in level["cones_deg"])
        light["spot"] = {"innerConeAngle": inner, "outerConeAngle": outer}
    return light, {}


def gltf():
    """scene.gltf and scene.bin."""
    file = Gltf()
    strongest = max(PANEL_CD_M2)
    glow = {
        "emissiveFactor": [x / strongest for x in PANEL_CD_M2],
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": strongest}},
    }
    for name, colour in COLOURS.items():
        file.diffuse(name, colour, **(glow if name == "lamp" else {}))
    file.diffuse("tiles", texture=0)
    file.diffuse("leaf", COLOURS["green"], texture=1, alphaMode="MASK", alphaCutoff=0.5)
    file.materials.append(
        {
            "name": "pane",
            "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0},
            "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": PANE_INDEX}},
        }
    )
    punctual, luminaires = [], []
    for name, kind, place, level in LIGHTS:
        definition, use = gltf_light(name, kind, place, level)
        extension, lights = ("EXT_lights_ies", luminaires) if kind == "ies" else ("KHR_lights_punctual", punctual)
        file.nodes.append({"name": name, **place.gltf(), "extensions": {extension: {"light": len(lights), **use}}})
        lights.append(definition)
    for part in building() + furniture():
        file.nodes.append({"name": part.name, "mesh": file.mesh(part)})
    mesh = file.mesh(stool())
    file.nodes += [{"name": name, "mesh": mesh, **place.gltf()} for name, place in STOOLS]
    file.nodes.append({"name": "panel", "mesh": file.mesh(panel())})
    file.nodes.append({"name": "camera", "camera": 0, **CAMERA.gltf()})
    yfov = exact([math.radians(VERTICAL_FOV_DEG)])[0]
    root = {
        "asset": {"version": "2.0", "generator": "scenes/two_formats/make.py"},
        "extensionsUsed": [
            "EXT_lights_ies",
            "KHR_lights_punctual",
            "KHR_materials_emissive_strength",
            "KHR_materials_ior",
            "KHR_materials_specular",
            "KHR_materials_transmission",
        ],
        "extensions": {"EXT_lights_ies": {"lights": luminaires}, "KHR_lights_punctual": {"lights": punctual}},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(file.nodes)))}],
        "cameras": [
            {"type": "perspective", "perspective": {"yfov": yfov, "aspectRatio": exact([FILM[0] / FILM[1]])[0], "znear": 0.01}}
        ],
        "nodes": file.nodes,
        "meshes": file.meshes,
        "materials": file.materials,
        "textures": [{"source": 0, "sampler": 0}, {"source": 1, "sampler": 1}],
        "images": [{"uri": "tiles.png"}, {"uri": "leaf.png"}],
        "samplers": [{"magFilter": 9729}, {"magFilter": 9728}],
        "accessors": file.accessors,
        "bufferViews": file.views,
        "buffers": [{"uri": "scene.bin", "byteLength": len(file.bytes)}],
    }
    text = json.dumps(root, indent=1)
    # Lists of numbers in one line.
    text = re.sub(r"\[[-\d.e+,\s]+\]", lambda m: re.sub(r"\s+", " ", m[0]).replace("[ ", "[").replace(" ]", "]"), text)
    return {"scene.gltf": (text + "\n").encode(), "scene.bin": file.bytes}


def make():
    # pbrt-v4 has pictures of alpha alone, glTF has alpha beside RGB.
    leaf = np.stack([np.full((16, 16), 255)] * 3 + [holes()], 2)
    pictures = {"tiles.png": tiles(), "holes.png": holes(), "leaf.png": leaf}
    return {"scene.pbrt": pbrt(), **gltf(), **{name: modelling.png(pixels) for name, pixels in pictures.items()}}


if __name__ == "__main__":
    modelling.main(__file__, make)
