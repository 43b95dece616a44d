# %% [markdown]
# # A renderer held against Lucerna
#
# The renderer under test is twenty lines of NumPy: it samples a rectangle light uniformly by area.  Lucerna is the
# reference for densities, radiance and illuminance.  The second version has a common mistake: it forgets that the
# density by area must become one by solid angle.  `lucerna verify` tests such claims and names the likely mistake
# (docs/verify.md).  Run this file in the root of the repository with `build/release/bin` on PATH.

# %%
import pathlib

import lucerna
import numpy as np
from matplotlib.figure import Figure

PLOTS = pathlib.Path("build/notebooks")
PLOTS.mkdir(parents=True, exist_ok=True)
SCENE = """
WorldBegin
AreaLightSource "diffuse" "rgb L" [100 100 100]
Shape "bilinearmesh" "point3 P" [-0.8 -0.4 3  -0.8 0.6 3  0.8 -0.4 3  0.8 0.6 3]
"""
(PLOTS / "rectangle.pbrt").write_text(SCENE)
server = lucerna.local(PLOTS)
scene = server.load("rectangle.pbrt")

# %% [markdown]
# The renderer under test.

# %%
CORNER, U, V, RADIANCE = np.array([-0.8, -0.4, 3.0]), np.array([1.6, 0, 0]), np.array([0, 1.0, 0]), 100.0
DOWN = np.array([0, 0, -1.0])


def sample(points, rng, forgets=False):
    """Directions to the light, with their densities [1/sr]."""
    u = rng.random((*points.shape[:-1], 2))
    to_light = CORNER + u[..., :1] * U + u[..., 1:] * V - points
    distance = np.linalg.norm(to_light, axis=-1)
    wi = to_light / distance[..., None]
    density = np.full(distance.shape, 1 / np.linalg.norm(np.cross(U, V)))  # by area [1/m2]
    if not forgets:
        density = density * distance**2 / -(wi @ DOWN)
    return wi, density


def illuminance(points, rng, samples, forgets=False):
    """On a horizontal surface [lx], with the standard error."""
    wi, density = sample(np.repeat(points[:, None], samples, axis=1), rng, forgets)
    value = RADIANCE * wi[..., 2] / density
    return value.mean(axis=1), value.std(axis=1, ddof=1) / np.sqrt(samples)


# %% [markdown]
# Densities of its directions against those of Lucerna, which samples by area too.  The radiance of each direction comes
# from `le`.

# %%
rng = np.random.default_rng(1)
points = np.stack([np.linspace(-4, 4, 2000), np.zeros(2000), np.zeros(2000)], axis=1)
by_area = lucerna.Accuracy(area_sampling="parallelogram")
ratios = {}
for name, forgets in (("correct", False), ("forgets the measure", True)):
    wi, density = sample(points, rng, forgets)
    reference = scene.pdf_li(points, wi, light=1, accuracy=by_area).density
    assert np.allclose(scene.le(points, wi).radiance, RADIANCE)
    ratios[name] = density / reference
    print(f"{name:<20} density / Lucerna's: median {np.median(ratios[name]):.4f}, "
          f"range {ratios[name].min():.4f} to {ratios[name].max():.4f}")
assert np.allclose(ratios["correct"], 1, rtol=1e-4) and not np.allclose(ratios["forgets the measure"], 1, rtol=0.5)

# %% [markdown]
# Illuminance along a line.  Lucerna's answer is exact here: nothing is between the line and the light.

# %%
line = points[::40]
exact = scene.irradiance(line, (0, 0, 1), bounces=0)
assert np.array_equal(exact.low, exact.high)
figure = Figure(figsize=(11, 4.2), layout="constrained")
left, right = figure.subplots(1, 2)
left.plot(line[:, 0], exact.illuminance, color="black", linewidth=1.5, label="Lucerna, exact")
for name, colour, marker in (("correct", "tab:blue", "o"), ("forgets the measure", "tab:red", "s")):
    mean, error = illuminance(line, rng, 256, forgets=name != "correct")
    away = np.abs(mean - exact.illuminance) / error
    print(f"{name:<20} {100 * np.mean(away > 2):.0f} % of the points are more than 2 standard errors away")
    left.errorbar(line[:, 0], mean, 2 * error, fmt=marker, markersize=3, linewidth=1, color=colour, label=name)
    right.plot(points[:, 0], ratios[name], ".", markersize=2, color=colour, label=name)
left.set(xlabel="x [m]", ylabel="illuminance [lx]", title="Illuminance, 256 samples, 2 standard errors", yscale="log")
right.set(xlabel="x [m]", ylabel="density / Lucerna's density", title="Density of its directions", yscale="log")
right.axhline(1, color="black", linewidth=0.8)
for panel in (left, right):
    panel.grid(alpha=0.3)
    panel.legend(frameon=False, markerscale=2)
figure.savefig(PLOTS / "renderer.png", dpi=110)
mean, error = illuminance(line, rng, 256)
assert np.mean(np.abs(mean - exact.illuminance) < 3 * error) > 0.9

# %%
server.close()
