#!/usr/bin/python3
"""Writes the seeds of the fuzz targets into tests/fuzz/corpus.

Seeds are valid inputs, and inputs with one error.  Further inputs in these folders begin with
"found_" or "grown_"; this script leaves them alone.  --check only compares.

An input of several files joins them by lines "#FILE name" (input_files.h).
"""
import hashlib
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

HERE = pathlib.Path(__file__).resolve().parent
CORPUS = HERE / "corpus"
DATA = HERE.parent / "data"
PROTO = HERE.parent.parent / "proto"


def joined(main, *names):
    """A scene of tests/data with the files that it names."""
    path = DATA / main
    text = path.read_bytes()
    for name in names:
        text += b"\n#FILE " + name.encode() + b"\n" + (path.parent / name).read_bytes()
    return text


# ------------------------------------------------------------------------------- scene files

def pbrt():
    ref = "reference/"
    yield "everything", joined("pbrt/everything.pbrt", "square.ply", "parts.pbrt")
    for name in ("moving_both", "moving_camera", "moving_point", "moving_sun", "moving_surfaces",
                 "twelve_samples"):
        yield name, joined(f"pbrt/{name}.pbrt")
    text = (DATA / "lights/every_light.pbrt").read_bytes().replace(b"../reference/", b"")
    for name in ("lights/downlight.ies", "lights/sconce.ldt", ref + "slide.exr", ref + "screen.exr"):
        path = DATA / name
        text += b"\n#FILE " + path.name.encode() + b"\n" + path.read_bytes()
    yield "every_light", text
    for name, *files in (
            ("blackbody",), ("bounces",), ("colour",), ("cylinder",), ("disk",), ("infinite",),
            ("lens",), ("orthographic",), ("spherical",), ("mitchell",), ("gaussian",), ("portal",),
            ("point_power",), ("m_absorption",), ("m_coated",), ("m_coated_metal",),
            ("m_conductor",), ("m_conductor_aniso",), ("m_copper",), ("m_dielectric",), ("m_mix",),
            ("m_loop",), ("m_thin",), ("m_transmission",), ("m_texture_maths",),
            ("m_texture", "tiles.png"), ("m_normalmap", "bumps.png"), ("m_alpha", "holes.png"),
            ("textured", "screen.exr"), ("projection", "slide.exr")):
        text = joined(f"{ref}{name}.pbrt", *files)
        yield name, text
    yield "bom", b"\xef\xbb\xbfWorldBegin\n"
    yield "utf16", b"\xff\xfeW\0"
    yield "includes_itself", b'WorldBegin Include "scene.pbrt"'
    yield "leaves_the_root", b'WorldBegin Include "../scene.pbrt"'
    yield "unclosed", b'WorldBegin AttributeBegin ObjectBegin "a" Shape "sphere"'


# -------------------------------------------------------------------------------------- PLY

def ply_text(form, elements, body):
    return f"ply\nformat {form} 1.0\ncomment made up\n{elements}end_header\n".encode() + body


VERTEX = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
FACE = "element face 2\nproperty list uchar int vertex_indices\n"
CORNERS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]


def ply():
    square = "".join(f"{x} {y} {z}\n" for x, y, z in CORNERS)
    yield "ascii", ply_text("ascii", VERTEX + FACE, (square + "3 0 1 2\n3 0 2 3\n").encode())
    yield "ascii_quad", ply_text("ascii", VERTEX + FACE.replace("2\n", "1\n", 1),
                                 (square + "4 0 1 2 3\n").encode())
    everything = (VERTEX + "property double nx\nproperty double ny\nproperty double nz\n"
                  "property short u\nproperty short v\nproperty list char ushort other\n"
                  "element edge 1\nproperty uint from\n" + FACE)
    rows = "".join(f"{x} {y} {z} 0 +0 1e0 {x} {y} 2 7 8\n" for x, y, z in CORNERS)
    yield "ascii_everything", ply_text("ascii", everything, (rows + "5\n3 0 1 2\n3 0 2 3").encode())
    for form, order in (("binary_little_endian", "<"), ("binary_big_endian", ">")):
        body = b"".join(struct.pack(order + "3f", *corner) for corner in CORNERS)
        body += struct.pack(order + "B3i", 3, 0, 1, 2) + struct.pack(order + "B3i", 3, 0, 2, 3)
        yield form, ply_text(form, VERTEX + FACE, body)
        body = b"".join(struct.pack(order + "3f3d2hbHH", *corner, 0, 0, 1, 0, 1, 2, 5, 6)
                        for corner in CORNERS)
        body += struct.pack(order + "I", 9)
        body += struct.pack(order + "B4i", 4, 0, 1, 2, 3) + struct.pack(order + "B3i", 3, 0, 2, 3)
        yield form + "_everything", ply_text(form, everything, body)
        small = ("element vertex 4\nproperty char x\nproperty uchar y\nproperty short z\n"
                 "property float s\nproperty float t\nproperty char nx\nproperty char ny\n"
                 "property char nz\nelement face 2\nproperty list char uchar vertex_index\n")
        body = b"".join(struct.pack(order + "bBh2f3b", *corner, 0, 1, 0, 0, 1)
                        for corner in CORNERS)
        yield form + "_small", ply_text(form, small, body + bytes([4, 0, 1, 2, 3, 3, 0, 2, 3]))
    yield "faces_first", ply_text("ascii", FACE + VERTEX, ("3 0 1 2\n3 0 2 3\n" + square).encode())
    for name, elements, body in (
            ("count_too_large", VERTEX.replace("4", "4000000000"), square),
            ("no_face", VERTEX, square), ("no_vertex", FACE, "3 0 1 2\n3 0 2 3\n"),
            ("vertex_twice", VERTEX + VERTEX, square + square),
            ("property_twice", VERTEX + "property float x\n" + FACE, square),
            ("no_x", VERTEX.replace(" x", " w") + FACE, square),
            ("no_list", VERTEX + "element face 2\nproperty int a\n", square),
            ("no_properties", "element vertex 4\n" + FACE, square),
            ("index_too_large", VERTEX + FACE, square + "3 0 1 9\n3 0 1 2\n"),
            ("five_corners", VERTEX + FACE, square + "5 0 1 2 3 0\n"),
            ("index_is_no_whole_number", VERTEX + FACE, square + "3 0 1 0.5\n"),
            ("cut_off", VERTEX + FACE, square + "3 0 1"),
            ("infinite", VERTEX + FACE, square.replace("1 1 0", "1e999 1 0")),
            ("not_a_number", VERTEX + FACE, square.replace("1 1 0", "x 1 0")),
            ("huge_list", VERTEX + "property list uint float o\n" + FACE, "0 0 0 4000000000 1\n")):
        yield name, ply_text("ascii", elements, body.encode())
    yield "no_ply", b"polygon\n"
    for name, line in (("no_format", "element vertex 1"), ("format_twice", "format ascii"),
                       ("unknown_format", "format text 1.0"), ("bad_count", "element vertex -1"),
                       ("bad_element", "element vertex"), ("early_property", "property float x"),
                       ("keyword", "colour red"), ("float_count", "element a 1\nproperty list float int b"),
                       ("unknown_type", "element a 1\nproperty real x"),
                       ("bad_property", "element a 1\nproperty float")):
        yield name, f"ply\n{line}\nend_header\n".encode()
    yield "no_end", b"ply\nformat ascii 1.0\n"


# ------------------------------------------------------------------------ photometric files

def ies_text(header="IESNA:LM-63-2002\n[TEST] made up\n", tilt="TILT=NONE\n", lamps="1 1000 1",
             counts="3 1", kind="1", units="2 0 0 0\n", ballast="1 1 10\n", angles="0 45 90\n0\n",
             candela="100 50 10\n"):
    return (header + tilt + lamps + " " + counts + " " + kind + " " + units + ballast + angles +
            candela).encode()


def ies():
    yield "downlight", (DATA / "lights/downlight.ies").read_bytes()
    for name, first in (("1986", ""), ("1991", "IESNA91\n"), ("1995", "IESNA:LM-63-1995\n"),
                        ("2002", "IESNA:LM-63-2002\n"), ("2019", "IES:LM-63-2019\n"),
                        ("unknown", "IES:LM-63-2050\n")):
        yield "edition_" + name, ies_text(header=first)
    yield "type_b", ies_text(kind="2", counts="3 3", angles="0 45 90\n-90 0 90\n",
                             candela="1 2 3\n4 5 6\n7 8 9\n")
    yield "type_a", ies_text(kind="3", counts="3 2", angles="-90,0,90\n0 90\n", candela="1 2 3\n4 5 6\n")
    yield "type_a_1986", ies_text(header="", counts="3 2", angles="-90 0 90\n0 90\n",
                                  candela="1 2 3\n4 5 6\n")
    yield "quadrants", ies_text(counts="3 2", angles="0 45 90\n0 90\n", candela="1 2 3\n4 5 6\n")
    yield "halves", ies_text(counts="2 3", angles="90 180\n90 180 270\n", candela="1 2 3 4 5 6\n")
    yield "absolute", ies_text(lamps="1 -1 1")
    yield "more_flux_than_lamps", ies_text(lamps="1 1 1")
    yield "tilt_include", ies_text(tilt="TILT=INCLUDE\n1\n3\n0 45 90\n1 .9 .8\n")
    yield "tilt_file", ies_text(tilt="tilt=other.tlt\n")
    yield "text_after", ies_text(candela="100 50 10\nmore\n")
    yield "cr_lines", ies_text().replace(b"\n", b"\r")
    yield "crlf_lines", ies_text().replace(b"\n", b"\r\n")
    yield "bom", b"\xef\xbb\xbf" + ies_text()
    for name, change in (
            ("no_tilt", dict(tilt="")), ("empty_tilt", dict(tilt="TILT=\n")),
            ("bad_tilt_angles", dict(tilt="TILT=INCLUDE\n1\n2\n10 45\n1 1\n")),
            ("bad_geometry", dict(tilt="TILT=INCLUDE\n9\n1\n0\n1\n")),
            ("too_many_angles", dict(counts="1000000000 1000000000")),
            ("one_angle", dict(counts="1 1")), ("half_a_count", dict(counts="2.5 1")),
            ("bad_type", dict(kind="4")), ("bad_lumens", dict(lamps="1 -2 1")),
            ("zero_multiplier", dict(lamps="1 1000 0")), ("word", dict(lamps="one 1000 1")),
            ("negative_candela", dict(candela="1 -2 3\n")), ("short", dict(candela="1 2\n")),
            ("not_ascending", dict(angles="0 45 40\n0\n")), ("bad_range", dict(angles="0 45 80\n0\n")),
            ("angle_400", dict(angles="0 45 400\n0\n")),
            ("bad_horizontal", dict(counts="3 2", angles="0 45 90\n0 50\n")),
            ("long_word", dict(lamps="x" * 60)), ("only_header", dict(lamps="", counts=""))):
        yield name, ies_text(**change)
    yield "empty", b"\n"


def ldt_text(symmetry=1, mc=1, ng=3, conversion="1", lorl="", sets="1",
             lamps=("1", "lamp", "2000", "3000", "80", "20"), c=("0",), gamma=("0", "45", "90"),
             values=("100", "50", "10"), end="\n"):
    lines = ["made up", "1", symmetry, mc, "0", ng, "0", "report", "name", "number", "file", "date",
             "100", "0", "50", "100", "0", "0", "0", "0", "0", "100", lorl, conversion, "0", sets,
             *lamps, *["0.5"] * 10, *c, *gamma, *values]
    return "".join(f"{line}{end}" for line in lines).encode()


def eulumdat():
    yield "sconce", (DATA / "lights/sconce.ldt").read_bytes()
    yield "symmetric", ldt_text()
    eight = [str(45 * i) for i in range(8)]
    for symmetry, planes in ((0, 8), (2, 5), (3, 5), (4, 3)):
        yield f"symmetry_{symmetry}", ldt_text(symmetry=symmetry, mc=8, ng=2, c=eight,
                                               gamma=("0", "180"), values=["10"] * (2 * planes))
    yield "closed_circle", ldt_text(symmetry=0, mc=3, ng=2, c=("0", "180", "360"),
                                    gamma=("0", "90"), values=["10"] * 6)
    by_field = ("1", "2", "a", "b", "1000", "2000", "3000", "4000", "80", "80", "10", "20")
    by_set = ("1", "a", "1000", "3000", "80", "10", "2", "b", "2000", "4000", "80", "20")
    numbers = tuple("1" for _ in by_set)
    for name, lamps in (("by_field", by_field), ("by_set", by_set), ("either", numbers),
                        ("neither", ("x",) * 12)):
        yield "sets_" + name, ldt_text(sets="2", lamps=lamps)
    yield "blank_conversion", ldt_text(conversion="")
    yield "output_ratio", ldt_text(lorl="50")
    yield "decimal_commas", ldt_text(gamma=("0", "45,5", "90"), values=("1,5", "2,5", "+3"))
    yield "absolute", ldt_text(lamps=("-1", "lamp", "2000", "3000", "80", "20"))
    yield "cr_lines", ldt_text(end="\r")
    yield "bom", b"\xef\xbb\xbf" + ldt_text(end="\r\n")
    for name, change in (
            ("bad_symmetry", dict(symmetry=5)), ("no_planes", dict(mc=0)), ("one_gamma", dict(ng=1)),
            ("odd_planes", dict(symmetry=4, mc=6)), ("too_many", dict(mc=1000000000, symmetry=0)),
            ("too_many_gammas", dict(ng=1000000000)), ("no_sets", dict(sets="0")),
            ("zero_flux", dict(lamps=("1", "lamp", "0", "", "", ""))),
            ("word", dict(values=("x", "1", "1"))), ("negative", dict(values=("-1", "1", "1"))),
            ("short", dict(values=("1",))), ("gamma_200", dict(gamma=("0", "45", "200"))),
            ("not_ascending", dict(gamma=("0", "45", "40"))), ("bad_c", dict(c=("x",))),
            ("bad_planes", dict(symmetry=0, mc=2, ng=2, c=("0", "10"), gamma=("0", "90"),
                                values=["1"] * 4)),
            ("bad_conversion", dict(conversion="-1")), ("bad_ratio", dict(lorl="-5"))):
        yield name, ldt_text(**change)
    yield "empty", b"\n"


# --------------------------------------------------------------------------------- pictures

def png(width, height, kind, depth, rows, interlace=0, extra=b""):
    def chunk(name, body):
        return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))
    return (b"\x89PNG\r\n\x1a\n" +
            chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, kind, 0, 0, interlace)) +
            extra + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def pfm(width, height, values, kind="PF", scale="-1.0"):
    return f"{kind}\n{width} {height}\n{scale}\n".encode() + struct.pack(f"<{len(values)}f", *values)


def hdr(width, height, body):
    return (b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n" + f"-Y {height} +X {width}\n".encode() + body)


def tiff(bits=8, samples=3, sample_format=1, orientation=1, tiled=False):
    texel = bytes(bits // 8 * samples)
    body = texel * 4
    tags = [(256, 3, 1, 2), (257, 3, 1, 2), (258, 3, 1, bits), (259, 3, 1, 1),
            (262, 3, 1, 2 if samples >= 3 else 1), (273, 4, 1, 8), (274, 3, 1, orientation),
            (277, 3, 1, samples), (278, 3, 1, 2), (279, 4, 1, len(body)), (339, 3, 1, sample_format)]
    ifd = struct.pack("<H", len(tags)) + b"".join(struct.pack("<HHII", *tag) for tag in tags)
    return struct.pack("<2sHI", b"II", 42, 8 + len(body)) + body + ifd + bytes(4)


def pictures():
    """(name, number of the ending, bytes); the endings are in picture_fuzz.cpp."""
    exr, radiance, portable, png_, tiff_, jpeg, gif = range(7)
    ref = DATA / "reference"
    yield "screen", exr, (ref / "screen.exr").read_bytes()
    yield "slide", exr, (ref / "slide.exr").read_bytes()
    for name in ("tiles", "bumps", "holes"):
        yield name, png_, (ref / f"{name}.png").read_bytes()
    for kind, channels in ((0, 1), (2, 3), (4, 2), (6, 4)):
        for depth in (8, 16):
            row = b"\0" + bytes(range(2 * channels * depth // 8))
            yield f"png_{channels}_{depth}", png_, png(2, 2, kind, depth, row * 2)
    yield "png_1_bit", png_, png(2, 2, 0, 1, b"\0\x80" * 2)
    yield "png_interlaced", png_, png(2, 2, 0, 8, b"\0\1\0\2\0\3\4", interlace=1)
    yield "png_huge", png_, png(100000, 100000, 0, 8, b"")
    yield "png_cut_off", png_, png(2, 2, 2, 8, b"\0" + bytes(6))
    yield "pfm", portable, pfm(2, 2, [0.5] * 12)
    yield "pfm_grey", portable, pfm(2, 2, [0.5] * 4, kind="Pf")
    yield "pfm_negative", portable, pfm(2, 2, [-1.0] * 12)
    yield "pfm_infinite", portable, pfm(2, 2, [float("inf")] * 12)
    yield "pfm_nan", portable, pfm(1, 1, [float("nan")] * 3)
    yield "pfm_cut_off", portable, pfm(2, 2, [0.5] * 5)
    yield "pfm_empty", portable, pfm(0, 0, [])
    yield "hdr", radiance, hdr(2, 2, bytes([128, 64, 32, 129]) * 4)
    yield "hdr_runs", radiance, hdr(8, 1, bytes([2, 2, 0, 8]) + bytes([136, 7]) * 4)
    yield "hdr_cut_off", radiance, hdr(8, 8, b"\2\2")
    for bits, samples, form in ((8, 3, 1), (16, 1, 1), (32, 3, 3), (32, 1, 1), (8, 4, 1), (8, 5, 1)):
        yield f"tiff_{bits}_{samples}_{form}", tiff_, tiff(bits, samples, form)
    yield "tiff_turned", tiff_, tiff(orientation=6)
    yield "jpeg_no_picture", jpeg, b"\xff\xd8\xff\xe0\0\x10JFIF\0"
    yield "gif", gif, b"GIF89a"
    yield "png_named_exr", exr, png(1, 1, 0, 8, b"\0\0")
    yield "text", png_, b"no picture"


def picture():
    for name, ending, content in pictures():
        yield name, bytes([ending]) + content


def texture():
    """Five bytes choose the parameters; see texture_fuzz.cpp."""
    ref = DATA / "reference"
    for i, name in enumerate(("tiles.png", "bumps.png", "holes.png")):
        for k in range(4):
            yield f"{name[:-4]}_{k}", bytes([k, (k + i) % 4, (k + 2 * i) % 4, k % 3, k % 2]) + (
                ref / name).read_bytes()
    yield "exr", bytes([0, 1, 0, 0, 2]) + (ref / "screen.exr").read_bytes()
    yield "pfm", bytes([1, 2, 1, 1, 4]) + pfm(2, 2, [0.25] * 12)


# ------------------------------------------------------------------------------------- glTF

def gltf():
    yield "room", joined("gltf/room.gltf", "room.bin")
    yield "blender_room", (DATA / "gltf/blender_room.glb").read_bytes()
    yield "empty", b'{"asset":{"version":"2.0"}}'
    yield "no_json", b"{"
    yield "glb_cut_off", b"glTF\2\0\0\0"


# ------------------------------------------------------------------- configuration and tokens

def config():
    yield "all", b"""# every setting
listen = "127.0.0.1:0"
insecure = true
tls-cert = "cert.pem"
tls-key = "key.pem"
tls-client-ca = "ca.pem"
token-file = "tokens.toml"
max-connections = 100
max-peer-connections = 10
max-streams = 100
idle-seconds = 60
handshake-seconds = 20
ping-seconds = 60
min-ping-seconds = 5
scene-root = "scenes"
load = ["a.pbrt", "b.pbrt"]
threads = 2
isa = "avx2"
memory-budget = "8GiB"
texture-memory = 1048576
max-scene-primitives = 1000
max-scene-bytes = "1MiB"
max-picture-texels = 1000
max-include-depth = 3
max-tokens = 1000
max-lease = 60.5
asset-dir = "assets"
asset-budget = "16 GiB"
max-asset-bytes = "4k"
upload-timeout = 60
keep-partial-uploads = 60
max-batch-items = 2048
max-tile-pixels = 1024
max-samples = 64
max-message-bytes = "2MiB"
interactive-queue = 10
bulk-queue = 10
max-call-seconds = 1.5
metrics = "127.0.0.1:9090"
log-format = "json"
log-level = "warning"
log-lines = 0
drain-seconds = 5
"""
    yield "wrong_types", b'listen = 3\ninsecure = "yes"\nload = "a"\nload = [1]\n'
    yield "wrong_types_2", (b'load = [1]\nthreads = 1.5\nisa = "none"\nmemory-budget = true\n'
                            b'max-lease = "x"\nmax-call-seconds = nan\nmetrics = 1979-05-27\n')
    yield "out_of_range", (b'threads = 5000\nmemory-budget = "99999999999GiB"\n'
                           b'max-batch-items = 3\nmax-call-seconds = -1.0\nmax-samples = -1\n'
                           b'asset-budget = "12 parsecs"\nmax-scene-bytes = ""\n')
    yield "unknown", b"queue = 3\n[table]\nthreads = 2\n"
    yield "syntax", b"threads = \n"
    yield "twice", b"threads = 1\nthreads = 2\n"
    yield "strings", b'scene-root = """\nscenes"""\nasset-dir = \'C:\\x\'\nlisten = "\\u0041\\n"\n'
    yield "empty", b""


def token_file():
    digest = hashlib.sha256(b"a token of an example").hexdigest()
    yield "two", (f'[[token]]\nname = "render-farm"\nsha256 = "{digest}"\n'
                  'roles = ["query", "load"]\nmax-requests = 16\nmax-leases = 2\nmax-scenes = 3\n\n'
                  '[[token]]\nname = "admin.1_x"\ntoken = "0123456789abcdef"\n'
                  'roles = ["admin"]\n').encode()
    head = '[[token]]\nname = "a"\n'
    for name, text in (
            ("none", ""), ("no_name", f'[[token]]\nsha256 = "{digest}"\nroles = ["query"]\n'),
            ("no_secret", head + 'roles = ["query"]\n'),
            ("no_roles", head + f'sha256 = "{digest}"\n'),
            ("both", head + f'sha256 = "{digest}"\ntoken = "0123456789abcdef"\nroles = ["load"]\n'),
            ("short", head + 'token = "short"\nroles = ["load"]\n'),
            ("bad_digest", head + 'sha256 = "zz"\nroles = ["load"]\n'),
            ("odd_digest", head + f'sha256 = "{digest[:-1]}"\nroles = ["load"]\n'),
            ("bad_role", head + 'token = "0123456789abcdef"\nroles = ["root"]\n'),
            ("roles_text", head + 'token = "0123456789abcdef"\nroles = "query"\n'),
            ("bad_number", head + 'token = "0123456789abcdef"\nroles = ["load"]\nmax-leases = -1\n'),
            ("bad_name", '[[token]]\nname = "a b"\ntoken = "0123456789abcdef"\nroles = ["load"]\n'),
            ("unknown_key", head + 'colour = "red"\n'), ("other_table", "[token]\nname = 1\n"),
            ("list", "token = [1, 2]\n"), ("syntax", "[[token]\n"),
            ("twice", (head + 'token = "0123456789abcdef"\nroles = ["load"]\n') * 2)):
        yield name, text.encode()


# --------------------------------------------------------------------------------- requests

ASSET = b'WorldBegin LightSource "point"\n'  # as in request_fuzz.cpp


def escaped(content):
    return "".join(f"\\{byte:03o}" for byte in content)


POINT = "origin_m { x: 100 y: -50 z: 0.5 } offsets_m: [0, 0, 0]"
POINTS = "origin_m { x: 100 y: -50 z: 0.5 } offsets_m: [0, 0, 0, 1, 1, 0.5]"
SCENE = 'scene_id: "S" '
ACCURACIES = {
    "samples": "accuracy { samples: 4 }",
    "target": "accuracy { target_error { relative: 0.1 absolute_floor: 1 confidence: 0.9 "
              "max_samples: 16 } }",
    "budget": "accuracy { time_budget_s: 0.001 }",
    "methods": "accuracy { samples: 2 area_sampling: AREA_SAMPLING_COSINE_SOLID_ANGLE "
               "light_selection: LIGHT_SELECTION_BVH samples_per_light: 2 far_light_radii: 3 "
               "sampler: SAMPLER_INDEPENDENT combination: COMBINATION_BALANCE_HEURISTIC }",
    "approximations": "accuracy { samples: 2 closed_forms: CLOSED_FORMS_EMPTY_SHAFTS "
                      "visibility: VISIBILITY_RAYS thin_glass: THIN_GLASS_BLOCKS }",
    "shadow_maps": "accuracy { samples: 2 visibility: VISIBILITY_SHADOW_MAPS }",
    "bad": "accuracy { samples: 0 light_selection: 77 }",
    "bad_target": "accuracy { target_error { relative: -1 } }",
    "bad_methods": "accuracy { samples: 3 samples_per_light: 0 far_light_radii: -1 area_sampling: 99 "
                   "sampler: 99 combination: 99 closed_forms: 99 visibility: 99 thin_glass: 99 }",
}
WAVELENGTHS = "wavelengths_nm: [450, 550.5]"
RGB = "{ r: 1 g: 2 b: 3 }"
LIGHTS = {
    "point": f"point {{ position_m {{ x: 100 y: -50 z: 2 }} intensity_cd {RGB} }}",
    "spot": f"spot {{ position_m {{ x: 100 y: -50 z: 2 }} axis {{ z: -1 }} intensity_cd {RGB} "
            "cone_half_angle_rad: 0.5 falloff_start_rad: 0.4 profile: SPOT_PROFILE_QUARTIC }",
    "bad_spot": "spot { cone_half_angle_rad: 9 profile: 9 }",
    "distant": f"distant {{ to_light {{ z: 1 }} illuminance_lx {RGB} }}",
    "sun": f"sun {{ to_light {{ z: 1 }} angular_diameter_rad: 0.1 illuminance_lx {RGB} }}",
    "disk": f"diffuse_area {{ radiance_cd_m2 {RGB} two_sided: true shape: AREA_SHAPE_DISK round {{ "
            "center_m { x: 100 y: -50 z: 2 } axes { x { x: 1 } y { y: 1 } z { z: 1 } } radius_m: 1 "
            "phi_max_rad: 6.2 } }",
    "quad": f"diffuse_area {{ radiance_cd_m2 {RGB} shape: AREA_SHAPE_BILINEAR_MESH "
            "corners_m { } corners_m { x: 1 } corners_m { y: 1 } corners_m { x: 1 y: 1 } }",
    "uniform": f"uniform_infinite {{ radiance_cd_m2 {RGB} }}",
    "none": "",
}


def messages():
    """(call, name, message in text form) for protoc."""
    yield "FindMissingAssets", "one", f'sha256: "{escaped(hashlib.sha256(ASSET).digest())}" sha256: "x"'
    yield "FindMissingAssets", "held", f'sha256: "{escaped(hashlib.sha256(ASSET).digest())}" sha256: "{escaped(bytes(32))}"'
    digest = escaped(hashlib.sha256(ASSET).digest())
    manifest = f'manifest {{ main: "a.pbrt" assets {{ name: "a.pbrt" sha256: "{digest}" size_bytes: {len(ASSET)} }} }}'
    for name, text in (
            ("path", 'path: "lights/every_light.pbrt" lease_s: 5'), ("manifest", manifest),
            ("small", 'path: "pbrt/parts.pbrt"'),
            ("gltf", 'path: "gltf/room.gltf" blender { mode: BLENDER_LIGHTING_MODE_STANDARD }'),
            ("gltf_unitless", 'path: "gltf/room.gltf" blender { mode: BLENDER_LIGHTING_MODE_UNITLESS lumens_per_watt: 100 }'),
            ("gltf_raw", 'path: "gltf/room.gltf" blender { mode: BLENDER_LIGHTING_MODE_RAW }'),
            ("bad_mode", 'path: "gltf/room.gltf" blender { mode: 9 }'),
            ("bad_blender", 'path: "a.pbrt" blender { mode: 1 }'),
            ("bad_watts", 'path: "gltf/room.gltf" blender { mode: 1 lumens_per_watt: -1 }'),
            ("missing", f'manifest {{ main: "a.pbrt" assets {{ name: "a.pbrt" sha256: "{escaped(bytes(32))}" }} }}'),
            ("no_main", f'manifest {{ main: "b.pbrt" assets {{ name: "a.pbrt" sha256: "{digest}" }} }}'),
            ("bad_name", 'manifest { main: "../a" assets { name: "../a" } }'),
            ("twice", f'manifest {{ main: "a" assets {{ name: "a" sha256: "{digest}" }} assets {{ name: "a" sha256: "{digest}" }} }}'),
            ("bad_digest", 'manifest { main: "a" assets { name: "a" sha256: "x" } }'),
            ("nothing", ""), ("not_found", 'path: "no.pbrt"'), ("absolute", 'path: "/etc/passwd"'),
            ("bad_lease", 'path: "pbrt/parts.pbrt" lease_s: nan'),
            ("edited", 'path: "lights/every_light.pbrt" edits { change { light_id: 1 scale: 0.5 } }'),
            ("edited_remove", manifest + ' edits { remove: 1 } edits { remove: 1 }')):
        yield "LoadScene", name, text
    for call in ("GetScene", "ListLights", "ReleaseScene", "RenewLease"):
        yield call, "scene", SCENE
        yield call, "unknown", 'scene_id: "no"'
    for call in ("ListScenes", "ListAvailableScenes", "ListLeases"):
        yield call, "page", "page_size: 2"
        yield call, "token", 'page_size: 2 page_token: "a"'
        yield call, "all", ""
    yield "ListLights", "page", SCENE + 'page_size: 3 page_token: "2"'
    yield "ListLights", "bad_page", SCENE + 'page_token: "x"'
    yield "RenewLease", "renew", SCENE + 'lease_s: 9 lease_id: "L"'
    yield "RenewLease", "bad", SCENE + 'lease_s: -1'
    yield "ReleaseScene", "lease", SCENE + 'lease_id: "L"'
    yield "ReleaseScene", "break", SCENE + "break_leases: true"
    for name, light in LIGHTS.items():
        yield "EditLights", "put_" + name, SCENE + f'edits {{ put {{ name: "new" {light} }} }}'
        yield "EditLights", "replace_" + name, SCENE + f"edits {{ put {{ id: 1 {light} }} }}"
    placement = "placement { shift_m { x: 1 } turn_axis { z: 1 } turn_rad: 0.5 }"
    for name, text in (
            ("remove", "edits { remove: 1 }"), ("remove_unknown", "edits { remove: 999 }"),
            ("dim", "edits { change { light_id: 1 scale: 0.5 tint { r: 1 g: 0.5 b: 0.1 } on: false } }"),
            ("move", f"edits {{ change {{ light_id: 1 {placement} }} }}"),
            ("move_surface", f"edits {{ change {{ light_id: 28 {placement} }} }}"),
            ("move_nothing", "edits { change { light_id: 1 placement { turn_rad: 1 } } }"),
            ("bad_change", "edits { change { light_id: 1 scale: -1 tint { r: nan } } }"),
            ("add", 'edits { add { path: "pbrt/parts.pbrt" } }'),
            ("add_lights", f'edits {{ add {{ {manifest} }} }}'),
            ("add_nothing", "edits { add { } }"), ("nothing", "edits { }"), ("none", "lease_s: 3"),
            ("bad_lease", "edits { remove: 1 } lease_s: -3")):
        yield "EditLights", name, SCENE + text
    receivers = f"receivers {{ {POINTS} }} "
    for name, text in ACCURACIES.items():
        for call, rest in (
                ("SampleLi", receivers + "seed { seed: 3 } test_visibility: true " + WAVELENGTHS),
                ("EstimateIrradiance", receivers + "normals: [0, 0, 1, 0, 0, 1] bounces: 1 "),
                ("EstimatePower", "method: METHOD_SAMPLED "),
                ("RenderTile", "rect { x0: 4 y0: 4 x1: 8 y1: 6 } bounces: 1 "),
                ("RenderImage", "bounces: 0 tile_size: 8 "),
                ("TestVisibility", f"segments {{ from {{ {POINT} }} to {{ origin_m {{ x: 100 y: -50 z: 3 }} offsets_m: [0, 0, 0] }} }} "),
                ("SampleLe", "count: 3 seed { } "), ("PdfLi", receivers + "wi: [0, 0, 1, 0, 0, 1] light_id: 3 "),
                ("PdfLe", f"light_id: 1 points {{ {POINT} }} directions: [0, 0, -1] "),
                ("Le", f"points {{ {POINT} }} directions: [0, 0, 1] ")):
            yield call, "accuracy_" + name, SCENE + rest + text
    for name, text in (
            ("light", receivers + "light_id: 2 seed { seed: 1 first_item: 5 }"),
            ("every", receivers + "u { u: [0.1, 0.2, 0.3, 0.4] u_light: [0.5, 0.6] }"),
            ("normals", receivers + "seed { } normals: [0, 0, 1, 0, 1, 0] position_error_m: 0.001 time_s: 0.5"),
            ("named", receivers + 'seed { } light_name: "lamp"'),
            ("bad_u", receivers + "u { u: [0.1, 2] }"), ("no_seed", receivers),
            ("bad_points", "receivers { offsets_m: [1, 2] } seed { }"),
            ("nan", "receivers { origin_m { x: nan } offsets_m: [nan, inf, 3e38] } seed { }"),
            ("far", "receivers { origin_m { x: 1e300 } offsets_m: [0, 0, 0] } seed { }"),
            ("no_light", receivers + "light_id: 999 seed { }"),
            ("bad_normals", receivers + "seed { } normals: [1, 2]"),
            ("bad_wavelengths", receivers + "seed { } wavelengths_nm: [1e9]"),
            ("many", "receivers { offsets_m: [" + ", ".join(["0"] * 300) + "] } seed { }")):
        yield "SampleLi", name, SCENE + text
    yield "SampleLe", "values", SCENE + "light_id: 1 count: 2 u { u: [" + ", ".join(["0.5"] * 8) + "] u_light: [0.1, 0.2] } " + WAVELENGTHS
    yield "SampleLe", "too_many", SCENE + "count: 100000 seed { }"
    yield "Le", "light", SCENE + f"points {{ {POINTS} }} directions: [0, 0, 1, 1, 0, 0] light_id: 30 {WAVELENGTHS}"
    yield "Le", "bad_directions", SCENE + f"points {{ {POINTS} }} directions: [0, 0, 0, 1, 0, nan]"
    yield "PdfLi", "bad", SCENE + receivers + "wi: [0] light_id: 3"
    yield "PdfLe", "bad", SCENE + f'points {{ {POINT} }} directions: [0, 2, 0] light_name: "x"'
    for method in ("EXACT", "APPROXIMATE", "UNSPECIFIED"):
        yield "EstimatePower", method.lower(), SCENE + f"method: METHOD_{method} {WAVELENGTHS}"
    yield "EstimatePower", "some", SCENE + "light_ids: [1, 20, 30] method: METHOD_SAMPLED seed: 3 accuracy { samples: 8 }"
    yield "EstimatePower", "page", SCENE + "method: METHOD_EXACT page_size: 4"
    yield "EstimatePower", "bad", SCENE + 'light_ids: [999] light_names: "x" method: 9 page_token: "z"'
    yield "TestVisibility", "rays", SCENE + f"rays {{ from {{ {POINT} }} directions: [0, 0, 1] lengths_m: [2] }} normals: [0, 0, 1] time_s: 1"
    yield "TestVisibility", "bad_rays", SCENE + f"rays {{ from {{ {POINT} }} directions: [0, 0] lengths_m: [-2] }}"
    yield "TestVisibility", "nothing", SCENE
    yield "EstimateIrradiance", "per_light", SCENE + receivers + "normals: [0, 0, 1, 0, 0, 1] per_light: true accuracy { samples: 2 } " + WAVELENGTHS
    yield "EstimateIrradiance", "bad", SCENE + receivers + "normals: [0, 0, 0] bounces: 9999"
    yield "RenderTile", "intervals", SCENE + "rect { x1: 2 y1: 2 } intervals: true accuracy { samples: 8 } samples_per_block: 4 first_sample: 4 time_s: 0.5"
    yield "RenderTile", "shutter", SCENE + "rect { x1: 2 y1: 2 } accuracy { samples: 1 } shutter { offset_s: 1 length_s: 2 }"
    for name, text in (("empty", ""), ("outside", "rect { x0: 90 y0: 90 x1: 99 y1: 99 }"),
                       ("too_large", "rect { x1: 32 y1: 24 }"), ("turned", "rect { x0: 5 y1: 3 }"),
                       ("first", "rect { x1: 1 y1: 1 } first_sample: 3 samples_per_block: 2"),
                       ("shutter_bad", "rect { x1: 1 y1: 1 } shutter { length_s: -1 }")):
        yield "RenderTile", name, SCENE + text
    yield "RenderImage", "final", SCENE + "final_only: true intervals: true tile_size: 8 accuracy { samples: 2 } time_s: 0.5"
    yield "RenderImage", "bad", SCENE + "tile_size: 0 samples_per_block: 3"
    yield "GetServerInfo", "empty", ""
    yield "GetStats", "empty", ""


CALLS = ("FindMissingAssets UploadAsset LoadScene GetScene ListScenes ListAvailableScenes ListLights "
         "EditLights RenewLease ReleaseScene SampleLi PdfLi SampleLe PdfLe Le EstimatePower "
         "TestVisibility EstimateIrradiance RenderTile RenderImage GetServerInfo GetStats "
         "ListLeases").split()  # in the order of monitor::Call


def request():
    with tempfile.TemporaryDirectory() as made:
        files = sorted(str(path) for path in (PROTO / "lucerna/v1").glob("*.proto"))
        subprocess.run(["protoc", f"-I{PROTO}", f"--python_out={made}", *files], check=True)
        sys.path.insert(0, made)
        from google.protobuf import text_format
        from lucerna.v1 import admin_pb2, lighting_pb2, render_pb2, scene_pb2
        modules = (scene_pb2, lighting_pb2, render_pb2, admin_pb2)

        def encoded(kind, text):
            module = next(m for m in modules if hasattr(m, kind))
            message = getattr(module, kind)()
            text_format.Parse(text, message)
            return message.SerializeToString(deterministic=True)

        for call, name, text in messages():
            yield f"{call}_{name}", bytes([CALLS.index(call)]) + encoded(call + "Request", text)
        content = b"WorldBegin\n"
        digest = escaped(hashlib.sha256(content).digest())
        uploads = {
            "whole": [f'header {{ sha256: "{digest}" size_bytes: {len(content)} }}',
                      f'chunk: "{escaped(content)}"'],
            "part": [f'header {{ sha256: "{digest}" size_bytes: 90 }}', 'chunk: "ab"'],
            "held": [f'header {{ sha256: "{escaped(hashlib.sha256(ASSET).digest())}" size_bytes: 31 }}'],
            "bad_digest": ['header { sha256: "x" }'], "no_header": ['chunk: "a"'],
            "two_headers": [f'header {{ sha256: "{digest}" size_bytes: 50 }}'] * 2,
            "too_much": [f'header {{ sha256: "{digest}" size_bytes: 1 }}', 'chunk: "abc"'],
            "too_large": [f'header {{ sha256: "{digest}" size_bytes: 999999 }}'],
            "bad_offset": [f'header {{ sha256: "{digest}" size_bytes: 9 offset_bytes: 99 }}'],
            "other_bytes": [f'header {{ sha256: "{digest}" size_bytes: 3 }}', 'chunk: "abc"'],
            "none": [],
        }
        for name, parts in uploads.items():
            body = b""
            for part in parts:
                message = encoded("UploadAssetRequest", part)
                body += bytes([len(message)]) + message
            yield "UploadAsset_" + name, bytes([CALLS.index("UploadAsset")]) + body
        yield "malformed", bytes([CALLS.index("SampleLi")]) + b"\xff\xff\xff"


SEEDS = {"pbrt_fuzz": pbrt, "ply_fuzz": ply, "ies_fuzz": ies, "eulumdat_fuzz": eulumdat,
         "picture_fuzz": picture, "texture_fuzz": texture, "gltf_fuzz": gltf,
         "config_fuzz": config, "token_file_fuzz": token_file, "request_fuzz": request}


def main():
    check = "--check" in sys.argv[1:]
    wrong = []
    for target, seeds in SEEDS.items():
        folder = CORPUS / target
        folder.mkdir(parents=True, exist_ok=True)
        made = dict(seeds())
        for path in folder.iterdir():
            if not path.name.startswith(("found_", "grown_")) and path.name not in made:
                wrong.append(f"{path}: no seed of this name")
        for name, content in made.items():
            path = folder / name
            if check:
                if not path.exists() or path.read_bytes() != content:
                    wrong.append(f"{path}: differs from the seed")
            else:
                path.write_bytes(content)
    for line in wrong:
        print(line)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
