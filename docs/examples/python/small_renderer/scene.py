"""The scene of the small renderer: its file, its pictures and its luminaire."""
import math
import struct
import zlib

import numpy as np


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


MAP, SLIDE, SCREEN = picture(1, 8, 16), picture(3, 8, 8), picture(4, 6, 6)
GONIO = np.repeat(picture(2, 8, 16)[..., :1], 3, axis=2)  # intensities have no colour
CANDELA = [(0, 300.0), (30, 250.0), (60, 100.0), (90, 20.0)]  # of the luminaire, from straight down


def latlong(w):
    """Longitude about +y from +x to +z, and the angle from +y, both from 0 to 1."""
    return (np.arctan2(w[..., 2], w[..., 0]) / (2 * math.pi)) % 1, np.arccos(np.clip(w[..., 1], -1, 1)) / math.pi


def mean_over_sphere(texels):
    """The mean RGB over all directions.  The solid angle of a row is the difference of its cosines."""
    cosines = np.cos(np.linspace(0, math.pi, len(texels) + 1))
    return decode(texels / 255).mean(axis=1).T @ ((cosines[:-1] - cosines[1:]) / 2)


SCENE = """# The lights of the small renderer.
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


def write_scene(folder):
    (folder / "scene.pbrt").write_text(SCENE)
    for name, texels in (("map", MAP), ("gonio", GONIO), ("slide", SLIDE), ("screen", SCREEN)):
        write_png(folder / f"{name}.png", texels)
    angles, candela = zip(*CANDELA)
    (folder / "downlight.ies").write_text(
        "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 4 1 1 2 0 0 0\n1 1 0\n" + " ".join(map(str, angles)) + "\n0\n"
        + " ".join(map(str, candela)) + "\n")
