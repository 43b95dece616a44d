#!/usr/bin/env python3
"""Writes caustic_*.pbrt and caustics.tsv: light of a lamp without a size by way of one curved surface.

Each scene is the same all around the z axis, on which the lamp and the middle of a ball lie.  Rays are followed in
the half plane of the receiver, with Snell's law and Fresnel's equations.  A root of the distance at which a ray passes
the receiver is a path; the change of that distance with the ray's start gives the spread of its light.
"""
import math
import pathlib

from scipy.optimize import brentq

STEPS = 40_000
MOST_INNER = 6  # reflections inside of glass; the next brings less than 1e-8


def dielectric(cos_i, eta):
    """The reflected share of unpolarised light, and the cosine of the refracted ray; eta: behind over before."""
    sin2_t = (1 - cos_i * cos_i) / (eta * eta)
    if sin2_t >= 1:
        return 1, 0
    cos_t = math.sqrt(1 - sin2_t)
    parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t)
    across = (cos_i - eta * cos_t) / (cos_i + eta * cos_t)
    return (parallel**2 + across**2) / 2, cos_t


def conductor(cos_i, reflectance):
    """The share that pbrt's conductor of a reflectance along the normal reflects: eta 1, k from the reflectance."""
    index = complex(1, 2 * math.sqrt(reflectance) / math.sqrt(1 - reflectance))
    cos_t = (1 - (1 - cos_i * cos_i) / index**2) ** 0.5
    parallel = (index * cos_i - cos_t) / (index * cos_i + cos_t)
    across = (cos_i - index * cos_t) / (cos_i + index * cos_t)
    return (abs(parallel) ** 2 + abs(across) ** 2) / 2


def to_sphere(x, z, wx, wz, centre, radius, is_inside):
    """The distance along a unit direction to a sphere about (0, centre), or None."""
    b = x * wx + (z - centre) * wz
    root2 = b * b - (x * x + (z - centre) ** 2 - radius**2)
    if root2 <= 0:
        return None
    t = -b + math.sqrt(root2) if is_inside else -b - math.sqrt(root2)
    return t if t > 1e-9 else None


class GlassBall:
    """A ball of glass about (0, centre)."""

    def __init__(self, centre, radius, eta):
        self.centre, self.radius, self.eta = centre, radius, eta

    def pbrt(self):
        return f'Translate 0 0 {self.centre}\nMaterial "dielectric" "float eta" {self.eta}\n' \
               f'Shape "sphere" "float radius" {self.radius}\n'

    def out(self, branch, x, z, wx, wz):
        """Where the ray of a branch leaves, its direction and its share.  Branch 0 is reflected outside; branch
        k passes with k - 1 reflections inside."""
        t = to_sphere(x, z, wx, wz, self.centre, self.radius, False)
        if t is None:
            return None
        x, z = x + t * wx, z + t * wz
        nx, nz = x / self.radius, (z - self.centre) / self.radius
        cos_i = -(wx * nx + wz * nz)
        reflected, cos_t = dielectric(cos_i, self.eta)
        if branch == 0:
            return x, z, wx + 2 * cos_i * nx, wz + 2 * cos_i * nz, reflected
        bend = cos_i / self.eta - cos_t
        wx, wz = wx / self.eta + bend * nx, wz / self.eta + bend * nz
        share = 1 - reflected
        for k in range(branch):
            t = to_sphere(x, z, wx, wz, self.centre, self.radius, True)
            x, z = x + t * wx, z + t * wz
            nx, nz = x / self.radius, (z - self.centre) / self.radius
            cos_i = wx * nx + wz * nz
            reflected, cos_t = dielectric(cos_i, 1 / self.eta)
            if k == branch - 1:
                bend = cos_t - self.eta * cos_i
                return x, z, self.eta * wx + bend * nx, self.eta * wz + bend * nz, share * (1 - reflected)
            share *= reflected
            wx, wz = wx - 2 * cos_i * nx, wz - 2 * cos_i * nz
        return None

    def branches(self):
        return range(MOST_INNER + 2)

    def hides(self, x, z, wx, wz, distance):
        t = to_sphere(x, z, wx, wz, self.centre, self.radius, False)
        return t is not None and t < distance


class Bowl:
    """A mirror: the part of a sphere about (0, 0) that lies below a height, which reflects on its inside."""

    def __init__(self, radius, z_max, reflectance):
        self.radius, self.z_max, self.reflectance = radius, z_max, reflectance

    def pbrt(self):
        return f'Material "conductor" "rgb reflectance" [{" ".join([str(self.reflectance)] * 3)}] ' \
               f'"float roughness" 0\n' \
               f'Shape "sphere" "float radius" {self.radius} "float zmin" {-self.radius} "float zmax" {self.z_max}\n'

    def out(self, branch, x, z, wx, wz):
        """The same, after `branch` reflections."""
        share = 1
        for _ in range(branch):
            t = to_sphere(x, z, wx, wz, 0, self.radius, True)
            if t is None or z + t * wz > self.z_max:
                return None
            x, z = x + t * wx, z + t * wz
            nx, nz = -x / self.radius, -z / self.radius
            cos_i = -(wx * nx + wz * nz)
            share *= conductor(cos_i, self.reflectance)
            wx, wz = wx + 2 * cos_i * nx, wz + 2 * cos_i * nz
        t = to_sphere(x, z, wx, wz, 0, self.radius, True)
        if t is not None and z + t * wz <= self.z_max:
            return None  # it meets the bowl again
        return x, z, wx, wz, share

    def branches(self):
        return range(1, 10)

    def hides(self, x, z, wx, wz, distance):
        t = to_sphere(x, z, wx, wz, 0, self.radius, True)
        return t is not None and t < distance and z + t * wz <= self.z_max


class Point:
    def __init__(self, z, intensity):
        self.z, self.intensity = z, intensity
        self.range = (-math.pi, math.pi)

    def pbrt(self):
        return f'LightSource "point" "point3 from" [0 0 {self.z}] "rgb I" [{" ".join([str(self.intensity)] * 3)}]\n'

    def start(self, s):
        return 0, self.z, math.sin(s), math.cos(s)

    def flux(self, s):
        """Within a unit of s and of the angle around the axis [lm]."""
        return self.intensity * abs(math.sin(s))

    def direct(self, surface, x, z, nx, nz):
        dx, dz = -x, self.z - z
        d = math.hypot(dx, dz)
        if surface.hides(0, self.z, -dx / d, -dz / d, d * (1 - 1e-9)):
            return 0
        return self.intensity * max(0, (dx * nx + dz * nz) / d) / d**2


class Sun:
    """Light that comes down along the axis."""

    def __init__(self, lux, reach):
        self.lux, self.range = lux, (-reach, reach)

    def pbrt(self):
        return f'LightSource "distant" "point3 from" [0 0 1] "point3 to" [0 0 0] ' \
               f'"rgb L" [{" ".join([str(self.lux)] * 3)}]\n'

    def start(self, s):
        return s, 100, 0, -1

    def flux(self, s):
        return self.lux * abs(s)

    def direct(self, surface, x, z, nx, nz):
        return 0 if surface.hides(x, 100, 0, -1, 100 - z) else self.lux * max(0, nz)


def illuminance(lamp, surface, x, z, nx, nz):
    """At (x, z), x > 0, on a surface with a normal in the same plane [lx]."""
    lux = lamp.direct(surface, x, z, nx, nz)
    low, high = lamp.range

    for branch in surface.branches():
        def off(s):
            """The distance at which the ray passes, and how far it is then."""
            out = surface.out(branch, *lamp.start(s))
            if out is None:
                return None
            px, pz, wx, wz, _ = out
            return (x - px) * wz - (z - pz) * wx, (x - px) * wx + (z - pz) * wz

        before = None
        for i in range(STEPS + 1):
            s = low + (high - low) * (i + 0.3) / (STEPS + 1)
            at = off(s)
            if before is not None and at is not None and before[1][0] * at[0] < 0 and before[1][1] > 0 and at[1] > 0:
                root = brentq(lambda q: off(q)[0], before[0], s, xtol=1e-15, rtol=1e-15)
                h = 1e-6
                slope = (off(root + h)[0] - off(root - h)[0]) / (2 * h)
                *_, wx, wz, share = surface.out(branch, *lamp.start(root))
                lux += lamp.flux(root) * share * max(0, -(wx * nx + wz * nz)) / (x * abs(slope))
            before = None if at is None else (s, at)
    return lux


CASES = [
    (Point(3, 100), GlassBall(1.5, 0.3, 1.5), (0.05, 0, 0, 1)),
    (Point(3, 100), GlassBall(1.5, 0.3, 1.5), (0.35, 0, 0, 1)),
    (Point(3, 100), GlassBall(1.5, 0.3, 1.5), (1.5, 1, 0, 1)),
    (Point(1.6, 100), GlassBall(0.5, 0.4, 1.33), (0.1, 0, 0, 1)),
    (Point(-0.3, 50), Bowl(1, -0.5, 0.9), (0.3, 1.5, 0, -1)),
    (Point(-0.6, 50), Bowl(1, -0.2, 0.8), (0.1, 2, 0, -1)),
    (Sun(50000, 0.5), GlassBall(1.5, 0.5, 1.5), (0.2, 0, 0, 1)),
]


def main():
    folder = pathlib.Path(__file__).parent
    rows = ["file\tpoint\tnormal\tlux\tlux_direct"]
    for i, (lamp, surface, (x, z, nx, nz)) in enumerate(CASES):
        name = f"caustic_{i}.pbrt"
        (folder / name).write_text("WorldBegin\n" + lamp.pbrt() + surface.pbrt())
        lux, direct = illuminance(lamp, surface, x, z, nx, nz), lamp.direct(surface, x, z, nx, nz)
        rows.append(f"{name}\t{x},0,{z}\t{nx},0,{nz}\t{lux:.8g}\t{direct:.8g}")
    (folder / "caustics.tsv").write_text("\n".join(rows) + "\n")


if __name__ == "__main__":
    main()
