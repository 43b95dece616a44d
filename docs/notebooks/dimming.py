# %% [markdown]
# # What dimming does
#
# Light adds up: the illuminance is the sum of the shares of all lights.  So one query with the share of each light
# answers every setting of the dimmers.  Run this file in the root of the repository with `build/release/bin` on PATH.

# %%
import pathlib

import lucerna
import numpy as np
from matplotlib.figure import Figure

PLOTS = pathlib.Path("build/notebooks")
PLOTS.mkdir(parents=True, exist_ok=True)
server = lucerna.local("scenes")
scene = server.load("room/scene.pbrt")
lights = scene.lights()
print(lights.frame().to_string())

# %% [markdown]
# Direct light of each light on the working plane.  Lights 2 to 9 are downlights, 10 to 12 are pendants.

# %%
plane = lucerna.grid((0.5, 0.5, 0.8), (8, 0, 0), (0, 5.5, 0), columns=32, rows=22)
answer = scene.irradiance(plane, bounces=0, samples=256, per_light=True)
free = answer.status == lucerna.STATUS.index("OK")
shares = answer.shares.illuminance[:, free]  # lights x points [lx]
groups = {"sky": [1], "downlights": range(2, 10), "pendants": range(10, 13)}
rows = {name: np.isin(answer.shares.light_ids, list(ids)) for name, ids in groups.items()}
for name, row in rows.items():
    print(f"{name:<10} {shares[row].sum(axis=0).mean():6.1f} lx on average")

# %% [markdown]
# Dim the pendants to 30 percent.  The sum of the shares predicts the answer for the dimmed scene.  Both answers have the
# same seed and so the same samples, so they agree much better than their intervals.

# %%
dimmed = scene.edit(*(lucerna.edits.change(int(i), scale=0.3) for i in groups["pendants"]))
measured = dimmed.irradiance(plane, bounces=0, samples=256)
scale = np.where(rows["pendants"], 0.3, 1.0)
predicted = np.tensordot(scale, answer.shares.illuminance, axes=1)
width = np.hypot(measured.high - measured.low, answer.high - answer.low)[free]
error = np.abs(predicted - measured.illuminance)[free]
print(f"largest difference {error.max():.2g} lx, where the intervals are {width[error.argmax()]:.2g} lx wide")
assert np.mean(error > width) < 0.01

# %% [markdown]
# Mean and minimum of the working plane for every level of the pendants, without another query.

# %%
levels = np.linspace(0, 1, 41)
base = shares[~rows["pendants"]].sum(axis=0)
pendants = shares[rows["pendants"]].sum(axis=0)
curve = base + levels[:, None] * pendants
figure = Figure(figsize=(11, 4.2), layout="constrained")
left, right = figure.subplots(1, 2, width_ratios=[1.1, 1])
left.plot(100 * levels, curve.mean(axis=1), label="mean", linewidth=2)
left.plot(100 * levels, np.percentile(curve, 10, axis=1), label="10 % of the points have less", linewidth=2)
left.plot(30, measured.illuminance[free].mean(), "o", color="black", label="dimmed scene, measured")
left.set(xlabel="level of the pendants [%]", ylabel="direct illuminance [lx]", title="The working plane as pendants dim",
         xlim=(0, 100), ylim=(0, None))
left.legend(frameon=False, loc="upper left")
left.grid(alpha=0.3)
change = np.where(free, measured.illuminance - answer.illuminance, np.nan)
mesh = right.pcolormesh(plane.points[..., 0], plane.points[..., 1], change, shading="nearest", cmap="viridis")
right.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title="Change of the illuminance at 30 %")
right.set_facecolor("0.8")
figure.colorbar(mesh, ax=right, label="lx", shrink=0.8)
figure.savefig(PLOTS / "dimming.png", dpi=110)

# %%
server.close()
