"""Fixtures of the tests of the Python package.

CMake sets PYTHONPATH to the package of the build tree, and LUCERNAD and LUCERNA_CLI to its programs.
"""
import json
import os
import pathlib
import subprocess

import lucerna
import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]
REFERENCE = ROOT / "tests/data/reference"
WAIT_S = 900  # ends tests that hang


@pytest.fixture(scope="session")
def server():
    """A lucernad with the reference scenes."""
    with lucerna.local(REFERENCE, threads=2, patience=WAIT_S, timeout=WAIT_S) as running:
        yield running


@pytest.fixture(scope="session")
def ask(server):
    """The answer of `lucerna ARGUMENTS --json` as a dictionary."""
    def run(*arguments, points=None):
        text = "" if points is None else "\n".join(",".join(repr(float(x)) for x in row) for row in points)
        outcome = subprocess.run([os.environ["LUCERNA_CLI"], "--server", server.target, *map(str, arguments), "--json"],
                                 input=text, capture_output=True, text=True, timeout=WAIT_S, check=False)
        assert outcome.returncode == 0, outcome.stderr
        return json.loads(outcome.stdout)
    return run


@pytest.fixture(scope="session")
def points():
    """Points above the floor of the reference scenes, shape (40, 3)."""
    return np.random.default_rng(7).uniform((-2, -2, 0.1), (2, 2, 2), (40, 3))


@pytest.fixture(scope="session")
def rectangle(server):
    """A scene with one rectangle light."""
    return server.load("rectangle.pbrt")


@pytest.fixture(scope="session")
def many(server):
    """A scene with four hundred point lights."""
    return server.load("many_points.pbrt")


def floats(values, *shape):
    """Numbers of JSON as the floats that they stand for."""
    return np.array(values, np.float32).reshape(shape)
