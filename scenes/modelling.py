"""Shared by the scripts that make the data of the shipped scenes: models of triangles, and files.

Debian packages: python3, python3-numpy.  Lengths in metres, z up unless a scene says otherwise.  The same bytes on every
machine: random numbers are those of random.Random.random(), and what sines and roots are in goes through tidy().
"""
import argparse
import contextlib
import math
import pathlib
import struct
import sys
import zlib

import numpy as np


def tidy(values, per_unit=10000):
    """Rounded to 1 / per_unit, by default 0.1 mm.

    Libraries differ in the last bits of a sine.  That changes nothing where no value is on the verge of the next one, and
    what formulas like to hit are halves: so the verge is moved beside them.
    """
    return np.floor(np.asarray(values, float) * per_unit + 0.41421) / per_unit


def number(value, per_unit=10000):
    """Text with no more digits than necessary."""
    return f"{tidy(value, per_unit):.10g}"


def numbers(values, per_unit=10000):
    return " ".join(number(v, per_unit) for v in values)


class Mesh:
    """Triangles that share vertices."""

    def __init__(self):
        self.vertices, self.faces, self.count = [], [], 0

    def add(self, vertices, faces):
        self.vertices.append(np.asarray(vertices, float).reshape(-1, 3))
        self.faces.append(np.asarray(faces, np.int32).reshape(-1, 3) + self.count)
        self.count += len(self.vertices[-1])

    def ply(self):
        vertices = tidy(np.concatenate(self.vertices)).astype("<f4")
        faces = np.concatenate(self.faces)
        rows = np.zeros(len(faces), dtype=[("n", "u1"), ("i", "<i4", 3)])
        rows["n"], rows["i"] = 3, faces
        header = (
            "ply\nformat binary_little_endian 1.0\n"
            f"element vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
            f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
        )
        return header.encode() + vertices.tobytes() + rows.tobytes()


def coated(reflectance, roughness, eta=1.5):
    """A diffuse surface under a clear coat."""
    return (
        f'"coateddiffuse" "rgb reflectance" [{numbers(reflectance)}] "float roughness" {number(roughness)} '
        f'"float eta" {number(eta)}'
    )


def metal(reflectance, roughness):
    """A metal that reflects this share of light that arrives along the normal."""
    return f'"conductor" "rgb reflectance" [{numbers(reflectance)}] "float roughness" {number(roughness)}'


def named_metal(name, roughness):
    """A metal by its measured index: Ag, Al, Au, Cr, Cu or W."""
    return (
        f'"conductor" "spectrum eta" "metal-{name}-eta" "spectrum k" "metal-{name}-k" '
        f'"float roughness" {number(roughness)}'
    )


def leaf(reflectance, transmittance):
    """A thin sheet that scatters light to both sides."""
    return (
        f'"diffusetransmission" "rgb reflectance" [{numbers(reflectance)}] "rgb transmittance" [{numbers(transmittance)}]'
    )


PANE = '"thindielectric"'


class Model:
    """A mesh for each surface.  The open frames of `placed` place everything that is added.

    A surface is a reflectance (R, G, B), or a material as after the directive Material.  `alpha` names the picture of
    alpha of surfaces with holes.
    """

    def __init__(self, surfaces, alpha=None):
        self.surfaces, self.alpha = surfaces, alpha or {}
        self.meshes = {name: Mesh() for name in surfaces}
        self.turn, self.shift = np.eye(3), np.zeros(3)

    @contextlib.contextmanager
    def placed(self, at=(0, 0, 0), turn=0.0, lean=0.0):
        """Rotates about x by `lean` degrees, about z by `turn`, then shifts to `at`."""
        before = self.turn, self.shift
        c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
        k, t = math.cos(math.radians(lean)), math.sin(math.radians(lean))
        own = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.array([[1, 0, 0], [0, k, -t], [0, t, k]])
        self.shift = self.point(at)
        self.turn = self.turn @ own
        yield self
        self.turn, self.shift = before

    def point(self, p):
        return np.asarray(p, float) @ self.turn.T + self.shift

    def add(self, surface, vertices, faces):
        self.meshes[surface].add(self.point(vertices), faces)

    def quad(self, surface, a, b, c, d):
        self.add(surface, [a, b, c, d], [[0, 1, 2], [0, 2, 3]])

    def box(self, surface, low, high):
        (x, y, z), (u, v, w) = low, high
        corners = [(x, y, z), (u, y, z), (u, v, z), (x, v, z), (x, y, w), (u, y, w), (u, v, w), (x, v, w)]
        sides = [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
        self.add(surface, corners, [f for a, b, c, d in sides for f in ((a, b, c), (a, c, d))])

    def prism(self, surface, outline, low, high):
        """A convex outline in (x, y), counterclockwise seen from above, from z = low to high."""
        n = len(outline)
        vertices = [(x, y, z) for z in (low, high) for x, y in outline]
        sides = [f for i in range(n) for j in [(i + 1) % n] for f in ((i, j, n + j), (i, n + j, n + i))]
        caps = [f for i in range(1, n - 1) for f in ((0, i + 1, i), (n, n + i, n + i + 1))]
        self.add(surface, vertices, sides + caps)

    def grid(self, surface, points):
        """A surface through an array of points, rows by columns by 3."""
        h, w = points.shape[:2]
        k = np.arange(h * w).reshape(h, w)
        a, b, c, d = k[:-1, :-1].ravel(), k[:-1, 1:].ravel(), k[1:, 1:].ravel(), k[1:, :-1].ravel()
        self.add(surface, points, np.stack([a, b, c, a, c, d], 1))

    def lathe(self, surface, profile, sides=24, at=(0, 0, 0)):
        """Rotates a line of (radius, height) about the vertical through `at`; ends of radius 0 close it."""
        angles = np.arange(sides) * (2 * math.pi / sides)
        ring = np.stack([np.cos(angles), np.sin(angles), np.zeros(sides)], 1)
        rows = [ring * (r, r, 0) + np.asarray(at) + (0, 0, z) for r, z in profile]
        faces = []
        for row, ((r, _), (s, _)) in enumerate(zip(profile, profile[1:])):
            for i in range(sides):
                a, b = row * sides + i, row * sides + (i + 1) % sides
                # A triangle if one end is on the axis.
                faces += ([(a, b, b + sides)] if r > 0 else []) + ([(a, b + sides, a + sides)] if s > 0 else [])
        self.add(surface, np.concatenate(rows), faces)

    def ball(self, surface, centre, radius, sides=24):
        half = sides // 2
        arc = [math.pi * (i / half - 0.5) for i in range(half + 1)]
        profile = [(radius * math.cos(a) if 0 < i < half else 0, radius * math.sin(a)) for i, a in enumerate(arc)]
        self.lathe(surface, profile, sides, centre)

    def rod(self, surface, a, b, radius, sides=8, end_radius=None):
        """A closed cylinder, or a frustum of a cone if its end has another radius."""
        a, b = np.asarray(a, float), np.asarray(b, float)
        axis = (b - a) / np.linalg.norm(b - a)
        across = np.cross(axis, (0, 0, 1) if abs(axis[2]) < 0.9 else (1, 0, 0))
        across /= np.linalg.norm(across)
        up = np.cross(axis, across)
        angles = np.arange(sides) * (2 * math.pi / sides)
        ring = np.cos(angles)[:, None] * across + np.sin(angles)[:, None] * up
        end = radius if end_radius is None else end_radius
        faces = [f for i in range(sides) for j in [(i + 1) % sides] for f in ((i, j, sides + j), (i, sides + j, sides + i))]
        caps = [f for i in range(1, sides - 1) for f in ((0, i + 1, i), (sides, sides + i, sides + i + 1))]
        self.add(surface, np.concatenate([a + ring * radius, b + ring * end]), faces + caps)

    def files(self):
        """The meshes, and surfaces.pbrt, which names them all with their materials."""
        text, files = "# Made by make.py: what a scene's light falls on.\n", {}
        for picture in sorted(set(self.alpha.values())):
            text += f'Texture "{picture}" "float" "imagemap" "string filename" "{picture}" "string encoding" "linear"\n'
        for name, surface in self.surfaces.items():
            files[f"{name}.ply"] = self.meshes[name].ply()
            material = surface if isinstance(surface, str) else f'"diffuse" "rgb reflectance" [{numbers(surface)}]'
            holes = f' "texture alpha" "{self.alpha[name]}"' if name in self.alpha else ""
            text += f"Material {material}\n"
            text += f'Shape "plymesh" "string filename" "{name}.ply"{holes}\n'
        files["surfaces.pbrt"] = text.encode()
        return files


def csv(receivers):
    """A file for `lucerna irradiance --points`, from rows x, y, z, nx, ny, nz."""
    text = "# x, y, z [m], normal\n"
    return (text + "".join(",".join(number(v) for v in row) + "\n" for row in receivers)).encode()


def png(pixels):
    """From bytes, rows by columns, by 3 or by 4 (RGB and alpha).  Not compressed, since versions of compressors differ."""
    h, w = pixels.shape[:2]
    raw = b"".join(b"\0" + row.tobytes() for row in np.ascontiguousarray(pixels, np.uint8))
    blocks = [raw[i : i + 65535] for i in range(0, len(raw), 65535)]
    stream = b"\x78\x01"
    for i, block in enumerate(blocks):
        stream += struct.pack("<BHH", i == len(blocks) - 1, len(block), len(block) ^ 0xFFFF) + block
    stream += struct.pack(">I", zlib.adler32(raw))

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    colour_type = 0 if pixels.ndim == 2 else {3: 2, 4: 6}[pixels.shape[2]]
    head = struct.pack(">IIBBBBB", w, h, 8, colour_type, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", stream) + chunk(b"IEND", b"")


def hdr(pixels):
    """A Radiance picture, linear RGB in bytes with a common exponent, not compressed."""
    h, w = pixels.shape[:2]
    _, exponent = np.frexp(pixels.max(axis=2))
    mantissas = np.floor(np.ldexp(pixels, 8 - exponent[..., None]) + 0.41421).clip(0, 255)
    rgbe = np.concatenate([mantissas, exponent[..., None] + 128], axis=2).astype(np.uint8)
    return f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {h} +X {w}\n".encode() + rgbe.tobytes()


def ies(name, lumens, intensity, vertical, horizontal=(0,), size=(0, 0, 0)):
    """LM-63-2002, type C.  `intensity(v, h)`, angles in degrees, is scaled to the luminaire's `lumens`.

    size: width across C0, length along it, height [m].
    """
    candela = np.array([[intensity(v, h) for v in vertical] for h in horizontal], float)
    candela = tidy(candela * (lumens / flux(candela, vertical, horizontal)), 10)
    lines = ["IESNA:LM-63-2002", "[TEST] computed, not measured", "[TESTLAB] Lucerna", "[ISSUEDATE] 22-NOV-2026"]
    lines += ["[MANUFAC] none", f"[LUMCAT] {name[0]}", f"[LUMINAIRE] {name[1]}", "TILT=NONE"]
    width, length, height = size
    lines += [f"1 -1 1 {len(vertical)} {len(horizontal)} 1 2 {width} {length} {height}", "1 1 0"]
    lines += [" ".join(f"{a:g}" for a in angles) for angles in (vertical, horizontal)]
    lines += [" ".join(f"{c:g}" for c in row) for row in candela]
    return ("\n".join(lines) + "\n").encode()


def flux(candela, vertical, horizontal):
    """Flux of intensities that are linear between the angles, by the midpoint rule in steps of 0.05 degrees."""
    step = 0.05
    v = np.arange(vertical[0] + step / 2, vertical[-1], step)
    planes = [np.interp(v, vertical, row) for row in candela]
    if len(horizontal) > 1:
        spans = np.diff(horizontal)
        mean = sum(d * (a + b) / 2 for d, a, b in zip(spans, planes, planes[1:])) / spans.sum()
    else:
        mean = planes[0]
    return 2 * math.pi * math.radians(step) * float(np.sum(mean * np.sin(np.radians(v))))


def main(script, make):
    """Writes the files that `make()` returns (contents by name) beside the script; --check only compares."""
    parser = argparse.ArgumentParser(description=sys.modules["__main__"].__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="say which files are not what this makes")
    check = parser.parse_args().check
    folder, stale = pathlib.Path(script).resolve().parent, []
    files = make()
    for name, content in files.items():
        path = folder / name
        if not check:
            path.write_bytes(content)
        elif not path.exists() or path.read_bytes() != content:
            stale.append(name)
    by_hand = {"scene.pbrt", *(p.name for p in folder.glob("*.py"))}
    stale += [p.name for p in folder.iterdir() if p.is_file() and p.name not in files and p.name not in by_hand]
    if stale and check:
        sys.exit(f"{folder.name}: not what make.py makes: " + ", ".join(sorted(stale)))
