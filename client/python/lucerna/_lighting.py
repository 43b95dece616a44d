"""Irradiance, radiance, visibility and power, as steps.  Each function is a method of both clients' Scene."""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lucerna import _batches as b
from lucerna import _points as p
from lucerna import _results as results
from lucerna import _wire
from lucerna._accuracy import Accuracy, accuracy_of, enum_value
from lucerna._errors import invalid
from lucerna._gathered import (Gathered, Light, SceneLike, add_cost, name_light, next_page, number_of, points_at,
                               seed_of, set_fields)
from lucerna._steps import Steps, Unary
from lucerna.v1 import accuracy_pb2, lighting_pb2, render_pb2, scene_pb2


def irradiance(scene: SceneLike, points: p.Places, normals: ArrayLike | None = None, *, samples: int | None = None,
               error: float | None = None, budget_s: float | None = None, accuracy: Accuracy | None = None,
               bounces: int | None = None, per_light: bool = False, seed: int = 0, first_item: int = 0,
               time_s: float | None = None, position_error_m: float | None = None,
               wavelengths_nm: Sequence[float] = (), progress: b.Progress = False) -> Steps[results.Irradiance]:
    """Estimates the light that arrives on surfaces.

    points: world [m], shape (..., 3), or a Grid.  normals: world, of any length but 0, shape (3,) or (..., 3); those of
    the Grid by default.  samples: for each point, default 256.  error: target error relative to the illuminance.
    budget_s: wall time [s]; the points are then one request.  bounces: the most reflections, 0 for direct light only;
    default no limit.  per_light: also returns the light of each light, without diffuse reflections.  time_s: the moment [s].
    wavelengths_nm: in [100, 1e6] nm, at most 128; bounces must then be 0.  progress: True shows a bar of tqdm; a
    function gets the finished and all points.

    Points in any number are sent in batches.  Errors: InvalidArgument, NotFound for a released scene,
    ResourceExhausted.  A bad point has its own status.
    """
    where, facing = p.places("points", points, normals)
    if facing is None:
        raise invalid("normals", "are missing, must be (3,) or have the shape of the points")
    shape = where.shape[:-1]
    wavelengths = np.asarray(wavelengths_nm, np.float64).reshape(-1)
    head = lighting_pb2.EstimateIrradianceRequest(
        scene_id=scene.id, per_light=per_light, accuracy=accuracy_of(accuracy, samples, error, budget_s))
    set_fields(head, bounces=bounces, time_s=time_s, position_error_m=position_error_m, wavelengths_nm=wavelengths)
    lights = 0
    if per_light:
        data = yield Unary("SceneService/GetScene", scene_pb2.GetSceneRequest(scene_id=scene.id).SerializeToString())
        lights = _wire.parsed(scene_pb2.GetSceneResponse, data).summary.lights
    request = b.BatchRequest(
        "LightingService/EstimateIrradiance", where[..., 0].size, head.SerializeToString(),
        (points_at((number_of(head, "receivers"),), where),
         b.ItemArray((number_of(head, "normals"),), p.to_floats(facing, 3))),
        (number_of(head, "seed"), seed_of(seed, first_item)))
    target = head.accuracy.HasField("target_error")
    share = 4 * b.FLOAT
    answered = yield from b.in_batches(
        request, fixed=b.FIXED + 41 * lights, whole=head.accuracy.HasField("time_budget_s"), progress=progress,
        per_item=9 * b.FLOAT + b.STATUS + (2 * b.ID + b.FLOAT if target else 0) + lights * share
        + 2 * b.FLOAT * wavelengths.size)
    got = Gathered(answered, lighting_pb2.EstimateIrradianceResponse)
    used = (got.inside("item_costs").varints("samples", *shape) if target
            else np.full(shape, max(a.number("samples") for a in got.parts), np.uint64))
    return results.Irradiance(
        points=where, normals=facing, illuminance=got.floats("illuminance_lx", *shape),
        irradiance=got.floats("irradiance_lx", *shape, 3),
        standard_error=got.floats_if_any("standard_error_lx", *shape), low=got.floats_if_any("lower_lx", *shape),
        high=got.floats_if_any("upper_lx", *shape), zero_bound=got.floats("zero_bound_lx", *shape), samples=used,
        status=got.status(*shape), shares=_shares(got, shape) if per_light else None, wavelengths_nm=wavelengths,
        spectral=got.floats_if_any("spectral_irradiance", *shape, wavelengths.size),
        spectral_standard_error=got.floats_if_any("spectral_standard_error", *shape, wavelengths.size),
        unsampled_bound=got.floats("unsampled_bound_lx", *shape),
        missed_surfaces=sorted({s for a in got.parts for s in a.texts("missed_surfaces")}), cost=got.cost())


def _shares(got: Gathered, shape: tuple[int, ...]) -> results.Shares:
    # Every batch lists the same lights in the same order.
    batches = [a.messages("shares") for a in got.parts]
    ids = np.array([s.number("light_id") for s in batches[0]], np.uint64)
    if any([s.number("light_id") for s in shares] != ids.tolist() for shares in batches):
        raise _wire.Broken("shares: batches have different lights")

    def gathered(name: str) -> _wire.Floats | None:
        if not any(s.has(name) for shares in batches for s in shares):
            return None
        rows = [got.of_items(name, [shares[i].floats(name) for shares in batches], shape) for i in range(ids.size)]
        array: _wire.Floats = np.stack(rows)
        return array

    values = gathered("illuminance_lx")
    return results.Shares(
        light_ids=ids, illuminance=np.zeros((ids.size, *shape), np.float32) if values is None else values,
        standard_error=gathered("standard_error_lx"), low=gathered("lower_lx"), high=gathered("upper_lx"))


def le(scene: SceneLike, points: ArrayLike, directions: ArrayLike, *, light: Light | None = None,
       accuracy: Accuracy | None = None, time_s: float | None = None, wavelengths_nm: Sequence[float] = (),
       progress: b.Progress = False) -> Steps[results.Radiance]:
    """Returns the radiance that arrives along rays from the emitters that they meet.

    points: where the rays start, world [m], shape (..., 3).  directions: world, of any length but 0, shape (3,) or
    (..., 3).  light: id or name, to count only this one.  accuracy: only `thin_glass` counts.  time_s: the moment [s].
    wavelengths_nm: in [100, 1e6] nm, at most 128.  Errors: as in irradiance.
    """
    where = p.vectors("points", points)
    shape = where.shape[:-1]
    wavelengths = np.asarray(wavelengths_nm, np.float64).reshape(-1)
    head = lighting_pb2.LeRequest(scene_id=scene.id, accuracy=accuracy_of(accuracy, None, None, None))
    name_light(head, light)
    set_fields(head, time_s=time_s, wavelengths_nm=wavelengths)
    request = b.BatchRequest(
        "LightingService/Le", where[..., 0].size, head.SerializeToString(),
        (points_at((number_of(head, "points"),), where),
         b.ItemArray((number_of(head, "directions"),), p.to_floats(p.vectors("directions", directions, shape), 3))))
    got = Gathered((yield from b.in_batches(
        request, per_item=3 * b.FLOAT + b.ID + b.STATUS + b.FLOAT * wavelengths.size, progress=progress)),
        lighting_pb2.LeResponse)
    return results.Radiance(
        radiance=got.floats("radiance_cd_m2", *shape, 3), light_ids=got.varints("light_ids", *shape),
        status=got.status(*shape), wavelengths_nm=wavelengths,
        spectral=got.floats_if_any("spectral_radiance", *shape, wavelengths.size), cost=got.cost())


def visible(scene: SceneLike, points: p.Places, to: ArrayLike | None = None, *, directions: ArrayLike | None = None,
            lengths_m: ArrayLike | None = None, normals: ArrayLike | None = None, accuracy: Accuracy | None = None,
            time_s: float | None = None, position_error_m: float | None = None,
            progress: b.Progress = False) -> Steps[results.Visibility]:
    """Tests whether surfaces block the ways between pairs of points, or along rays.

    points: starts, world [m], shape (..., 3).  Set either `to`, ends [m], or `directions`, world, of any length but 0:
    shape (3,) or (..., 3) each.  lengths_m: of the rays [m], above 0; default infinite.  normals: at the starts, as in
    sample_li.  accuracy: only `thin_glass` counts.  time_s: the moment [s].  Errors: as in irradiance.
    """
    where, facing = p.places("points", points, normals)
    shape = where.shape[:-1]
    if (to is None) == (directions is None):
        raise invalid("to and directions", "allowed: exactly one of them")
    if to is not None and lengths_m is not None:
        raise invalid("lengths_m", "is set beside to, allowed: with directions")
    head = lighting_pb2.TestVisibilityRequest(scene_id=scene.id, accuracy=accuracy_of(accuracy, None, None, None))
    set_fields(head, time_s=time_s, position_error_m=position_error_m)
    if to is not None:
        outer = number_of(head, "segments")
        arrays = [points_at((outer, number_of(lighting_pb2.Segments, "from")), where),
                  points_at((outer, number_of(lighting_pb2.Segments, "to")), p.vectors("to", to, shape))]
    else:
        outer, rays = number_of(head, "rays"), lighting_pb2.Rays
        assert directions is not None
        arrays = [points_at((outer, number_of(rays, "from")), where),
                  b.ItemArray((outer, number_of(rays, "directions")),
                              p.to_floats(p.vectors("directions", directions, shape), 3))]
        if lengths_m is not None:
            arrays.append(b.ItemArray((outer, number_of(rays, "lengths_m")),
                                      p.to_floats(p.scalars("lengths_m", lengths_m, shape), 1)))
    if facing is not None:
        arrays.append(b.ItemArray((number_of(head, "normals"),), p.to_floats(facing, 3)))
    request = b.BatchRequest("LightingService/TestVisibility", where[..., 0].size, head.SerializeToString(),
                             tuple(arrays))
    got = Gathered((yield from b.in_batches(request, per_item=b.BIT + b.STATUS + 3 * b.FLOAT, progress=progress)),
                   lighting_pb2.TestVisibilityResponse)
    return results.Visibility(visible=got.bits("visible", *shape),
                              transmittance=got.floats_if_any("transmittance", *shape, 3), status=got.status(*shape),
                              cost=got.cost())


def find_surfaces(scene: SceneLike, places: ArrayLike, *, time_s: float | None = None,
                  progress: b.Progress = False) -> Steps[results.Surfaces]:
    """Finds the surfaces that the camera sees at places of its picture.

    places: x and y [pixels], shape (..., 2); x from the left, y from the top.  The middle of pixel (i, j) is
    (i + 0.5, j + 0.5).  time_s: the moment [s].  Errors: as in irradiance.  A place outside of the picture has its own
    status.
    """
    where = p.vectors("places", places, width=2)
    shape = where.shape[:-1]
    head = render_pb2.FindSurfacesRequest(scene_id=scene.id)
    set_fields(head, time_s=time_s)
    request = b.BatchRequest("RenderService/FindSurfaces", where[..., 0].size, head.SerializeToString(),
                             (b.ItemArray((number_of(head, "places"),), p.to_floats(where, 2)),))
    got = Gathered((yield from b.in_batches(request, per_item=6 * b.FLOAT + b.BIT + b.ID + b.STATUS,
                                            progress=progress)), render_pb2.FindSurfacesResponse)
    points = got.inside("points")
    # Every batch has the origin of the scene.
    at = _wire.parsed(accuracy_pb2.Vector3, points.parts[0].data("origin_m"))
    return results.Surfaces(
        points=p.shifted(points.floats("offsets_m", *shape, 3), np.array([at.x, at.y, at.z])),
        normals=got.floats("normals", *shape, 3).astype(np.float64), found=got.bits("found", *shape),
        light_ids=got.varints("light_ids", *shape), status=got.status(*shape), cost=got.cost())


def power(scene: SceneLike, lights: Sequence[Light] = (), *, method: str = "exact", samples: int | None = None,
          error: float | None = None, budget_s: float | None = None, accuracy: Accuracy | None = None, seed: int = 0,
          wavelengths_nm: Sequence[float] = ()) -> Steps[results.Power]:
    """Computes the power of lights.

    lights: ids and names; all by default.  method: "exact", "approximate" (textbook formulas with their error) or
    "sampled" (the mean over rays).  samples, error, budget_s, accuracy, seed: only for "sampled".  wavelengths_nm: in
    [100, 1e6] nm, at most 128.  Errors: as in irradiance.
    """
    wavelengths = np.asarray(wavelengths_nm, np.float64).reshape(-1)
    head = lighting_pb2.EstimatePowerRequest(
        scene_id=scene.id, light_ids=[x for x in lights if not isinstance(x, str)],
        light_names=[x for x in lights if isinstance(x, str)],
        accuracy=accuracy_of(accuracy, samples, error, budget_s))
    set_fields(head, seed=seed, wavelengths_nm=wavelengths)
    head.method = enum_value("method", lighting_pb2.EstimatePowerRequest.Method, method)  # type: ignore[assignment]
    found: list[Any] = []
    cost = accuracy_pb2.Cost()
    while True:
        data = yield Unary("LightingService/EstimatePower", head.SerializeToString())
        page = _wire.parsed(lighting_pb2.EstimatePowerResponse, data)
        found += page.lights
        add_cost(page.cost, cost)
        if not next_page(head, page, page.lights):
            break

    def numbers(name: str) -> _wire.Doubles:
        return np.array([getattr(x, name) if x.HasField(name) else np.nan for x in found])

    return results.Power(
        light_ids=np.array([x.light_id for x in found], np.uint64), flux=np.array([x.power_lm for x in found]),
        rgb=np.array([(x.rgb_lm.r, x.rgb_lm.g, x.rgb_lm.b) for x in found]).reshape(-1, 3),
        error=np.array([x.error_lm for x in found]), standard_error=numbers("standard_error_lm"),
        low=numbers("lower_lm"), high=numbers("upper_lm"), samples=np.array([x.samples for x in found], np.uint64),
        watts=numbers("power_w"), wavelengths_nm=wavelengths,
        spectral=np.array([x.spectral_w_per_nm for x in found]) if wavelengths.size else None,
        total=page.total.power_lm, total_error=page.total.error_lm,
        total_rgb=np.array([page.total.rgb_lm.r, page.total.rgb_lm.g, page.total.rgb_lm.b]), cost=cost)
