"""Samples of lights and their densities, as steps.  Each function is a method of both clients' Scene."""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lucerna import _batches as b
from lucerna import _points as p
from lucerna import _results as results
from lucerna import _wire
from lucerna._accuracy import Accuracy, accuracy_of
from lucerna._errors import invalid
from lucerna._gathered import Gathered, Light, SceneLike, name_light, number_of, points_at, seed_of, set_fields
from lucerna._steps import Steps
from lucerna.v1 import accuracy_pb2, lighting_pb2


TARGET_SAMPLES = 65536  # TargetError.max_samples, unless the request says otherwise


def sample_li(scene: SceneLike, points: p.Places, normals: ArrayLike | None = None, *, light: Light | None = None,
              samples: int | None = None, error: float | None = None, budget_s: float | None = None,
              accuracy: Accuracy | None = None, u: ArrayLike | None = None, u_light: ArrayLike | None = None,
              seed: int = 0, first_item: int = 0, test_visibility: bool = False, time_s: float | None = None,
              position_error_m: float | None = None, wavelengths_nm: Sequence[float] = (),
              progress: b.Progress = False) -> Steps[results.LightSamples]:
    """Samples the light that arrives at points.

    points: world [m], shape (..., 3), or a Grid.  normals: world, of any length but 0, shape (3,) or (..., 3); none for
    points in free space.  light: id or name; by default the server chooses a light for each sample.  samples: for each
    point, default 1.  error, budget_s: a target error or a wall time [s]; the answer then has `estimates`.
    u: your own sample values in [0, 1], shape (..., samples, 2), or (..., 2) without `samples`.  u_light: in [0, 1),
    one for each sample; required with `u` if no light is named.  time_s: the moment [s].  progress: as in irradiance.

    Points in any number are sent in batches.  Errors: as in irradiance.
    """
    where, facing = p.places("points", points, normals)
    shape, items = where.shape[:-1], where[..., 0].size
    wavelengths = np.asarray(wavelengths_nm, np.float64).reshape(-1)
    head = lighting_pb2.SampleLiRequest(scene_id=scene.id, test_visibility=test_visibility,
                                        accuracy=accuracy_of(accuracy, samples, error, budget_s))
    name_light(head, light)
    set_fields(head, time_s=time_s, position_error_m=position_error_m, wavelengths_nm=wavelengths)
    count = head.accuracy.samples if head.accuracy.HasField("samples") else 1
    per_point = (count,) if head.accuracy.HasField("samples") else ()
    estimates = head.accuracy.HasField("target_error") or head.accuracy.HasField("time_budget_s")
    origin = p.origin_of(where)
    arrays = [points_at((number_of(head, "receivers"),), where, origin)]
    if facing is not None:
        arrays.append(b.ItemArray((number_of(head, "normals"),), p.to_floats(facing, 3)))
    own = _own_values(head, u, u_light, (*shape, *per_point), 2, count)
    request = b.BatchRequest("LightingService/SampleLi", items, head.SerializeToString(), (*arrays, *own),
                             None if own else (number_of(head, "seed"), seed_of(seed, first_item)))
    each = (14 * b.FLOAT + 2 * b.BIT + b.STATUS + (3 * b.FLOAT if test_visibility else 0)
            + (b.CHOICE if light is None else 0) + b.FLOAT * wavelengths.size)
    weight, whole = max(1, count), head.accuracy.HasField("time_budget_s")
    if head.accuracy.HasField("target_error") and items > 1:
        # Otherwise the number of samples of a point would depend on the number of points in its request.
        if not head.accuracy.target_error.HasField("max_samples"):
            limits = yield from b.server_limits()
            head.accuracy.target_error.max_samples = min(
                TARGET_SAMPLES, limits.max_batch_items, limits.max_samples,
                (limits.max_message_bytes - b.FIXED - _of_receiver(wavelengths)) // each)
            request = b.BatchRequest(request.method, items, head.SerializeToString(), request.arrays, request.seed)
        weight = max(1, head.accuracy.target_error.max_samples)
        each += -(-_of_receiver(wavelengths) // weight)
    answered = yield from b.in_batches(request, per_item=each, weight=weight, whole=whole, progress=progress)
    got = Gathered(answered, lighting_pb2.SampleLiResponse, lambda a, n: (
        int(a.message("estimates").varints("samples").sum()) if estimates else n * count))
    per = _estimates(got, shape, wavelengths) if estimates and items else None
    form = (got.count,) if estimates else (*shape, *per_point)
    counts: Any = count if per is None else per.samples.reshape(-1).astype(np.intp)
    offsets = got.floats("light_offsets_m", *form, 3)
    distance = got.floats("distance_m", *form)
    ends = p.shifted(offsets, origin)
    nowhere = distance == 0
    if nowhere.any():
        # Lights at infinity have no point; their offset 0 does not mean the origin.
        ends[nowhere] = 0
    return results.LightSamples(
        value=got.floats("value", *form, 3), wi=got.floats("wi", *form, 3), distance=distance,
        light_points=ends, light_normals=got.floats("light_normals", *form, 3),
        density=got.floats("pdf_per_sr", *form), delta=got.bits("delta", *form),
        visible=got.bits("visible", *form) if test_visibility else None,
        transmittance=got.floats_if_any("transmittance", *form, 3), light_ids=got.varints_if_any("light_ids", *form),
        probability=got.doubles_if_any("selection_probability", *form),
        receiver=_receivers(items, counts).reshape(form), status=got.status(*form),
        wavelengths_nm=wavelengths, spectral=got.floats_if_any("spectral_value", *form, wavelengths.size),
        estimates=per, cost=got.cost())


def _receivers(items: int, counts: int | NDArray[np.intp]) -> NDArray[np.intp]:
    """The index of each sample's point."""
    index = np.arange(items)
    return index if isinstance(counts, int) and counts == 1 else np.repeat(index, counts)


def _own_values(head: Any, u: ArrayLike | None, u_light: ArrayLike | None, shape: tuple[int, ...], width: int,
                count: int) -> list[b.ItemArray]:
    """The caller's own sample values; shape (*shape, width) and shape."""
    if u is None:
        if u_light is not None:
            raise invalid("u", "is missing, required with u_light")
        return []
    outer, inner = number_of(head, "u"), lighting_pb2.SampleValues
    values = np.asarray(u, np.float64)
    if values.shape != (*shape, width):
        raise invalid("u", f"has shape {values.shape}, must be {(*shape, width)}")
    arrays = [b.ItemArray((outer, number_of(inner, "u")), p.to_floats(values, width * count))]
    if u_light is not None:
        choice = np.asarray(u_light, np.float64)
        if choice.shape != shape:
            raise invalid("u_light", f"has shape {choice.shape}, must be {shape}")
        arrays.append(b.ItemArray((outer, number_of(inner, "u_light")),
                                  np.ascontiguousarray(choice).reshape(-1, count)))
    return arrays


def _of_receiver(wavelengths: NDArray[Any]) -> int:
    """Bytes of the estimates of a receiver: count, illuminance, error, interval, wavelengths and their errors."""
    return b.COUNT + 4 * b.FLOAT + 2 * b.FLOAT * int(wavelengths.size) + b.STATUS


def _estimates(got: Gathered, shape: tuple[int, ...], wavelengths: NDArray[Any]) -> results.Estimates:
    per = got.inside("estimates")
    return results.Estimates(
        samples=per.varints("samples", *shape), illuminance=per.floats("illuminance_lx", *shape),
        standard_error=per.floats("standard_error_lx", *shape), low=per.floats("lower_lx", *shape),
        high=per.floats("upper_lx", *shape), status=per.status(*shape),
        spectral=per.floats_if_any("spectral_irradiance", *shape, wavelengths.size),
        spectral_standard_error=per.floats_if_any("spectral_standard_error", *shape, wavelengths.size))


def pdf_li(scene: SceneLike, points: p.Places, wi: ArrayLike, *, light: Light, normals: ArrayLike | None = None,
           accuracy: Accuracy | None = None, time_s: float | None = None,
           progress: b.Progress = False) -> Steps[results.LightDensity]:
    """Returns the density with which sample_li chooses directions, for one light.

    points: world [m], shape (..., 3).  wi: world, from the point, of any length but 0, shape (3,) or (..., 3).  light:
    id or name.  normals: as in sample_li.  accuracy: only `area_sampling` counts.  time_s: the moment [s].
    Errors: as in irradiance.
    """
    where, facing = p.places("points", points, normals)
    shape = where.shape[:-1]
    head = lighting_pb2.PdfLiRequest(scene_id=scene.id, accuracy=accuracy_of(accuracy, None, None, None))
    name_light(head, light)
    set_fields(head, time_s=time_s)
    arrays = [points_at((number_of(head, "receivers"),), where),
              b.ItemArray((number_of(head, "wi"),), p.to_floats(p.vectors("wi", wi, shape), 3))]
    if facing is not None:
        arrays.append(b.ItemArray((number_of(head, "normals"),), p.to_floats(facing, 3)))
    request = b.BatchRequest("LightingService/PdfLi", where[..., 0].size, head.SerializeToString(), tuple(arrays))
    got = Gathered((yield from b.in_batches(request, per_item=b.FLOAT + b.STATUS, progress=progress)),
                   lighting_pb2.PdfLiResponse)
    return results.LightDensity(density=got.floats("pdf_per_sr", *shape), status=got.status(*shape), cost=got.cost())


def sample_le(scene: SceneLike, count: int, *, light: Light | None = None, u: ArrayLike | None = None,
              u_light: ArrayLike | None = None, seed: int = 0, first_item: int = 0, time_s: float | None = None,
              wavelengths_nm: Sequence[float] = (), progress: b.Progress = False) -> Steps[results.EmissionSamples]:
    """Samples rays that leave lights.

    count: how many.  light: id or name; by default the server chooses lights by power.  u: your own sample values in
    [0, 1], shape (count, 4).  u_light: in [0, 1), shape (count,); required with `u` if no light is named.  time_s: the
    moment [s].  wavelengths_nm: as in irradiance.  Errors: as in irradiance.
    """
    if count < 0:
        raise invalid("count", f"is {count}, allowed: 0 and above")
    wavelengths = np.asarray(wavelengths_nm, np.float64).reshape(-1)
    head = lighting_pb2.SampleLeRequest(scene_id=scene.id)
    name_light(head, light)
    set_fields(head, time_s=time_s, wavelengths_nm=wavelengths)
    own = _own_values(head, u, u_light, (count,), 4, 1)
    request = b.BatchRequest("LightingService/SampleLe", count, head.SerializeToString(), tuple(own),
                             None if own else (number_of(head, "seed"), seed_of(seed, first_item)),
                             number_of(head, "count"))
    each = (14 * b.FLOAT + b.STATUS + (b.CHOICE if light is None else 0) + b.FLOAT * int(wavelengths.size))
    got = Gathered((yield from b.in_batches(request, per_item=each, progress=progress)), lighting_pb2.SampleLeResponse)
    points = got.inside("points")
    offsets = points.floats("offsets_m", count, 3)
    # Every batch has the origin of the scene.
    at = _wire.parsed(accuracy_pb2.Vector3, points.parts[0].data("origin_m"))
    origin = np.array([at.x, at.y, at.z])
    return results.EmissionSamples(
        points=p.shifted(offsets, origin), offsets=offsets, origin=origin,
        directions=got.floats("directions", count, 3),
        light_normals=got.floats("light_normals", count, 3), value=got.floats("value", count, 3),
        density_position=got.floats("pdf_position_per_m2", count),
        density_direction=got.floats("pdf_direction_per_sr", count), light_ids=got.varints_if_any("light_ids", count),
        probability=got.doubles_if_any("selection_probability", count), status=got.status(count),
        wavelengths_nm=wavelengths, spectral=got.floats_if_any("spectral_value", count, wavelengths.size),
        cost=got.cost())


def pdf_le(scene: SceneLike, points: ArrayLike | results.EmissionSamples, directions: ArrayLike | None = None, *,
           light: Light, time_s: float | None = None, progress: b.Progress = False) -> Steps[results.EmissionDensity]:
    """Returns the densities with which sample_le chooses rays, for one light.

    points: on the light, world [m], shape (..., 3), or the EmissionSamples themselves, whose bits are then sent.
    directions: of the rays, away from the light, world, of any length but 0, shape (3,) or (..., 3).  light: id or
    name.  time_s: the moment [s].  Errors: as in irradiance.
    """
    head = lighting_pb2.PdfLeRequest(scene_id=scene.id)
    name_light(head, light)
    set_fields(head, time_s=time_s)
    path = (number_of(head, "points"),)
    if isinstance(points, results.EmissionSamples):
        origin = accuracy_pb2.Vector3(x=points.origin[0], y=points.origin[1], z=points.origin[2])
        start = b.ItemArray((*path, p.OFFSETS), points.offsets, _wire.field(p.ORIGIN, origin.SerializeToString()))
        shape: tuple[int, ...] = points.offsets.shape[:-1]
        directions = points.directions if directions is None else directions
    else:
        where = p.vectors("points", points)
        start, shape = points_at(path, where), where.shape[:-1]
    if directions is None:
        raise invalid("directions", "are missing, must be (3,) or have the shape of the points")
    away = p.vectors("directions", directions, shape)
    request = b.BatchRequest("LightingService/PdfLe", away[..., 0].size, head.SerializeToString(),
                             (start, b.ItemArray((number_of(head, "directions"),), p.to_floats(away, 3))))
    got = Gathered((yield from b.in_batches(request, per_item=2 * b.FLOAT + b.STATUS, progress=progress)),
                   lighting_pb2.PdfLeResponse)
    return results.EmissionDensity(
        density_position=got.floats("pdf_position_per_m2", *shape),
        density_direction=got.floats("pdf_direction_per_sr", *shape), status=got.status(*shape), cost=got.cost())
