"""The calls of RenderService, as steps, and their pictures."""
from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lucerna import _plots, _wire
from lucerna._accuracy import Accuracy, accuracy_of
from lucerna._gathered import SceneLike, set_fields
from lucerna._steps import Steps, Stream, Unary
from lucerna._wire import Doubles, Floats, Ids
from lucerna.v1 import accuracy_pb2, render_pb2


@dataclasses.dataclass(frozen=True, kw_only=True)
class Tile:
    """A rectangle of pixels with the statistics of each, from Scene.tile.  Rows from the top."""

    x0: int  #: the first column and row in the picture
    y0: int
    image_width: int  #: of the whole picture [pixels]
    image_height: int
    samples_per_block: int  #: 0 with a target error
    first_block: int
    blocks: int  #: number of blocks n
    sum: Doubles  #: over the blocks' means, RGB [cd/m2] times the film's scale, shape (rows, columns, 3)
    deviation: Doubles  #: sum over blocks of (block's mean - pixel)^2, shape (rows, columns, 3)
    samples: Ids  #: samples of each pixel, shape (rows, columns)
    low: Floats | None  #: the converged luminance lies from `low` to `high`, in the unit of `sum`
    high: Floats | None  #: shape (rows, columns); None without intervals
    may_miss_light: bool  #: by way of curved smooth surfaces, which a remark of the load names
    cost: accuracy_pb2.Cost

    @property
    def pixels(self) -> Doubles:
        """The picture: linear RGB [cd/m2] times the film's scale, shape (rows, columns, 3)."""
        pixels: Doubles = self.sum / self.blocks
        return pixels

    @property
    def standard_error(self) -> Doubles | None:
        """Of `pixels`, the same shape; None with one block."""
        n = self.blocks
        if n < 2:
            return None
        error: Doubles = np.sqrt(self.deviation / (n * (n - 1)))
        return error


@dataclasses.dataclass(frozen=True, kw_only=True)
class Picture:
    """A picture of a scene, from Scene.render.  Rows from the top."""

    pixels: Doubles  #: linear RGB [cd/m2] times the film's scale, shape (height, width, 3)
    standard_error: Doubles  #: of `pixels`; NaN where one block is known, shape (height, width, 3)
    samples: Ids  #: samples of each pixel, shape (height, width)
    low: Floats | None  #: the converged luminance lies from `low` to `high`, in the unit of `pixels`
    high: Floats | None  #: shape (height, width); None without intervals
    may_miss_light: bool  #: by way of curved smooth surfaces, which a remark of the load names
    cost: accuracy_pb2.Cost

    @property
    def luminance(self) -> Doubles:
        """The luminance of `pixels`, in their unit, shape (height, width)."""
        # The weights of Rec. 709 and D65, as in lights/maths/rgb.h.
        luminance: Doubles = self.pixels @ np.array([0.2126390058715104, 0.7151686787677559, 0.0721923153607337])
        return luminance

    def srgb(self, exposure: float | None = None) -> NDArray[np.uint8]:
        """The picture for a screen: sRGB, shape (height, width, 3).

        exposure: factor of `pixels`; 1 is white.  By default the 99th percentile of the luminance becomes white.
        """
        return _plots.srgb(self.pixels, self.luminance, exposure)

    def plot(self, path: Any = None, *, exposure: float | None = None, title: str = "") -> Any:
        """Draws the picture as `srgb` and returns matplotlib's figure.

        `path`: also writes it there.  ImportError without matplotlib.
        """
        return _plots.picture(self.srgb(exposure), path, title)


def _plane(data: bytes, dtype: str, *shape: int) -> NDArray[Any]:
    plane = np.frombuffer(data, np.uint8)
    if plane.size != math.prod(shape) * np.dtype(dtype).itemsize:
        raise _wire.Broken(f"a plane of a tile has {plane.size} bytes, expected {dtype} in shape {shape}")
    values: NDArray[Any] = plane.view(dtype).reshape(shape).copy()
    if not np.isfinite(values).all():
        raise _wire.Broken("a tile has a number that is not finite")
    return values


def _check(tile: render_pb2.Tile) -> None:
    """As check_tile() in client/library/answer_checks.cpp."""
    r = tile.rect
    if not (r.x0 < r.x1 <= tile.image_width and r.y0 < r.y1 <= tile.image_height):
        raise _wire.Broken(f"{_name(r)} is empty, or outside of its picture")
    if tile.image_width * tile.image_height > 1 << 30 or tile.block_count == 0:
        raise _wire.Broken(f"{_name(r)} is of a picture of more than 2^30 pixels, or has no blocks")
    if bool(tile.lower) != bool(tile.upper):
        raise _wire.Broken(f"{_name(r)} has one of lower and upper, must have both or none")


def _name(r: render_pb2.PixelRect) -> str:
    return f"tile [{r.x0}, {r.x1}) x [{r.y0}, {r.y1})"


def _tile(tile: render_pb2.Tile, cost: accuracy_pb2.Cost) -> Tile:
    _check(tile)
    rows, columns = tile.rect.y1 - tile.rect.y0, tile.rect.x1 - tile.rect.x0
    each = tile.samples_per_block * tile.block_count
    return Tile(
        x0=tile.rect.x0, y0=tile.rect.y0, image_width=tile.image_width, image_height=tile.image_height,
        samples_per_block=tile.samples_per_block, first_block=tile.first_block, blocks=tile.block_count,
        sum=_plane(tile.sum, "<f8", rows, columns, 3), deviation=_plane(tile.deviation, "<f8", rows, columns, 3),
        samples=(_plane(tile.samples, "<u4", rows, columns).astype(np.uint64) if tile.samples
                 else np.full((rows, columns), each, np.uint64)),
        low=_plane(tile.lower, "<f4", rows, columns) if tile.lower else None,
        high=_plane(tile.upper, "<f4", rows, columns) if tile.upper else None, may_miss_light=tile.may_miss_light,
        cost=cost)


def _assembled(parts: dict[tuple[int, int, int, int], Tile], size: tuple[int, int],
               intervals: bool) -> dict[str, NDArray[Any]]:
    """The planes of a picture, from tiles that have as many pixels.  Takes the tiles out of `parts`."""
    planes: dict[str, NDArray[Any]] = {"pixels": np.zeros((*size, 3)), "standard_error": np.zeros((*size, 3)),
                                       "samples": np.zeros(size, np.uint64)}
    if intervals:
        planes.update(low=np.zeros(size, np.float32), high=np.zeros(size, np.float32))
    known = np.zeros(size, bool)
    while parts:
        (x0, y0, x1, y1), part = parts.popitem()
        at = (slice(y0, y1), slice(x0, x1))
        if known[at].any():
            raise _wire.Broken(f"tile [{x0}, {x1}) x [{y0}, {y1}) overlaps other tiles")
        known[at] = True
        for name, plane in planes.items():
            value = getattr(part, name)
            plane[at] = np.nan if value is None else value
    return planes


def _shutter(offset_s: float | None, length_s: float | None) -> render_pb2.Shutter | None:
    if offset_s is None and length_s is None:
        return None
    shutter = render_pb2.Shutter(offset_s=offset_s or 0.0)
    set_fields(shutter, length_s=length_s)
    return shutter


def tile(scene: SceneLike, rect: tuple[int, int, int, int] | None = None, *, samples: int | None = None,
         error: float | None = None, budget_s: float | None = None, accuracy: Accuracy | None = None, seed: int = 0,
         bounces: int | None = None, first_sample: int = 0, samples_per_block: int | None = None,
         time_s: float | None = None, shutter_offset_s: float | None = None, shutter_length_s: float | None = None,
         intervals: bool = False, one_sequence: bool = False) -> Steps[Tile]:
    """Renders one tile.

    rect: (x0, y0, x1, y1) [pixels], half-open, rows from the top; the whole picture by default.  samples: for each
    pixel, a power of two; by default that of the scene file, or 64.  bounces: the most reflections after the surface
    that the camera sees.  first_sample, samples_per_block: an aligned run of blocks (proto/lucerna/v1/render.proto).
    time_s: the moment [s]; by default the shutter's time.  intervals: an interval for each pixel.  one_sequence: less
    noise, and standard errors that are upper estimates.  Errors: InvalidArgument, ResourceExhausted for a large tile.
    """
    request = render_pb2.RenderTileRequest(
        scene_id=scene.id, accuracy=accuracy_of(accuracy, samples, error, budget_s), intervals=intervals,
        one_sequence=one_sequence, shutter=_shutter(shutter_offset_s, shutter_length_s))
    set_fields(request, seed=seed, bounces=bounces, first_sample=first_sample, samples_per_block=samples_per_block,
               time_s=time_s)
    if rect is not None:
        set_fields(request.rect, **dict(zip(("x0", "y0", "x1", "y1"), rect, strict=True)))
    data = yield Unary("RenderService/RenderTile", request.SerializeToString())
    answer = _wire.parsed(render_pb2.RenderTileResponse, data)
    if rect is not None and answer.tile.rect != request.rect:
        raise _wire.Broken(f"{_name(answer.tile.rect)}: requested was {_name(request.rect)}")
    return _tile(answer.tile, answer.cost)


def render(scene: SceneLike, *, samples: int | None = None, error: float | None = None, budget_s: float | None = None,
           accuracy: Accuracy | None = None, seed: int = 0, bounces: int | None = None,
           samples_per_block: int | None = None, tile_size: int | None = None, time_s: float | None = None,
           shutter_offset_s: float | None = None, shutter_length_s: float | None = None, intervals: bool = False,
           one_sequence: bool = False, on_tile: Callable[[Tile], None] | None = None) -> Steps[Picture]:
    """Renders the whole picture.

    samples: for each pixel; by default those of the scene file, or 64.  error: target error of each pixel's luminance.
    budget_s: wall time [s].  tile_size: edge of the tiles [pixels], default 64.  on_tile: is called with each tile
    as it arrives, coarse tiles first; without it the server sends only finished tiles.  The rest: as in `tile`.
    Errors: InvalidArgument, NotFound for a released scene.
    """
    request = render_pb2.RenderImageRequest(
        scene_id=scene.id, accuracy=accuracy_of(accuracy, samples, error, budget_s), final_only=on_tile is None,
        intervals=intervals, one_sequence=one_sequence, shutter=_shutter(shutter_offset_s, shutter_length_s))
    set_fields(request, seed=seed, bounces=bounces, samples_per_block=samples_per_block, tile_size=tile_size,
               time_s=time_s)
    cost = accuracy_pb2.Cost()
    missing = [False]
    # Planes are made when all tiles are there: a server may name any size of its picture.
    parts: dict[tuple[int, int, int, int], Tile] = {}

    def receive(data: bytes) -> None:
        answer = _wire.parsed(render_pb2.RenderImageResponse, data)
        cost.CopyFrom(answer.cost)
        if not answer.HasField("tile"):
            return
        part = _tile(answer.tile, answer.cost)
        missing[0] |= part.may_miss_light
        r = answer.tile.rect
        at = (r.x0, r.y0, r.x1, r.y1)
        if at in parts and part.blocks <= parts[at].blocks:
            raise _wire.Broken(f"{_name(r)} came again without more blocks")
        first = next(iter(parts.values()), part)
        if ((first.image_width, first.image_height) != (part.image_width, part.image_height)
                or (first.low is None) != (part.low is None)):
            raise _wire.Broken(f"{_name(r)} is of another picture than the tiles before")
        parts[at] = part
        if on_tile is not None:
            on_tile(part)

    yield Stream("RenderService/RenderImage", request.SerializeToString(), receive)
    covered = sum(part.samples.size for part in parts.values())
    first = next(iter(parts.values()), None)
    if first is None or covered != first.image_width * first.image_height:
        raise _wire.Broken(f"the picture ended with {covered} pixels, of "
                           f"{first.image_width * first.image_height if first else 'unknown size'}")
    planes = _assembled(parts, (first.image_height, first.image_width), first.low is not None)
    return Picture(pixels=planes["pixels"], standard_error=planes["standard_error"], samples=planes["samples"],
                   low=planes.get("low"), high=planes.get("high"), may_miss_light=missing[0], cost=cost)
