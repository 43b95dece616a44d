"""The notebooks run, with the checks that they contain, and write their plots."""
import os
import shutil
import subprocess
import sys

import pytest
from conftest import ROOT, WAIT_S

NOTEBOOKS = sorted(f.stem for f in (ROOT / "docs/notebooks").glob("*.py"))


@pytest.fixture(scope="module")
def checkout(tmp_path_factory):
    """A folder with the scenes; servers refuse links that lead out of their root."""
    folder = tmp_path_factory.mktemp("checkout")
    shutil.copytree(ROOT / "scenes", folder / "scenes")
    shutil.copytree(ROOT / "tests/data/reference", folder / "tests/data/reference")
    return folder


def test_there_are_notebooks():
    assert {"dimming", "illuminance_map", "renderer", "tradeoff"} <= set(NOTEBOOKS)


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_it_runs_and_draws(checkout, name):
    pytest.importorskip("matplotlib")
    pytest.importorskip("pandas")
    from matplotlib.image import imread
    outcome = subprocess.run([sys.executable, ROOT / f"docs/notebooks/{name}.py"], cwd=checkout, capture_output=True,
                             text=True, timeout=2 * WAIT_S, check=False, env=os.environ | {"MPLBACKEND": "Agg"})
    assert outcome.returncode == 0, outcome.stdout + outcome.stderr
    picture = imread(checkout / f"build/notebooks/{name}.png")
    assert picture.shape[0] > 300 and picture.shape[1] > 500 and picture[..., :3].std() > 0.05


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_it_has_the_percent_format(name):
    lines = (ROOT / f"docs/notebooks/{name}.py").read_text().splitlines()
    assert lines[0] == "# %% [markdown]" and lines[1].startswith("# # ") and lines.count("# %%") >= 4
    assert (ROOT / f"docs/notebooks/{name}.png").is_file()
