#!/usr/bin/env python3
"""Prints the Cornell box of Debian's embree-tools as a .pbrt scene, for path_bench.

    tests/bench/embree_cornell.py >build/embree_cornell.pbrt

Reads cornell_box.obj, and the light and the camera of cornell_box.ecs.
"""
from pathlib import Path

MODELS = Path("/usr/share/doc/embree3/models")

HEAD = """\
Film "rgb" "integer xresolution" [512] "integer yresolution" [512] "string filename" ["embree_cornell.exr"]
PixelFilter "box" "float xradius" [0.5] "float yradius" [0.5]
Sampler "zsobol" "integer pixelsamples" [16]
Integrator "path" "integer maxdepth" [8]
LookAt {vp}  {vi}  {vu}
Camera "perspective" "float fov" [{fov}]
WorldBegin
LightSource "point" "point3 from" [{position}] "rgb I" [{intensity}]
"""


def colours():
    """Kd of each material."""
    out, name = {}, None
    for line in (MODELS / "cornell_box.mtl").read_text().splitlines():
        word, _, rest = line.partition(" ")
        if word == "newmtl":
            name = rest
        elif word == "Kd":
            out[name] = rest
    return out


def meshes():
    """(material, triangles) of each run of faces; a triangle has the numbers of three vertices."""
    vertices, runs = [], []
    for line in (MODELS / "cornell_box.obj").read_text().splitlines():
        words = line.split()
        if not words:
            continue
        if words[0] == "v":
            vertices.append(words[1:])
        elif words[0] == "usemtl":
            runs.append((words[1], []))
        elif words[0] == "f":
            v = [int(w) - 1 if int(w) > 0 else len(vertices) + int(w) for w in words[1:]]
            runs[-1][1].extend((v[0], v[i], v[i + 1]) for i in range(1, len(v) - 1))
    return vertices, runs


def main():
    options = (MODELS / "cornell_box.ecs").read_text().split()

    def after(option, count):
        at = options.index(option) + 1
        return " ".join(options[at:at + count])

    light = after("-pointlight", 6).split()
    print(HEAD.format(vp=after("-vp", 3), vi=after("-vi", 3), vu=after("-vu", 3), fov=after("-fov", 1),
                      position=" ".join(light[:3]), intensity=" ".join(light[3:])), end="")
    kd = colours()
    vertices, runs = meshes()
    for material, triangles in runs:
        if not triangles:
            continue
        used = sorted({v for t in triangles for v in t})
        print(f'Material "diffuse" "rgb reflectance" [{kd[material]}]')
        print('Shape "trianglemesh" "point3 P" [' + "  ".join(" ".join(vertices[v]) for v in used) + "]")
        print('  "integer indices" [' + "  ".join(" ".join(str(used.index(v)) for v in t) for t in triangles) + "]")


if __name__ == "__main__":
    main()
