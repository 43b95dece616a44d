"""Row 20: pictures projected from a point, from the place of each point of the picture in the plane before it."""
from mpmath import mpf, tan

from maps import tent, texel
from powers import rectangle_sr
from table import Table

DEGREE = 3.141592653589793 / 180
W, H = 4, 3


def value(texel_filter, s, t):
    if texel_filter == "nearest":
        return mpf(texel(int(s * W), int(t * H)))
    # The border continues.
    return sum(texel(min(max(i, 0), W - 1), min(max(j, 0), H - 1)) * tent(s * W - i - mpf(1) / 2) *
               tent(t * H - j - mpf(1) / 2) for i in range(-1, W + 1) for j in range(-1, H + 1))


def places(n):
    near = mpf(10) ** -9
    edges = [mpf(1) / n, mpf(n - 1) / n]
    return [near, 1 - near] + [e + side * near for e in edges for side in (-1, 1)] + [mpf(3) / 2 / n, mpf("0.7391")]


def tables():
    table = Table("projection_maps", """
The picture of 4 x 3 texels, texel (i, j) max(0, (3 i + 5 j) mod 9 - 2), thrown along +z: towards (x, y, 1) its value,
and with the nearest filter the density of directions drawn by it [1/sr], else 0.  Places 1e-9 beside the
edges of the picture and those between texels, centres, and one ordinary place.
""", "filter fov_deg fov_rad aspect x y value per_sr")
    for fov_deg, aspect in ((0.01, 3.0), (1.0, 1000.0), (90.0, 4.0 / 3), (90.0, 1.0 / 3), (179.0, 3.0)):
        fov = fov_deg * DEGREE
        shorter = tan(mpf(fov) / 2)
        half_x, half_y = shorter * max(mpf(aspect), 1), shorter / min(mpf(aspect), 1)
        total = sum(texel(i, j) * rectangle_sr(half_x * (2 * i - W) / W, half_x * (2 * i + 2 - W) / W,
                                               half_y * (2 * j - H) / H, half_y * (2 * j + 2 - H) / H)
                    for i in range(W) for j in range(H))
        for texel_filter in ("nearest", "bilinear"):
            for s in places(W):
                for t in places(H):
                    lit = value(texel_filter, s, t)
                    table.add(texel_filter, fov_deg, fov, aspect, float(half_x * (2 * s - 1)),
                              float(half_y * (1 - 2 * t)), lit, lit / total if texel_filter == "nearest" else mpf(0))
    yield table
