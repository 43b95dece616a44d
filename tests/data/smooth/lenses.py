#!/usr/bin/env python3
"""Writes lens_*.pbrt and lenses.tsv: light of a disk through a ball of glass, on their axis.

A receiver at the origin faces the ball, and the lamp is behind it.  The scene is the same all around the axis, so
the illuminance is an integral over one angle.  Each ray is followed in a plane, with Snell's law and Fresnel's
equations, through up to 40 reflections inside of the ball.
"""
import pathlib

import numpy as np

LUMINANCE = 1e4  # cd/m2
ETA = 1.5
STEPS, PARTS = 4_000_000, 10
# Height of the ball's centre, its radius, height of the lamp, its radius [m].
CASES = [(0.6, 0.3, 2, 0.05), (1.5, 0.3, 3, 0.05), (1, 0.4, 3, 0.02), (1.5, 0.3, 3, 0.01)]


def fresnel(cos_i, eta_i, eta_t):
    """The reflected share of unpolarised light, and the cosine of the refracted ray."""
    sin2_t = (eta_i / eta_t) ** 2 * (1 - cos_i * cos_i)
    cos_t = np.sqrt(np.maximum(0, 1 - sin2_t))
    parallel = (eta_t * cos_i - eta_i * cos_t) / (eta_t * cos_i + eta_i * cos_t)
    across = (eta_i * cos_i - eta_t * cos_t) / (eta_i * cos_i + eta_t * cos_t)
    return np.where(sin2_t >= 1, 1, (parallel**2 + across**2) / 2), cos_t


def found(angles, centre, radius, lamp, lamp_radius):
    """The share of the lamp's luminance that is seen at each angle from the axis."""
    def sees_lamp(x, z, wx, wz):
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (lamp - z) / wz
            return (wz > 0) & (t > 0) & (np.abs(x + wx * t) <= lamp_radius)

    wx, wz = np.sin(angles), np.cos(angles)
    along = wz * centre
    root2 = radius**2 - (centre**2 - along**2)
    share = np.where(root2 > 0, 0.0, sees_lamp(0 * wx, 0 * wx, wx, wz))
    hit = np.where(root2 > 0)[0]
    wx, wz = wx[hit], wz[hit]
    t = along[hit] - np.sqrt(root2[hit])
    x, z = t * wx, t * wz

    nx, nz = x / radius, (z - centre) / radius
    cos_i = -(wx * nx + wz * nz)
    reflected, cos_t = fresnel(cos_i, 1, ETA)
    sum_ = reflected * sees_lamp(x, z, wx + 2 * cos_i * nx, wz + 2 * cos_i * nz)
    bend = cos_i / ETA - cos_t
    wx, wz = wx / ETA + bend * nx, wz / ETA + bend * nz
    inside = 1 - reflected
    for _ in range(40):
        t = -2 * (x * wx + (z - centre) * wz)
        x, z = x + t * wx, z + t * wz
        # Rounding would grow with the number of reflections.
        size = np.hypot(x, z - centre)
        nx, nz = x / size, (z - centre) / size
        x, z = radius * nx, centre + radius * nz
        size = np.hypot(wx, wz)
        wx, wz = wx / size, wz / size
        cos_i = wx * nx + wz * nz
        reflected, cos_t = fresnel(cos_i, ETA, 1)
        bend = cos_t - ETA * cos_i
        sum_ += inside * (1 - reflected) * sees_lamp(x, z, ETA * wx + bend * nx, ETA * wz + bend * nz)
        inside = inside * reflected
        wx, wz = wx - 2 * cos_i * nx, wz - 2 * cos_i * nz
    share[hit] += sum_
    return share


def main():
    folder = pathlib.Path(__file__).parent
    rows = ["file\tpoint\tnormal\tilluminance_lx"]
    for i, case in enumerate(CASES):
        step = np.pi / 2 / (STEPS * PARTS)
        lux = 0
        for part in range(PARTS):
            angles = (np.arange(STEPS) + part * STEPS + 0.5) * step
            lux += 2 * np.pi * LUMINANCE * step * np.sum(found(angles, *case) * np.sin(angles) * np.cos(angles))
        centre, radius, lamp, lamp_radius = case
        name = f"lens_{i}.pbrt"
        (folder / name).write_text(f"""WorldBegin
AttributeBegin
  Translate 0 0 {lamp}
  Scale 1 1 -1
  AreaLightSource "diffuse" "rgb L" [{LUMINANCE:g} {LUMINANCE:g} {LUMINANCE:g}]
  Shape "disk" "float radius" {lamp_radius}
AttributeEnd
Translate 0 0 {centre}
Material "dielectric" "float eta" {ETA}
Shape "sphere" "float radius" {radius}
""")
        rows.append(f"{name}\t0,0,0\t0,0,1\t{lux:.8g}")
    (folder / "lenses.tsv").write_text("\n".join(rows) + "\n")


if __name__ == "__main__":
    main()
