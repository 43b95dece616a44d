#!/usr/bin/python3
"""Writes the data of the Cornell box: the colours of its surfaces and its lamp, and the points to measure at.

The spectra are those measured at Cornell ("Cornell Box Data", 1998, https://www.graphics.cornell.edu/online/box/data.html).
RGB: linear Rec. 709 of what a surface shows in D65, whose own is 1 1 1; beyond 400 to 700 nm as at the ends.  The lamp's
spectrum is multiplied with the observer as it is, and scaled to the flux.  Debian packages: those of modelling.py, colord-data.
"""
import math
import pathlib
import sys

import numpy as np

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import modelling

# At 400, 404, ... 700 nm, in thousandths.
WHITE = """343 445 551 624 665 687 708 723 715 710 745 758 739 767 777 765 751 745 748 729 745 757 753 750 746 747
735 732 739 734 725 721 733 725 732 743 744 748 728 716 733 726 713 740 754 764 752 736 734 741 740 732 745 755 751 744
731 733 744 731 712 708 729 730 727 707 703 729 750 760 751 739 724 730 740 737"""
GREEN = """92 96 98 97 98 95 95 97 95 94 97 98 96 101 103 104 107 109 112 115 125 140 160 187 229 285 343 390 435 464
472 476 481 462 447 441 426 406 373 347 337 314 285 277 266 250 230 207 186 171 160 148 141 136 130 126 123 121 122 119
114 115 117 117 118 120 122 128 132 139 144 146 150 152 157 159"""
RED = """40 46 48 53 49 50 53 55 57 56 59 57 61 61 60 62 62 62 61 62 60 59 57 58 58 58 56 55 56 59 57 55 59 59 58 59 61
61 63 63 67 68 72 80 90 99 124 154 192 255 287 349 402 443 487 513 558 584 620 606 609 651 612 610 650 638 627 620 630
628 642 639 657 639 635 642"""
LAMP = ((400, 500, 600, 700), (0, 8, 15.6, 18.4))
LAMP_LM = 600
LAMP_M2 = 0.130 * 0.105

COLORD = "/usr/share/colord/"
RGB_FROM_XYZ = np.linalg.inv(
    [
        [0.4123907992659595, 0.357584339383878, 0.1804807884018343],
        [0.2126390058715104, 0.7151686787677559, 0.0721923153607337],
        [0.0193308187155918, 0.119194779794626, 0.9505321522496607],
    ]
)
WHITE_XYZ = np.array([0.9504559270516718, 1, 1.0890577507598784])  # of RGB 1 1 1
NM = np.arange(360, 831, 5)


def rows(path):
    lines = [line.rstrip() for line in open(COLORD + path)]
    data = lines[lines.index("BEGIN_DATA") + 1 : lines.index("END_DATA")]
    return np.array([[float(x) for x in line.split()] for line in data])


def make():
    observer = rows("cmf/CIE1931-2deg-XYZ.cmf")  # at NM
    d65 = rows("illuminant/CIE-D65.sp")[0][12:107]  # the table begins at 300 nm
    white = observer @ d65

    def rgb(xyz):
        return RGB_FROM_XYZ @ xyz

    text = "# Made by make.py: linear RGB of the measured spectra.\n"
    for name, spectrum in (("white", WHITE), ("green", GREEN), ("red", RED)):
        reflectance = np.interp(NM, np.arange(400, 701, 4), np.array(spectrum.split(), float) / 1000)
        colour = rgb(observer @ (d65 * reflectance) / white * WHITE_XYZ)
        text += f'MakeNamedMaterial "{name}" "string type" "diffuse" "rgb reflectance" [{modelling.numbers(colour)}]\n'
    lamp = observer @ np.interp(NM, *LAMP)
    colour = rgb(lamp / lamp[1])
    level = LAMP_LM / (math.pi * LAMP_M2)
    files = {
        "surfaces.pbrt": text.encode(),
        "lamp.pbrt": (
            f"# Made by make.py: {LAMP_LM} lm of the measured spectrum.\n"
            f'AreaLightSource "diffuse" "rgb L" [{modelling.numbers(colour * level, 100)}]\n'
        ).encode(),
    }
    steps = [(i + 0.5) / 12 for i in range(12)]
    depth, height, width = 0.5592, 0.5488, 0.5496
    floor = [(u * width, 0, v * depth, 0, 1, 0) for u in steps for v in steps]
    back = [(u * width, v * height, depth, 0, 0, -1) for u in steps for v in steps]
    green = [(0, v * height, u * depth, 1, 0, 0) for u in steps for v in steps]
    files["points.csv"] = modelling.csv(p for p in floor + back + green if not within_a_block(p))
    return files


def within_a_block(p):
    """Whether the point of a wall or the floor is under one of the blocks."""
    blocks = (
        ((0.130, 0.065), (0.082, 0.225), (0.240, 0.272), (0.290, 0.114)),
        ((0.423, 0.247), (0.265, 0.296), (0.314, 0.456), (0.472, 0.406)),
    )
    x, y, z = p[:3]

    def left_of(a, b):
        return (b[0] - a[0]) * (z - a[1]) - (b[1] - a[1]) * (x - a[0])

    sides = ([left_of(a, b) for a, b in zip(block, block[1:] + block[:1])] for block in blocks)
    return y == 0 and any(all(s <= 0 for s in side) or all(s >= 0 for s in side) for side in sides)


if __name__ == "__main__":
    modelling.main(__file__, make)
