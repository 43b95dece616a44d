"""Row 30: a closed box.  The receiver sees the faces that are turned to it, each a polygon."""
from itertools import product

from mpmath import mpf

from polygons import around, coordinates, cross, dot, irradiance, solid_angle, sub, unit, vec
from table import Table


def faces(half):
    """Returns the corners of each face in the order of bilinear patches, with outward normals."""
    for axis, side in product(range(3), (-1.0, 1.0)):
        corners = []
        for v, u in product((-1.0, 1.0), (-1.0, 1.0)):
            p = [0.0] * 3
            p[axis] = side * half
            p[(axis + 1) % 3], p[(axis + 2) % 3] = u * side * half, v * half
            corners.append(p)
        yield corners


def tables():
    box = Table("closed_box", """
The box |x|, |y|, |z| <= 1/2 seen from outside, from 1e-9 above a face to 1e9 away: solid angle of the faces turned to
the receiver [sr], irradiance from radiance 1 [lx].
""", f"{coordinates('receiver normal')} solid_angle_sr irradiance_lx")
    for exponent in range(-9, 10):
        gap = 10.0**exponent
        for direction in ([0.0, 0.0, 1.0], [0.25, 0.5, 1.0]):
            receiver = [0.0, 0.0, 0.5 + gap] if direction[0] == 0 else [
                0.125 + gap * direction[0], 0.125 + gap * direction[1], 0.5 + gap * direction[2]]
            # The receiver faces the box, so that all visible parts of it are above the horizon.
            normal = [0.0, 0.0, -1.0] if gap < 1 else unit([-x for x in receiver])
            sr = lx = mpf(0)
            for corners in faces(0.5):
                n = cross(sub(vec(corners[1]), vec(corners[0])), sub(vec(corners[2]), vec(corners[0])))
                if dot(n, sub(vec(receiver), vec(corners[0]))) > 0:
                    sr += solid_angle(around(corners), receiver)
                    lx += irradiance(around(corners), receiver, normal)
            box.add(*receiver, *normal, sr, lx)
    yield box
