#!/usr/bin/python3
"""Checks that lucernad finds its library of pictures where it is installed, and what it says without.

    tests/server/lucernad_pictures_test.py LUCERNAD LUCERNA
"""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

from lucernad import Lucernad, expect

COMMAND_S = 300  # ends tests that hang
SCENES = pathlib.Path(__file__).resolve().parents[1] / "data/reference"
LUCERNAD, LUCERNA = map(pathlib.Path, sys.argv[1:3])


def load(server, scene):
    clean = {k: v for k, v in os.environ.items() if not k.startswith("LUCERNA")}
    return subprocess.run([LUCERNA, "--server", server.address, "load", scene], capture_output=True, text=True,
                          timeout=COMMAND_S, env=clean, check=False)


def main():
    library, = LUCERNAD.parent.glob("lucerna-pictures-*.so")
    with tempfile.TemporaryDirectory() as folder:
        alone = pathlib.Path(folder, "bin/lucernad")
        alone.parent.mkdir()
        shutil.copy(LUCERNAD, alone)
        with Lucernad(alone, "--scene-root", SCENES) as server:
            plain = load(server, "point.pbrt")
            expect(plain.returncode == 0, f"a scene without pictures: {plain.stderr}")
            refused = load(server, "environment.pbrt")
            expect(refused.returncode == 1, "a picture was decoded without the library")
            for text in ("failed_precondition", "this server cannot decode pictures", library.name):
                expect(text in refused.stderr, f"{text!r} is not in: {refused.stderr}")
        # Beside the program, as it was built.
        with Lucernad(LUCERNAD, "--scene-root", SCENES) as server:
            loaded = load(server, "environment.pbrt")
            expect(loaded.returncode == 0, f"a scene with a picture: {loaded.stderr}")


main()
