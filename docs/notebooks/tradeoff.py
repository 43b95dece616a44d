# %% [markdown]
# # Error against time
#
# Which way of choosing lights is best in a scene with four hundred lamps?  Each method answers with several numbers of
# samples.  The real error is the distance to a reference with many samples, and the time is the processor time that the
# server reports.  `lucerna tradeoff` makes the full study (docs/tradeoff.md).  Run this file in the root of the
# repository with `build/release/bin` on PATH.

# %%
import pathlib

import lucerna
import numpy as np
from matplotlib.figure import Figure

PLOTS = pathlib.Path("build/notebooks")
PLOTS.mkdir(parents=True, exist_ok=True)
server = lucerna.local("tests/data/reference")
scene = server.load("many_points.pbrt")
floor = lucerna.grid((-3, -3, 0.01), (6, 0, 0), (0, 5, 0), columns=24, rows=20)

# %% [markdown]
# The reference samples every lamp at every point, which is exact for point lights.

# %%
reference = scene.irradiance(floor, bounces=0, accuracy=lucerna.Accuracy(samples=16, light_selection="all"))
lux = reference.illuminance
assert np.array_equal(reference.low, reference.high)

# %% [markdown]
# Error and time of each method.  The median over several seeds hides the jitter of the clock.

# %%
SAMPLES, SEEDS = 4 ** np.arange(1, 6), range(5)
curves = {}
for method in ("uniform", "power", "bvh"):
    rows = []
    for samples in SAMPLES:
        accuracy = lucerna.Accuracy(samples=int(samples), light_selection=method)
        answers = [scene.irradiance(floor, bounces=0, accuracy=accuracy, seed=seed) for seed in SEEDS]
        error = np.sqrt(np.mean([((a.illuminance - lux) / lux.mean()) ** 2 for a in answers]))
        rows.append((np.median([a.cost.cpu_time_s for a in answers]), error))
        held = np.mean([(a.low <= lux) & (lux <= a.high) for a in answers])
        print(f"{method:<8} {samples:5d} samples  {1e3 * rows[-1][0]:7.1f} ms  error {100 * error:6.2f} %"
              f"  intervals hold {100 * held:.0f} %")
    curves[method] = np.array(rows)
assert all(curve[-1, 1] < 0.3 * curve[0, 1] for curve in curves.values())
assert curves["bvh"][-1, 1] < curves["uniform"][-1, 1]

# %%
figure = Figure(figsize=(7, 4.6), layout="constrained")
axes = figure.add_subplot()
for (method, curve), marker in zip(curves.items(), "os^"):
    axes.loglog(1e3 * curve[:, 0], 100 * curve[:, 1], marker=marker, label=method)
    for (time, error), samples in zip(curve, SAMPLES):
        if method == "bvh":
            axes.annotate(str(samples), (1e3 * time, 100 * error), xytext=(0, -14), textcoords="offset points",
                          ha="center", fontsize=8, color="0.35")
axes.margins(y=0.12)
for axis in (axes.xaxis, axes.yaxis):
    axis.set_major_formatter("{x:g}")
axes.set(xlabel="processor time for 480 points [ms]", ylabel="error relative to the mean [%]",
         title="Four hundred lamps: error against time (numbers: samples)")
axes.grid(which="both", alpha=0.25)
axes.legend(frameon=False, title="how lights are chosen")
figure.savefig(PLOTS / "tradeoff.png", dpi=110)

# %%
server.close()
