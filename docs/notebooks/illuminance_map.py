# %% [markdown]
# # An illuminance map with intervals
#
# How much light reaches the working plane of the room, and how sure is each number?  Run this file in the root of the
# repository with `build/release/bin` on PATH, or open it in an editor that knows cells (`# %%`).

# %%
import pathlib

import lucerna
import numpy as np

PLOTS = pathlib.Path("build/notebooks")
PLOTS.mkdir(parents=True, exist_ok=True)
server = lucerna.local("scenes")
scene = server.load("room/scene.pbrt")

# %% [markdown]
# The working plane is 0.8 m above the floor.  The target error is 10 percent for each point, with up to three
# reflections of the light.

# %%
plane = lucerna.grid((0.5, 0.5, 0.8), (8, 0, 0), (0, 5.5, 0), columns=32, rows=22)
accuracy = lucerna.Accuracy(error=0.1, max_samples=512)
answer = scene.irradiance(plane, accuracy=accuracy, bounces=3)
answer.plot(PLOTS / "illuminance_map.png", title="Illuminance of the working plane")

# %% [markdown]
# Points inside of furniture would have the status INSIDE_SOLID, and are left out.  Points under a lamp's foot or a
# monitor are dark.  The others meet the target, or took all 512 samples.

# %%
counts = answer.status != lucerna.STATUS.index("INSIDE_SOLID")
lux, half = answer.illuminance[counts], (answer.high - answer.low)[counts] / 2
print(f"mean {lux.mean():.0f} lx; a tenth of the points have less than {np.percentile(lux, 10):.0f} lx")
met = half <= 0.1 * lux
print(f"{100 * met.mean():.0f} % of the points met the target; median of the samples {np.median(answer.samples):.0f}")
assert np.all(answer.low <= answer.illuminance) and np.all(answer.illuminance <= answer.high)

# %% [markdown]
# A second seed is a second experiment.  95 percent of the intervals should hold the converged value, so the two answers
# differ by more than both intervals together at few points.

# %%
again = scene.irradiance(plane, accuracy=accuracy, bounces=3, seed=1)
apart = np.abs(again.illuminance - answer.illuminance) > np.hypot(again.high - again.low, answer.high - answer.low) / 2
print(f"{100 * apart.mean():.1f} % of the points differ by more than their intervals")
assert apart.mean() < 0.1

# %%
server.close()
