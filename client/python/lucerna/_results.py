"""Answers of queries: arrays in the shape of the points that were asked about.

In the docstrings `...` is the shape of the points without its last axis.  A list of N points gives (N,), a grid gives
(rows, columns).
"""
from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lucerna import _plots
from lucerna._wire import Bools, Doubles, Floats, Ids
from lucerna.v1 import accuracy_pb2

#: Names of the numbers in arrays `status` (docs/api.md, item statuses): STATUS[1] is "OK".
STATUS: tuple[str, ...] = tuple(n.removeprefix("ITEM_STATUS_") for n in accuracy_pb2.ItemStatus.keys())
OK = accuracy_pb2.ITEM_STATUS_OK

Statuses = NDArray[np.uint8]


def columns(**arrays: Any) -> dict[str, NDArray[Any]]:
    """Columns of a table; None is left out.

    `n__xyz` names an array with three numbers for each row, which become the columns nx, ny and nz.  Longer names have
    an underscore: value_r, value_g, value_b.
    """
    table: dict[str, NDArray[Any]] = {}
    for name, array in arrays.items():
        if array is None:
            continue
        stem, _, ends = name.partition("__")
        if ends:
            rows = np.asarray(array).reshape(-1, len(ends))
            link = "_" if len(stem) > 1 else ""
            table.update({f"{stem}{link}{end}": rows[:, i] for i, end in enumerate(ends)})
        else:
            table[stem] = np.asarray(array).reshape(-1)
    return table


def frame_of(table: dict[str, NDArray[Any]]) -> Any:
    """A pandas DataFrame.  ImportError without pandas (Debian's python3-pandas)."""
    import pandas

    return pandas.DataFrame(table)


def status_names(status: Statuses) -> NDArray[Any]:
    """The names of statuses, for tables."""
    return np.array(STATUS)[status]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Shares:
    """The light of each light at each point: directly, and by way of mirrors, panes and glass."""

    light_ids: Ids  #: shape (lights,)
    illuminance: Floats  #: [lx], shape (lights, ...)
    standard_error: Floats | None  #: [lx], the same shape; None if a single sample was requested
    low: Floats | None  #: the converged value lies from `low` to `high` [lx], the same shape
    high: Floats | None


@dataclasses.dataclass(frozen=True, kw_only=True)
class Irradiance:
    """The light that arrives on surfaces, from Scene.irradiance."""

    points: Doubles  #: world [m], shape (..., 3)
    normals: Doubles  #: world, as given, shape (..., 3)
    illuminance: Floats  #: what a lux meter reads [lx], shape (...)
    irradiance: Floats  #: linear RGB [lx], shape (..., 3)
    standard_error: Floats | None  #: of `illuminance` [lx], shape (...); None if a single sample was requested
    low: Floats | None  #: the converged illuminance lies from `low` to `high` [lx], shape (...)
    high: Floats | None
    zero_bound: Floats  #: `high` if every sample was 0 but light may have been missed; else 0 [lx], shape (...)
    unsampled_bound: Floats  #: part of `high` for light that may be missing (MAY_MISS_LIGHT) [lx], shape (...)
    missed_surfaces: list[str]  #: places of curved smooth surfaces and portals by way of which light may be missing
    samples: Ids  #: samples of each point, shape (...); with a target error 0 for exact answers
    status: Statuses  #: numbers of STATUS, shape (...)
    shares: Shares | None  #: with `per_light`
    wavelengths_nm: Doubles  #: as requested, shape (W,)
    spectral: Floats | None  #: irradiance at the wavelengths [W/m2/nm], shape (..., W)
    spectral_standard_error: Floats | None  #: of `spectral`, the same shape
    cost: accuracy_pb2.Cost  #: samples, rays and times of all batches

    def frame(self) -> Any:
        """A pandas DataFrame with a row for each point.  ImportError without pandas."""
        return frame_of(columns(
            __xyz=self.points, n__xyz=self.normals, illuminance_lx=self.illuminance, low_lx=self.low,
            high_lx=self.high, standard_error_lx=self.standard_error, __rgb=self.irradiance, samples=self.samples,
            status=status_names(self.status)))

    def plot(self, path: Any = None, *, intervals: bool = True, title: str = "Illuminance") -> Any:
        """Draws the illuminance [lx] and returns matplotlib's figure.

        Points of a grid become a map, with a second map of the intervals.  A list of points becomes a curve over the
        distance from the first point, with a band.  `path`: also writes the figure there.  ImportError without
        matplotlib.
        """
        return _plots.light_map(self, path, intervals, title)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Estimates:
    """The light at each point, from all its samples."""

    samples: Ids  #: samples of each point in the answer, shape (...)
    illuminance: Floats  #: with normals the illuminance, else the spherical illuminance [lx], shape (...)
    standard_error: Floats  #: [lx], shape (...)
    low: Floats  #: the converged value lies from `low` to `high` [lx], shape (...)
    high: Floats
    status: Statuses  #: numbers of STATUS, shape (...)
    spectral: Floats | None  #: [W/m2/nm], shape (..., W)
    spectral_standard_error: Floats | None


@dataclasses.dataclass(frozen=True, kw_only=True)
class LightSamples:
    """Samples of the light that arrives at points, from Scene.sample_li.

    `s` stands for the shape of the samples: (...) for one sample a point, (..., n) for n samples.  With a target error
    or a time budget it is (S,), point by point; `receiver` says whose sample each is.
    """

    value: Floats  #: radiance along `wi` [cd/m2], for delta lights illuminance [lx]; RGB, shape (s, 3)
    wi: Floats  #: unit, world, from the point to the light, shape (s, 3)
    distance: Floats  #: to the light [m]; 0 if it is infinitely far, shape (s)
    light_points: Doubles  #: the sampled point, world [m]; 0 for lights at infinity, shape (s, 3)
    light_normals: Floats  #: unit, on the emitting side; 0 if the light has no surface, shape (s, 3)
    density: Floats  #: with respect to solid angle [1/sr]; 0 for delta lights, shape (s)
    delta: Bools  #: the light has no density, shape (s)
    visible: Bools | None  #: with `test_visibility`, shape (s)
    transmittance: Floats | None  #: share of the light that arrives, RGB, shape (s, 3); None: all where visible
    light_ids: Ids | None  #: the chosen lights, if the server chose; shape (s)
    probability: Doubles | None  #: of this choice, shape (s)
    receiver: NDArray[np.intp]  #: index of the sample's point in the flat list of points, shape (s)
    status: Statuses  #: numbers of STATUS, shape (s)
    wavelengths_nm: Doubles  #: as requested, shape (W,)
    spectral: Floats | None  #: `value` at the wavelengths [W/m2/sr/nm] or [W/m2/nm], shape (s, W)
    estimates: Estimates | None  #: with a target error or a time budget
    cost: accuracy_pb2.Cost  #: of all batches

    def frame(self) -> Any:
        """A pandas DataFrame with a row for each sample.  ImportError without pandas."""
        return frame_of(columns(
            receiver=self.receiver, light=self.light_ids, value__rgb=self.value, wi__xyz=self.wi,
            distance_m=self.distance, pdf_per_sr=self.density, delta=self.delta, visible=self.visible,
            probability=self.probability, status=status_names(self.status)))

    def plot(self, path: Any = None, *, title: str = "Sampled directions") -> Any:
        """Draws the directions of the samples as longitude and latitude, coloured by density [1/sr].

        Returns matplotlib's figure.  `path`: also writes it there.  ImportError without matplotlib.
        """
        return _plots.directions(self.wi, self.density, self.status == OK, path, title)


@dataclasses.dataclass(frozen=True, kw_only=True)
class LightDensity:
    """The densities with which Scene.sample_li chooses directions, from Scene.pdf_li."""

    density: Floats  #: with respect to solid angle [1/sr], shape (...)
    status: Statuses  #: numbers of STATUS, shape (...)
    cost: accuracy_pb2.Cost

    def frame(self) -> Any:
        """A pandas DataFrame with a row for each direction.  ImportError without pandas."""
        return frame_of(columns(pdf_per_sr=self.density, status=status_names(self.status)))


@dataclasses.dataclass(frozen=True, kw_only=True)
class EmissionSamples:
    """Rays that leave lights, from Scene.sample_le."""

    points: Doubles  #: where the rays start, world [m], shape (N, 3)
    offsets: Floats  #: the same relative to `origin` [m], the bits that the densities belong to, shape (N, 3)
    origin: Doubles  #: world [m], shape (3,)
    directions: Floats  #: unit, world, shape (N, 3)
    light_normals: Floats  #: unit; 0 if the light has no surface, shape (N, 3)
    value: Floats  #: [cd/m2], without a surface [cd], for parallel light [lx]; RGB, shape (N, 3)
    density_position: Floats  #: with respect to area [1/m2]; 0 if the position is certain, shape (N,)
    density_direction: Floats  #: with respect to solid angle [1/sr]; 0 if the direction is certain, shape (N,)
    light_ids: Ids | None  #: the chosen lights, if the server chose; shape (N,)
    probability: Doubles | None  #: of this choice, shape (N,)
    status: Statuses  #: numbers of STATUS, shape (N,)
    wavelengths_nm: Doubles  #: as requested, shape (W,)
    spectral: Floats | None  #: `value` at the wavelengths, shape (N, W)
    cost: accuracy_pb2.Cost

    def frame(self) -> Any:
        """A pandas DataFrame with a row for each ray.  ImportError without pandas."""
        return frame_of(columns(
            __xyz=self.points, d__xyz=self.directions, value__rgb=self.value, pdf_per_m2=self.density_position,
            pdf_per_sr=self.density_direction, light=self.light_ids, probability=self.probability,
            status=status_names(self.status)))

    def plot(self, path: Any = None, *, title: str = "Emitted directions") -> Any:
        """Draws the directions of the rays as longitude and latitude, coloured by density [1/sr].

        Returns matplotlib's figure.  `path`: also writes it there.  ImportError without matplotlib.
        """
        return _plots.directions(self.directions, self.density_direction, self.status == OK, path, title)


@dataclasses.dataclass(frozen=True, kw_only=True)
class EmissionDensity:
    """The densities with which Scene.sample_le chooses rays, from Scene.pdf_le."""

    density_position: Floats  #: with respect to area [1/m2]; 0 if the position is certain, shape (...)
    density_direction: Floats  #: with respect to solid angle [1/sr]; 0 if the direction is certain, shape (...)
    status: Statuses  #: numbers of STATUS, shape (...)
    cost: accuracy_pb2.Cost

    def frame(self) -> Any:
        """A pandas DataFrame with a row for each ray.  ImportError without pandas."""
        return frame_of(columns(pdf_per_m2=self.density_position, pdf_per_sr=self.density_direction,
                                status=status_names(self.status)))


@dataclasses.dataclass(frozen=True, kw_only=True)
class Radiance:
    """The radiance that arrives along rays from the emitters that they meet, from Scene.le."""

    radiance: Floats  #: linear RGB [cd/m2], shape (..., 3)
    light_ids: Ids  #: the light that the ray meets; 0 for none, shape (...)
    status: Statuses  #: numbers of STATUS, shape (...)
    wavelengths_nm: Doubles  #: as requested, shape (W,)
    spectral: Floats | None  #: [W/m2/sr/nm], shape (..., W)
    cost: accuracy_pb2.Cost

    def frame(self) -> Any:
        """A pandas DataFrame with a row for each ray.  ImportError without pandas."""
        return frame_of(columns(__rgb=self.radiance, light=self.light_ids, status=status_names(self.status)))


@dataclasses.dataclass(frozen=True, kw_only=True)
class Visibility:
    """Whether surfaces block ways, from Scene.visible."""

    visible: Bools  #: no surface blocks the way, shape (...)
    transmittance: Floats | None  #: share of light that passes, RGB, shape (..., 3); None: all where visible
    status: Statuses  #: numbers of STATUS, shape (...)
    cost: accuracy_pb2.Cost

    def frame(self) -> Any:
        """A pandas DataFrame with a row for each way.  ImportError without pandas."""
        return frame_of(columns(visible=self.visible, transmittance__rgb=self.transmittance,
                                status=status_names(self.status)))


@dataclasses.dataclass(frozen=True, kw_only=True)
class Surfaces:
    """What the camera sees at places of its picture, from Scene.find_surfaces.

    Methods take it as points with normals: scene.irradiance(surfaces).
    """

    points: Doubles  #: where the rays meet the surfaces, world [m], shape (..., 3); undefined where there is none
    normals: Doubles  #: geometric, unit, on the side of the camera, shape (..., 3); 0 where there is no surface
    found: Bools  #: the ray meets a surface, shape (...)
    light_ids: Ids  #: the light whose surface it is; 0 for none, shape (...)
    status: Statuses  #: numbers of STATUS, shape (...)
    cost: accuracy_pb2.Cost

    def frame(self) -> Any:
        """A pandas DataFrame with a row for each place.  ImportError without pandas."""
        return frame_of(columns(__xyz=self.points, n__xyz=self.normals, found=self.found, light=self.light_ids,
                                status=status_names(self.status)))


@dataclasses.dataclass(frozen=True, kw_only=True)
class Power:
    """The power of lights, from Scene.power.  NaN stands for a number that the light does not have."""

    light_ids: Ids  #: shape (L,)
    flux: Doubles  #: luminous flux [lm], shape (L,)
    rgb: Doubles  #: [lm] of each channel, shape (L, 3)
    error: Doubles  #: bound on the error of `flux` [lm]; 0 if it is exact, shape (L,)
    standard_error: Doubles  #: of `flux`, only with method "sampled" [lm], shape (L,)
    low: Doubles  #: the flux lies from `low` to `high`, only with method "sampled" [lm], shape (L,)
    high: Doubles
    samples: Ids  #: rays in the mean, only with method "sampled"; shape (L,)
    watts: Doubles  #: radiant flux, for lights with a spectrum [W], shape (L,)
    wavelengths_nm: Doubles  #: as requested, shape (W,)
    spectral: Doubles | None  #: at the wavelengths [W/nm], shape (L, W)
    total: float  #: flux of all requested lights [lm]
    total_error: float  #: bound on the error of `total` [lm]
    total_rgb: Doubles  #: [lm], shape (3,)
    cost: accuracy_pb2.Cost

    def frame(self) -> Any:
        """A pandas DataFrame with a row for each light.  ImportError without pandas."""
        return frame_of(columns(light=self.light_ids, flux_lm=self.flux, error_lm=self.error,
                                standard_error_lm=self.standard_error, low_lm=self.low, high_lm=self.high,
                                __rgb=self.rgb, watts=self.watts))

    def plot(self, path: Any = None, *, title: str = "Luminous flux") -> Any:
        """Draws a bar for each light [lm], with its interval if it has one.

        Returns matplotlib's figure.  `path`: also writes it there.  ImportError without matplotlib.
        """
        return _plots.bars(self, path, title)
