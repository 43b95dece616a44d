"""A fixture for pytest: a lucernad for the tests of a session.

In conftest.py:

    pytest_plugins = ["lucerna.pytest_plugin"]

The fixture `lucerna_server` is a `lucerna.LocalServer`.  It starts at the first test that needs it and stops after the
last.  The option lucerna_scene_root of pytest.ini names its scene root, relative to that file; default: its folder.
"""
from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

import lucerna


def pytest_addoption(parser: Any) -> None:
    """Adds the option of pytest.ini."""
    parser.addini("lucerna_scene_root", "scene root of the fixture lucerna_server", default=".")


@pytest.fixture(scope="session")  # type: ignore[misc]
def lucerna_server(request: Any) -> Iterator[lucerna.LocalServer]:
    """A running lucernad; see the module."""
    with lucerna.local(request.config.rootpath / request.config.getini("lucerna_scene_root")) as server:
        yield server
