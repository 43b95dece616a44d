#!/usr/bin/python3
"""Writes lights/maths/rgb_basis.h: three smooth reflectances that turn D65 into light of any RGB colour.

Debian packages: python3-numpy, python3-scipy, colord-data.  Usage: generate_rgb_basis.py > rgb_basis.h

The quadratic programme, after the idea of [Mallett19]: rho_r, rho_g, rho_b, at the 95 wavelengths of the CIE 1931
table, with the least sum of squared differences between neighbours, such that
  rho_r + rho_g + rho_b = 1,  each >= 0,
  5 nm sum of rho_i D65 observer / 5 nm sum of D65 y  =  XYZ of primary i.
The primaries are those of Rec. 709, with X and Z scaled such that their white is the table's own D65.  The third primary
follows from the other two and the white.  Solved by an active set: values that would be negative are 0.
"""
import sys

import numpy as np
import scipy.linalg

COLORD = "/usr/share/colord/"
XYZ_FROM_RGB = np.array(
    [
        [0.4123907992659595, 0.357584339383878, 0.1804807884018343],
        [0.2126390058715104, 0.7151686787677559, 0.0721923153607337],
        [0.0193308187155918, 0.119194779794626, 0.9505321522496607],
    ]
)


def read(path):
    lines = open(COLORD + path).read().split("\n")
    start, end = (
        float(next(l for l in lines if l.startswith(key)).split()[1].strip('"'))
        for key in ("SPECTRAL_START_NM", "SPECTRAL_END_NM")
    )
    data = lines[lines.index("BEGIN_DATA") + 1 : lines.index("END_DATA")]
    rows = np.array([[float(x) for x in l.split()] for l in data])
    return np.linspace(start, end, rows.shape[1]), rows


def solve():
    nm, observer = read("cmf/CIE1931-2deg-XYZ.cmf")
    n = len(nm)
    d65_nm, d65 = read("illuminant/CIE-D65.sp")
    weights = observer * np.interp(nm, d65_nm, d65[0])
    weights /= weights[1].sum()
    white = weights.sum(axis=1)
    primaries = XYZ_FROM_RGB * (white / XYZ_FROM_RGB.sum(axis=1))[:, None]

    # Unknowns: the three functions in a row.
    difference = np.diff(np.eye(n), axis=0)
    hessian = np.kron(np.eye(3), difference.T @ difference)
    equal = np.vstack(
        [
            np.hstack([np.eye(n)] * 3),
            np.kron(np.eye(3)[:2], weights),  # the third follows
        ]
    )
    right = np.concatenate([np.ones(n), primaries[:, 0], primaries[:, 1]])

    zero = np.zeros(3 * n, bool)
    for _ in range(200):
        free = ~zero
        a = equal[:, free]
        kkt = np.block([[hessian[np.ix_(free, free)], a.T], [a, np.zeros((len(a), len(a)))]])
        x = np.zeros(3 * n)
        solution = scipy.linalg.lstsq(kkt, np.concatenate([np.zeros(free.sum()), right]))[0]
        x[free] = solution[: free.sum()]
        # The multiplier that holds each value at zero: positive if the free value would be
        # negative.
        pull = hessian @ x + equal.T @ solution[free.sum() :]
        negative = free & (x < -1e-13)
        released = zero & (pull < -1e-9)
        if not negative.any() and not released.any():
            break
        if negative.any():
            zero |= negative
        else:
            zero[np.argmin(np.where(zero, pull, np.inf))] = False
    else:
        sys.exit("no solution found")
    rho = np.maximum(x, 0).reshape(3, n)
    error = np.abs(weights @ rho.T - primaries).max()
    if error > 1e-12 or np.abs(rho.sum(axis=0) - 1).max() > 1e-12:
        sys.exit(f"constraints are off by {error}")
    return rho


def main():
    print("// Made by lights/maths/generate_rgb_basis.py, which describes it.\n#pragma once\n")
    print('#include <array>\n\n#include "lights/maths/rgb.h"\n\nnamespace lucerna {\n')
    print("/// Smooth reflectances at 360 + 5 k nm.  Under D65, reflectance i has the colour of channel i.")
    print("// clang-format off")
    print("inline constexpr std::array<Rgb<double>, 95> kRgbBasis{{")
    for r, g, b in solve().T:
        print(f"    {{{r:.17g}, {g:.17g}, {b:.17g}}},")
    print("}};\n// clang-format on\n\n}  // namespace lucerna")


if __name__ == "__main__":
    main()
