"""Surfaces and lights by the formulas of textbooks, in NumPy.  Lengths in metres, values in photometric units."""
import math

import numpy as np

LUMINANCE = np.array([0.2126390058715104, 0.7151686787677559, 0.0721923153607337])


def unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def dots(a, b):
    return np.sum(a * b, axis=-1)


def frame(w):
    """Two unit vectors at right angles to each `w`."""
    other = np.where(np.abs(w[..., :1]) < 0.7, np.array([1.0, 0, 0]), np.array([0, 1.0, 0]))
    a = unit(np.cross(w, other))
    return a, np.cross(w, a)


def about(w, cos_theta, phi):
    """The directions at these angles from `w`."""
    a, b = frame(w)
    s = np.sqrt(np.maximum(0, 1 - cos_theta**2))[..., None]
    return s * np.cos(phi)[..., None] * a + s * np.sin(phi)[..., None] * b + cos_theta[..., None] * w

# The surfaces.  Each has: sample(u) -> points, normals; area; meets(x, d) -> distances along d, inf without a hit.
class Parallelogram:
    def __init__(self, corner, u, v, triangle=False, uneven=False):
        self.corner, self.u, self.v = (np.array(a, float) for a in (corner, u, v))
        cross = np.cross(self.u, self.v)
        self.n = cross / np.linalg.norm(cross)
        self.triangle, self.uneven = triangle, uneven
        self.area = np.linalg.norm(cross) / (2 if triangle else 1)

    def sample(self, u):
        if self.triangle:
            root = u[:, 0] if self.uneven else np.sqrt(u[:, 0])
            a, b = 1 - root, u[:, 1] * root
        else:
            a, b = u[:, 0], u[:, 1]
        return self.corner + a[:, None] * self.u + b[:, None] * self.v, np.broadcast_to(self.n, (len(u), 3))

    def solid_angle(self, x):
        """Of the parallelogram, as two triangles: tan(angle / 2) = |abc| / (1 + ab + bc + ca)."""
        corners = [unit(self.corner + k * self.u + m * self.v - x) for k, m in ((0, 0), (1, 0), (1, 1), (0, 1))]
        total = 0
        for a, b, c in (corners[:3], (corners[0], *corners[2:])):
            over = np.abs(dots(a, np.cross(b, c)))
            total = total + 2 * np.arctan2(over, 1 + dots(a, b) + dots(b, c) + dots(c, a))
        return total

    def uv(self, p):
        uu, uv, vv = self.u @ self.u, self.u @ self.v, self.v @ self.v
        a, b = (p - self.corner) @ self.u, (p - self.corner) @ self.v
        det = uu * vv - uv * uv
        return (a * vv - b * uv) / det, (b * uu - a * uv) / det

    def meets(self, x, d):
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (self.corner - x) @ self.n / (d @ self.n)
            a, b = self.uv(x + t[:, None] * d)
        inside = (a >= 0) & (b >= 0) & ((a + b <= 1) if self.triangle else ((a <= 1) & (b <= 1)))
        return np.where(inside & (t > 1e-6), t, np.inf)


class Disk:
    """Faces down."""

    def __init__(self, center, radius):
        self.center, self.radius = np.array(center, float), radius
        self.n, self.area = np.array([0, 0, -1.0]), math.pi * radius**2

    def sample(self, u):
        r, phi = self.radius * np.sqrt(u[:, 0]), 2 * math.pi * u[:, 1]
        p = self.center + np.stack([r * np.cos(phi), r * np.sin(phi), 0 * r], axis=1)
        return p, np.broadcast_to(self.n, p.shape)

    def meets(self, x, d):
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (self.center[2] - x[:, 2]) / d[:, 2]
            inside = np.linalg.norm(x + t[:, None] * d - self.center, axis=1) <= self.radius
        return np.where(inside & (t > 1e-6), t, np.inf)


class Ball:
    def __init__(self, center, radius):
        self.center, self.radius, self.area = np.array(center, float), radius, 4 * math.pi * radius**2

    def sample(self, u):
        z, phi = 1 - 2 * u[:, 0], 2 * math.pi * u[:, 1]
        s = np.sqrt(np.maximum(0, 1 - z * z))
        n = np.stack([s * np.cos(phi), s * np.sin(phi), z], axis=1)
        return self.center + self.radius * n, n

    def meets(self, x, d):
        o = self.center - x
        along = dots(o, d)
        square = self.radius**2 - (dots(o, o) - along**2)
        root = np.sqrt(np.maximum(0, square))
        t = np.where(along - root > 1e-6, along - root, along + root)
        return np.where((square >= 0) & (t > 1e-6), t, np.inf)


class Tube:
    """An open cylinder along x."""

    def __init__(self, center, radius, half):
        self.center, self.radius, self.half = np.array(center, float), radius, half
        self.area = 2 * math.pi * radius * 2 * half

    def sample(self, u):
        phi = 2 * math.pi * u[:, 1]
        n = np.stack([0 * phi, np.cos(phi), np.sin(phi)], axis=1)
        p = self.center + self.radius * n
        p[:, 0] += self.half * (2 * u[:, 0] - 1)
        return p, n

    def meets(self, x, d):
        o, k = (x - self.center)[:, 1:], d[:, 1:]
        a, b, c = dots(k, k), dots(o, k), dots(o, o) - self.radius**2
        square = b * b - a * c
        best = np.full(len(x), np.inf)
        with np.errstate(divide="ignore", invalid="ignore"):
            for sign in (1, -1):
                t = (-b + sign * np.sqrt(np.maximum(0, square))) / a
                at = np.abs((x + t[:, None] * d - self.center)[:, 0]) <= self.half
                best = np.where((square >= 0) & at & (t > 1e-6), np.minimum(best, t), best)
        return best


class Light:
    """A light by its name.  `li` samples it: directions, densities (None: delta), distances, RGB values, normals."""
    delta = False
    infinite = False

    def rgb(self, level):
        return np.array([level] * 3 if np.isscalar(level) else level, float)


class AtPoint(Light):
    delta = True

    def __init__(self, position, intensity):
        self.position, self.intensity = np.array(position, float), intensity

    def li(self, x, rng):
        to = self.position - x
        d = np.linalg.norm(to, axis=1)
        w = to / d[:, None]
        return w, None, d, self.intensity(-w) / d[:, None] ** 2, None


class FromFar(Light):
    delta, infinite = True, True

    def __init__(self, to_light, level):
        self.to_light, self.level = unit(np.array(to_light, float)), self.rgb(level)

    def li(self, x, rng):
        n = len(x)
        return np.tile(self.to_light, (n, 1)), None, np.full(n, np.inf), np.tile(self.level, (n, 1)), None


class Sun(Light):
    infinite = True

    def __init__(self, to_light, illuminance, diameter_deg):
        self.to_light = unit(np.array(to_light, float))
        self.cos = math.cos(math.radians(diameter_deg / 2))
        # The illuminance on a surface that faces the centre is pi L sin^2.
        self.radiance = self.rgb(illuminance) / (math.pi * (1 - self.cos**2))

    def li(self, x, rng):
        u = rng.random((len(x), 2))
        w = about(np.tile(self.to_light, (len(x), 1)), 1 - u[:, 0] * (1 - self.cos), 2 * math.pi * u[:, 1])
        pdf = np.full(len(x), 1 / (2 * math.pi * (1 - self.cos)))
        return w, pdf, np.full(len(x), np.inf), np.tile(self.radiance, (len(x), 1)), None


class Sky(Light):
    """Radiance from all directions, which are sampled uniformly."""
    infinite = True

    def __init__(self, radiance):
        self.radiance = radiance

    def li(self, x, rng):
        u = rng.random((len(x), 2))
        w = about(np.tile([0, 0, 1.0], (len(x), 1)), 1 - 2 * u[:, 0], 2 * math.pi * u[:, 1])
        return w, np.full(len(x), 1 / (4 * math.pi)), np.full(len(x), np.inf), self.radiance(w), None


class Area(Light):
    """A surface, sampled uniformly by area."""

    def __init__(self, shape, level, sides=1, texture=None):
        self.shape, self.level, self.sides, self.texture = shape, self.rgb(level), sides, texture

    def shines(self, n, w):
        return dots(n, w) > 0 if self.sides == 1 else np.full(len(w), True)

    def radiance(self, p):
        return self.level * (self.texture(*self.shape.uv(p)) if self.texture else np.ones((len(p), 1)))

    def li(self, x, rng):
        p, n = self.shape.sample(rng.random((len(x), 2)))
        d = np.linalg.norm(p - x, axis=1)
        w = (p - x) / d[:, None]
        pdf = d**2 / (self.shape.area * np.abs(dots(n, w)))
        value = self.radiance(p) * self.shines(n, -w)[:, None]
        return w, pdf, d, value, n

    def power(self):
        return math.pi * self.sides * self.shape.area * (self.level @ LUMINANCE)


class BallLight(Area):
    """Sampled uniformly in the cone in which it is seen."""

    def density(self, x):
        to = self.shape.center - x
        d2 = dots(to, to)
        sin2 = np.minimum(self.shape.radius**2 / d2, 1)
        one_less_cos = sin2 / (1 + np.sqrt(1 - sin2))
        return one_less_cos, 1 / (2 * math.pi * one_less_cos)

    def li(self, x, rng):
        u = rng.random((len(x), 2))
        one_less_cos, pdf = self.density(x)
        axis = unit(self.shape.center - x)
        w = about(axis, 1 - u[:, 0] * one_less_cos, 2 * math.pi * u[:, 1])
        d = self.shape.meets(x, w)
        # The edge of the cone only touches the ball.
        d = np.where(np.isfinite(d), d, np.sqrt(np.maximum(0, dots(self.shape.center - x, self.shape.center - x)
                                                           - self.shape.radius**2)))
        n = unit(x + d[:, None] * w - self.shape.center)
        return w, pdf, d, np.tile(self.level, (len(x), 1)), n
