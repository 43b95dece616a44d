"""Plots of answers.  matplotlib is imported at the first plot (Debian's python3-matplotlib)."""
from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray


def _figure(width: float, height: float, **options: Any) -> Any:
    # Without pyplot: a plot then neither needs a display nor stays in a global list.
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained", **options)


def _finish(figure: Any, path: Any) -> Any:
    if path is not None:
        figure.savefig(path, dpi=150)
    return figure


def srgb(pixels: NDArray[Any], luminance: NDArray[Any], exposure: float | None) -> NDArray[np.uint8]:
    """sRGB of linear pixels."""
    if exposure is None:
        white = float(np.percentile(luminance, 99)) if luminance.size else 0.0
        exposure = 1 / white if white > 0 else 1.0
    x = np.clip(pixels * exposure, 0, 1)
    encoded = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    rounded: NDArray[np.uint8] = np.round(255 * encoded).astype(np.uint8)
    return rounded


def picture(pixels: NDArray[np.uint8], path: Any, title: str) -> Any:
    """A picture with one dot for each pixel and no axes."""
    height, width = pixels.shape[:2]
    figure = _figure(8, 8 * height / width + (0.4 if title else 0))
    axes = figure.add_subplot()
    axes.imshow(pixels, interpolation="nearest")
    axes.set_axis_off()
    if title:
        axes.set_title(title)
    return _finish(figure, path)


def _edges(points: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any], str, str]:
    """Coordinates of a grid of points in its plane, with their names.

    In a plane at right angles to an axis these are the world's own coordinates.
    """
    flat = points.reshape(-1, 3)
    span = flat.max(axis=0) - flat.min(axis=0)
    across, up = points[0, -1] - points[0, 0], points[-1, 0] - points[0, 0]
    if span.min() <= 1e-9 * span.max():
        first, second = (int(i) for i in np.flatnonzero(np.arange(3) != int(span.argmin())))
        if abs(across[first]) >= abs(across[second]):
            return points[..., first], points[..., second], f"{'xyz'[first]} [m]", f"{'xyz'[second]} [m]"
        return points[..., second], points[..., first], f"{'xyz'[second]} [m]", f"{'xyz'[first]} [m]"
    u = across / (np.linalg.norm(across) or 1)
    v = up - (up @ u) * u
    v = v / (np.linalg.norm(v) or 1)
    offset = points - points[0, 0]
    return offset @ u, offset @ v, "across [m]", "up [m]"


def light_map(answer: Any, path: Any, intervals: bool, title: str) -> Any:
    """Maps of a grid, or a curve of a list of points."""
    points = answer.points
    intervals = intervals and answer.low is not None
    if points.ndim != 3 or min(points.shape[:2]) < 2:
        return _curve(answer, path, intervals, title)
    x, y, x_name, y_name = _edges(points)
    shape = (np.ptp(y) + 1e-9) / (np.ptp(x) + 1e-9)
    each = 5.6
    figure = _figure(each * (2 if intervals else 1), float(np.clip(each * 0.86 * shape + 0.9, 2.6, 9)))
    panels = figure.subplots(1, 2 if intervals else 1, squeeze=False)[0]
    known = (answer.status == 1) | (answer.status == 9)  # OK, MAY_MISS_LIGHT
    lux = np.where(known, answer.illuminance, np.nan)
    _map(figure, panels[0], x, y, lux, "inferno", title, "lx")
    if lux[known].size and np.ptp(lux[known]) > 0:
        lines = panels[0].contour(x, y, _smooth(lux), levels=6, colors="white", linewidths=0.7, alpha=0.8)
        panels[0].clabel(lines, fmt="%.3g", fontsize=8)
    if intervals:
        half = np.where(known, (answer.high - answer.low) / 2, np.nan)
        _map(figure, panels[1], x, y, half, "viridis", "Half width of the interval", "± lx")
    for panel in panels:
        panel.set_xlabel(x_name)
    panels[0].set_ylabel(y_name)
    return _finish(figure, path)


def _smooth(values: NDArray[Any]) -> NDArray[Any]:
    """The median of each cell and its neighbours, so that single cells do not get contours of their own."""
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(values, 1, constant_values=np.nan), (3, 3))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # cells without any neighbour that has an answer
        medians: NDArray[Any] = np.nanmedian(windows, axis=(2, 3))
    return medians


def _map(figure: Any, axes: Any, x: NDArray[Any], y: NDArray[Any], values: NDArray[Any], colours: str, title: str,
         unit: str) -> None:
    known = values[np.isfinite(values)]
    # Without a few outliers, which would leave all other cells dark.
    top = float(np.percentile(known, 99)) if known.size else 0.0
    outliers = known.size > 0 and top > 0 and known.max() > 1.5 * top
    mesh = axes.pcolormesh(x, y, values, shading="nearest", cmap=colours, rasterized=True,
                           vmax=top if outliers else None)
    axes.set_aspect("equal")
    axes.set_title(title)
    axes.set_facecolor("0.8")  # points without an answer
    figure.colorbar(mesh, ax=axes, label=unit, shrink=0.95, extend="max" if outliers else "neither")


def _curve(answer: Any, path: Any, intervals: bool, title: str) -> Any:
    flat = answer.points.reshape(-1, 3)
    distance = np.linalg.norm(flat - flat[0], axis=1) if len(flat) else np.empty(0)
    figure = _figure(7, 4)
    axes = figure.add_subplot()
    if intervals:
        axes.fill_between(distance, answer.low.reshape(-1), answer.high.reshape(-1), alpha=0.3, linewidth=0,
                          label="interval")
    axes.plot(distance, answer.illuminance.reshape(-1), label="estimate")
    axes.set(xlabel="distance from the first point [m]", ylabel="illuminance [lx]", title=title)
    axes.set_ylim(bottom=0)
    axes.grid(alpha=0.3)
    if intervals:
        axes.legend(frameon=False)
    return _finish(figure, path)


def directions(vectors: NDArray[Any], density: NDArray[Any], known: NDArray[Any], path: Any, title: str) -> Any:
    """Directions as longitude and latitude about z."""
    keep = known.reshape(-1)
    w, pdf = vectors.reshape(-1, 3)[keep], density.reshape(-1)[keep]
    longitude = np.degrees(np.arctan2(w[:, 1], w[:, 0]))
    latitude = np.degrees(np.arcsin(np.clip(w[:, 2], -1, 1)))
    figure = _figure(8, 4.4)
    axes = figure.add_subplot()
    finite = pdf > 0
    axes.scatter(longitude[~finite], latitude[~finite], s=14, c="0.4", marker="x", linewidths=0.8,
                 label="without density")
    norm: Any = "log" if finite.any() and pdf[finite].max() > 30 * pdf[finite].min() else None
    dots = axes.scatter(longitude[finite], latitude[finite], s=6, c=pdf[finite], cmap="viridis", norm=norm)
    if finite.any():
        figure.colorbar(dots, ax=axes, label="density [1/sr]")
    if not finite.all():
        axes.legend(loc="lower right")
    axes.set(xlim=(-180, 180), ylim=(-90, 90), xlabel="longitude about z [degrees]", ylabel="latitude [degrees]",
             title=title, xticks=range(-180, 181, 60), yticks=range(-90, 91, 30))
    axes.grid(alpha=0.3)
    return _finish(figure, path)


def bars(power: Any, path: Any, title: str) -> Any:
    """A bar for each light, with the interval or the bound on the error."""
    count = len(power.flux)
    figure = _figure(7, max(2.4, 0.32 * count + 1.2))
    axes = figure.add_subplot()
    place = np.arange(count)
    low = np.where(np.isnan(power.low), power.flux - power.error, power.low)
    high = np.where(np.isnan(power.high), power.flux + power.error, power.high)
    error = np.maximum(0, np.stack([power.flux - low, high - power.flux]))
    axes.barh(place, power.flux, xerr=error if error.any() else None, color="#c8963e",
              error_kw={"elinewidth": 1.2, "capsize": 3})
    axes.set_yticks(place, [f"light {i}" for i in power.light_ids])
    axes.invert_yaxis()
    axes.set(xlabel="luminous flux [lm]", title=title)
    axes.grid(axis="x", alpha=0.3)
    axes.set_axisbelow(True)
    return _finish(figure, path)
