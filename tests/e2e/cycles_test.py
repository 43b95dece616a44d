#!/usr/bin/python3
"""Holds Cycles, the renderer of Blender, against Lucerna by `lucerna verify`.

    tests/e2e/cycles_test.py BUILD_DIR

docs/examples/blender/illuminance.py renders with Blender.  The test is skipped where `blender` is not installed.
docs/verify.md explains each difference.
"""
import csv
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(sys.argv[1]).resolve()
sys.path.insert(0, str(pathlib.Path(__file__).parent))
from server_process import ServerProcess  # noqa: E402

BLENDER_S = 1200  # ends a Blender that hangs
COMMAND_S = 600
# What `lucerna verify` names; empty: nothing fits; None: the illuminances agree.
FOUND = {
    "point": None,
    "point_with_radius": "",
    "spot_hard": "cosine_light",
    "spot_soft": "cosine_light",
    "area_square": "factor_quarter_pi",
    "area_rectangle": "factor_quarter_pi",
    "area_disk": "factor_quarter_pi",
    "area_ellipse": "factor_quarter_pi",
    "sun_parallel": None,
    "sun_disk": None,
    "ies": "factor_177_83",
    "environment": None,
}


class Cycles(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory(prefix="lucerna-cycles-")))
        blender = ["blender", "--background", "--factory-startup", "--python-exit-code", "1", "--python",
                   str(ROOT / "docs/examples/blender/illuminance.py"), "--", str(cls.folder)]
        subprocess.run(blender, check=True, timeout=BLENDER_S, stdout=subprocess.DEVNULL)
        cls.server = cls.enterClassContext(ServerProcess(BUILD, cls.folder))

    def test_each_light_is_judged(self):
        self.assertEqual({path.stem for path in self.folder.glob("*.pbrt")}, set(FOUND))
        for name, mistake in FOUND.items():
            with self.subTest(light=name):
                outcome = subprocess.run(
                    [BUILD / "bin/lucerna", "--server", self.server.target, "verify", f"{name}.pbrt", "--irradiance",
                     self.folder / f"{name}.csv", "--json"],
                    capture_output=True, text=True, timeout=COMMAND_S, check=False)
                self.assertEqual(outcome.returncode, 0 if mistake is None else 1, outcome.stderr)
                (finding,) = json.loads(outcome.stdout)["findings"]
                self.assertEqual(finding["verdict"], "agrees" if mistake is None else "differs", finding)
                self.assertIn(mistake or "", finding["mistake"].split("|"), finding)

    def test_a_point_lamp_with_a_radius_is_a_disk_that_faces_the_receiver(self):
        """A disk of radius r at a distance d has d2 / (d2 + r2) of the illuminance of a sphere of the same power."""
        radius, place = 0.25, (0.3, -0.2, 1.5)
        ratios = []
        with open(self.folder / "point.csv", newline="") as a, open(self.folder / "point_with_radius.csv",
                                                                    newline="") as b:
            for point, disk in zip(csv.DictReader(a), csv.DictReader(b), strict=True):
                d2 = sum((float(point[k]) - c) ** 2 for k, c in zip("xyz", place))
                share = d2 / (d2 + radius**2)
                ratios.append(float(disk["illuminance"]) / float(point["illuminance"]) / share)
        self.assertEqual(len(ratios), 64)
        for ratio in ratios:
            self.assertAlmostEqual(ratio, 1, delta=2e-3)


if __name__ == "__main__":
    if shutil.which("blender") is None:
        print("blender is not installed")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1], verbosity=2)
