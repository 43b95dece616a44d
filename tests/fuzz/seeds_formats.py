"""Seeds: meshes, photometric files and pictures."""
import pathlib
import struct
import zlib

DATA = pathlib.Path(__file__).resolve().parent.parent / "data"


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


def png(width, height, kind, depth, rows, interlace=0, extra=b""):
    def chunk(name, body):
        return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))
    return (b"\x89PNG\r\n\x1a\n" +
            chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, kind, 0, 0, interlace)) +
            extra + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def pfm(width, height, values, kind="PF", scale="-1.0"):
    return f"{kind}\n{width} {height}\n{scale}\n".encode() + struct.pack(f"<{len(values)}f", *values)


def hdr(width, height, body, lines="FORMAT=32-bit_rle_rgbe\n", axes="-Y {} +X {}"):
    return f"#?RADIANCE\n{lines}\n{axes.format(height, width)}\n".encode() + body


def tga(kind, bits, body, palette=(0, 0, 0), name=b"", descriptor=0, size=(2, 2), footer=False):
    first, entries, entry_bits = palette
    return (struct.pack("<BBBHHBHHHHBB", len(name), entries > 0, kind, first, entries, entry_bits, 0, 0, *size,
                        bits, descriptor) + name + body +
            (bytes(8) + b"TRUEVISION-XFILE.\0" if footer else b""))


def bmp(bits, body, compression=0, before=b"", size=(2, 2), core=False):
    head = (struct.pack("<IHHHH", 12, *size, 1, bits) if core else
            struct.pack("<IiiHHI", 40, *size, 1, bits, compression) + bytes(20))
    return b"BM" + bytes(8) + struct.pack("<I", 14 + len(head) + len(before)) + head + before + body


def qoi(body, size=(2, 2), channels=3, space=0):
    return b"qoif" + struct.pack(">IIBB", *size, channels, space) + body + bytes(7) + b"\1"


def exr(channels, windows=((0, 0, 1, 1), (0, 0, 1, 1)), extra=()):
    """Half floats without compression; `extra`: (name, type, bytes)."""
    data, display = windows
    names = sorted(channels)
    listed = b"".join(n.encode() + b"\0" + struct.pack("<IIII", 1, 0, 1, 1) for n in names) + b"\0"
    attributes = [("channels", "chlist", listed), ("compression", "compression", b"\0"),
                  ("dataWindow", "box2i", struct.pack("<4i", *data)),
                  ("displayWindow", "box2i", struct.pack("<4i", *display)),
                  ("lineOrder", "lineOrder", b"\0"), ("pixelAspectRatio", "float", struct.pack("<f", 1)),
                  ("screenWindowCenter", "v2f", bytes(8)), ("screenWindowWidth", "float", struct.pack("<f", 1)),
                  *extra]
    head = b"\x76\x2f\x31\x01" + struct.pack("<I", 2)
    for name, kind, value in attributes:
        head += name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<I", len(value)) + value
    head += b"\0"
    width, height = data[2] - data[0] + 1, data[3] - data[1] + 1
    row = 2 * width * len(names)
    rows = b"".join(struct.pack("<iI", data[1] + y, row) + b"\0\x38" * (row // 2) for y in range(height))
    first = len(head) + 8 * height
    return head + b"".join(struct.pack("<Q", first + y * (8 + row)) for y in range(height)) + rows


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
    exr_, radiance, portable, png_, tiff_, jpeg, gif, tga_ = range(8)
    ref = DATA / "reference"
    yield "screen", exr_, (ref / "screen.exr").read_bytes()
    yield "slide", exr_, (ref / "slide.exr").read_bytes()
    rec2020 = struct.pack("<8f", .708, .292, .170, .797, .131, .046, .3127, .3290)
    yield "exr_colours", exr_, exr("RGB", extra=(("chromaticities", "chromaticities", rec2020),
                                                 ("whiteLuminance", "float", struct.pack("<f", 80))))
    yield "exr_no_space", exr_, exr("RGB", extra=(("chromaticities", "chromaticities", bytes(32)),))
    yield "exr_window", exr_, exr("RGB", windows=((-1, 0, 1, 1), (0, -1, 2, 2)))
    yield "exr_large_display", exr_, exr("RGB", windows=((0, 0, 0, 0), (-2 ** 31, 0, 2 ** 31 - 1, 9)))
    yield "exr_layers", exr_, exr(["a.R", "a.G", "a.B", "a.A", "b.r", "b.g", "b.b"])
    yield "exr_normals", exr_, exr(["n.x", "n.y", "n.z"])
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
    texels = bytes([128, 64, 32, 129]) * 4
    yield "hdr_lines", radiance, hdr(2, 2, texels, "EXPOSURE=2\nCOLORCORR=1 2 3\nEXPOSURE= 1e-3\n"
                                     "\tEXPOSURE=9\nPRIMARIES=.708 .292 .17 .797 .131 .046 .3127 .329\n")
    yield "hdr_xyze", radiance, hdr(2, 2, texels, "FORMAT=32-bit_rle_xyze\r\n", axes="+X {} -Y {}\r")
    yield "hdr_old_runs", radiance, hdr(261, 1, bytes([8, 7, 6, 129, 1, 1, 1, 4, 1, 1, 1, 1]))
    for name, lines in (("format", "FORMAT=ascii\n"), ("exposure", "EXPOSURE=0\n"),
                        ("correction", "COLORCORR=1 2\n"), ("primaries", "PRIMARIES=1 2\n")):
        yield "hdr_bad_" + name, radiance, hdr(2, 2, texels, lines)
    yield "hdr_bad_axes", radiance, hdr(2, 2, texels, axes="-Y {} -Y {}")
    yield "hdr_bad_run", radiance, hdr(2, 2, bytes([1, 1, 1, 9]))
    yield "hdr_bad_row", radiance, hdr(8, 1, bytes([2, 2, 0, 9]))
    yield "hdr_bad_count", radiance, hdr(8, 1, bytes([2, 2, 0, 8, 255, 1]))
    yield "tga_24", tga_, tga(2, 24, bytes(range(12)), descriptor=0x20)
    yield "tga_32_runs", tga_, tga(10, 32, b"\x81\1\2\3\4\1\1\2\3\4\5\6\7\x08", descriptor=0x18)
    yield "tga_16", tga_, tga(2, 16, bytes(range(8)), name=b"name", footer=True)
    yield "tga_named_png", png_, tga(3, 16, bytes(range(8)), footer=True)
    yield "tga_palette", tga_, tga(1, 8, bytes(range(9)) + b"\5\6\7\xff", palette=(5, 3, 24))
    yield "tga_palette_cut_off", tga_, tga(9, 8, b"\1", palette=(0, 3, 32))
    yield "tga_bad_type", tga_, tga(32, 24, bytes(12))
    yield "tga_bad_bits", tga_, tga(2, 8, bytes(12))
    yield "tga_huge", tga_, tga(2, 24, b"", size=(65535, 65535))
    yield "tga_cut_off", tga_, tga(10, 24, b"\xff\1")
    colours = bytes(range(8))
    yield "bmp_1", gif, bmp(1, b"\x80\0\0\0" * 2, before=colours)
    yield "bmp_4_runs", gif, bmp(4, b"\2\x12\0\0\0\3\x12\x30\0\2\1\0\0\1", 2, before=bytes(range(64)))
    yield "bmp_8_runs", gif, bmp(8, b"\2\1\0\0\0\3\1\2\3\0\0\1", 1, before=bytes(1024))
    yield "bmp_16_masks", gif, bmp(16, bytes(8), 3, before=struct.pack("<3I", 0xf800, 0x7e0, 0x1f))
    yield "bmp_24", gif, bmp(24, bytes(range(16)), size=(2, -2))
    yield "bmp_24_core", gif, bmp(24, bytes(range(16)), core=True)
    yield "bmp_32_masks", gif, bmp(32, bytes(range(16)), 6,
                                   before=struct.pack("<4I", 0xff, 0xff00, 0xff0000, 0xff000000))
    yield "bmp_bad_mask", gif, bmp(16, bytes(8), 3, before=struct.pack("<3I", 5, 0, 0))
    yield "bmp_bad_bits", gif, bmp(7, bytes(8))
    yield "bmp_cut_off", gif, bmp(8, b"\0\9", 1, before=bytes(1024))
    yield "bmp_header_only", gif, b"BM" + bytes(20)
    yield "qoi", gif, qoi(b"\xfe\1\2\3\x5a\x8a\x77\xff\1\2\3\4")
    yield "qoi_runs", gif, qoi(b"\xc1\x0a\xc9", channels=4, space=1)
    yield "qoi_bad_header", gif, qoi(b"", channels=7)
    yield "qoi_cut_off", gif, b"qoif" + struct.pack(">IIBB", 9, 9, 3, 0) + b"\xfe\1"
    webp = (DATA / "pictures" / "red.webp").read_bytes()
    yield "webp", gif, webp
    yield "webp_cut_off", gif, webp[:-2]
    yield "webp_canvas", gif, b"RIFF\x28\0\0\0WEBPVP8X\x0a\0\0\0" + bytes(4) + b"\xff" * 6 + bytes(20)
    yield "pgm", portable, b"P5 2 2 255 " + bytes(range(4))
    yield "ppm_text", portable, b"P3\n2 1\n255\n1 2 3 4 5 6\n"
    yield "png_gamma", png_, png(2, 2, 2, 8, (b"\0" + bytes(6)) * 2, extra=struct.pack(
        ">I4sII", 4, b"gAMA", 100000, zlib.crc32(b"gAMA" + struct.pack(">I", 100000))))
    for bits, samples, form in ((8, 3, 1), (16, 1, 1), (32, 3, 3), (32, 1, 1), (8, 4, 1), (8, 5, 1)):
        yield f"tiff_{bits}_{samples}_{form}", tiff_, tiff(bits, samples, form)
    yield "tiff_turned", tiff_, tiff(orientation=6)
    yield "jpeg_no_picture", jpeg, b"\xff\xd8\xff\xe0\0\x10JFIF\0"
    yield "gif", gif, b"GIF89a"
    yield "png_named_exr", exr_, png(1, 1, 0, 8, b"\0\0")
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
