"""Points, normals and directions: checks of shapes, grids, and the offsets of the contract."""
from __future__ import annotations

import dataclasses
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lucerna import _wire
from lucerna._errors import invalid
from lucerna.v1 import accuracy_pb2

ORIGIN, OFFSETS = 1, 2  # field numbers of Points


class HasNormals(Protocol):
    """Points with their normals, such as a Grid."""

    @property
    def points(self) -> NDArray[np.float64]:
        """World [m], shape (..., 3)."""

    @property
    def normals(self) -> NDArray[np.float64]:
        """World, shape (..., 3)."""


Places = ArrayLike | HasNormals


@dataclasses.dataclass(frozen=True)
class Grid:
    """Points in the middle of the cells of a rectangle, with its normal.  `grid` makes one."""

    points: NDArray[np.float64]  #: world [m], shape (rows, columns, 3)
    normals: NDArray[np.float64]  #: world, unit, shape (rows, columns, 3)


def grid(corner: ArrayLike, across: ArrayLike, up: ArrayLike, *, columns: int, rows: int) -> Grid:
    """A grid of points on a rectangle.

    `corner` is a point, `across` and `up` are the edges that leave it: world [m], shape (3,) each.  The rectangle has
    `columns` cells along `across` and `rows` along `up`, with a point in the middle of each.  The normal is
    across x up.
    Errors: InvalidArgument for other shapes, and for edges without an area.
    """
    start, u, v = (np.asarray(a, np.float64) for a in (corner, across, up))
    for name, array in (("corner", start), ("across", u), ("up", v)):
        if array.shape != (3,):
            raise invalid(name, f"has shape {array.shape}, must be (3,)")
    if columns < 1 or rows < 1:
        raise invalid("columns and rows", f"are {columns} and {rows}, allowed: at least 1")
    normal = np.cross(u, v)
    length = float(np.linalg.norm(normal))
    if not 0 < length < np.inf:
        raise invalid("across and up", "are parallel or not finite, must span a rectangle")
    s = (np.arange(columns) + 0.5) / columns
    t = (np.arange(rows) + 0.5) / rows
    points = start + s[None, :, None] * u + t[:, None, None] * v
    return Grid(points, np.broadcast_to(normal / length, points.shape).copy())


def vectors(name: str, values: ArrayLike, items: tuple[int, ...] | None = None,
            width: int = 3) -> NDArray[np.float64]:
    """An array of shape (..., width).  With `items`, vectors of shape (3,) or of that shape; broadcast to it."""
    try:
        array = np.asarray(values, np.float64)
    except (TypeError, ValueError):
        raise invalid(name, "is no array of numbers") from None
    if array.ndim == 0 or array.shape[-1] != width:
        raise invalid(name, f"has shape {array.shape}, must be (..., {width})")
    if items is None:
        return array
    try:
        return np.broadcast_to(array, (*items, 3))
    except ValueError:
        raise invalid(name, f"has shape {array.shape}, must be (3,) or {(*items, 3)}") from None


def scalars(name: str, values: ArrayLike, items: tuple[int, ...]) -> NDArray[np.float64]:
    """Numbers, one for each item or one for all."""
    try:
        return np.broadcast_to(np.asarray(values, np.float64), items)
    except (TypeError, ValueError):
        raise invalid(name, f"has shape {np.shape(values)}, must be {items} or ()") from None


def places(name: str, where: Places,
           normals: ArrayLike | None) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    """Points of shape (..., 3), and normals of the same shape or None."""
    array: Any = where
    if hasattr(where, "points") and hasattr(where, "normals"):
        array, normals = where.points, where.normals if normals is None else normals
    points = vectors(name, array)
    return points, None if normals is None else vectors("normals", normals, points.shape[:-1])


def to_floats(array: NDArray[Any], width: int) -> _wire.Floats:
    """Rows of floats.  Numbers beyond their range become infinite, and the server gives these items a status."""
    with np.errstate(over="ignore"):
        return np.ascontiguousarray(array, np.float32).reshape(-1, width)


def origin_of(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """The origin that the C++ library chooses (client/library/points.h), so that both send the same floats.

    If all coordinates are equal, the middle is their value.  Otherwise the origin zero loses at most three bits, and
    keeps coordinates that are zero exact.
    """
    rows = points.reshape(-1, 3)
    if not len(rows):
        return np.zeros(3)
    # Along rows: NumPy takes ten times as long along columns.
    axes = np.ascontiguousarray(rows.T)
    lower, upper = axes.min(axis=1), axes.max(axis=1)
    if not np.isfinite(lower + upper).all():  # NaN and infinity reach the least or the largest number
        return origin_of(rows[np.isfinite(rows).all(axis=1)]) if not np.isfinite(rows).all() else np.zeros(3)
    middle, half = lower / 2 + upper / 2, upper / 2 - lower / 2
    return np.where(np.abs(middle) > 8 * half, middle, 0.0)


def offsets(points: NDArray[np.float64], origin: NDArray[np.float64]) -> tuple[bytes, _wire.Floats]:
    """The field `origin_m` of Points, and its offsets in rows of three."""
    rows = points.reshape(-1, 3)
    if not origin.any():
        return b"", to_floats(rows, 3)
    message = accuracy_pb2.Vector3(x=origin[0], y=origin[1], z=origin[2])
    return _wire.field(ORIGIN, message.SerializeToString()), to_floats(shifted(rows, -origin), 3)


def shifted(points: NDArray[Any], shift: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points of shape (..., 3) plus a vector, in double precision."""
    moved: NDArray[np.float64] = points.astype(np.float64)
    for axis in np.flatnonzero(shift):  # each axis by itself takes a third of the time of all at once
        moved[..., axis] += shift[axis]
    return moved
