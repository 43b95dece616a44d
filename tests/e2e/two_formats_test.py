#!/usr/bin/python3
"""Compares the answers for one room in two formats: scenes/two_formats/scene.pbrt and scene.gltf.

    tests/e2e/two_formats_test.py BUILD_DIR STUBS_DIR

STUBS_DIR has Python's stubs of the API.  The files are not equal to the last bit, and answers may differ by this:

- scenes/two_formats/make.py rounds quaternions and radians in scene.gltf to 1e-9.  scene.pbrt has degrees.  A light
  turns by less than 2e-9 rad then, so a point 3 m away moves by 6e-9 m in the beam.
- Coordinates and lights become floats, rounded to 2^-24 = 6e-8 of their values, 4 m at most.  So a
  point may be 2.4e-7 m away.  Distances here are 0.3 m and more: 8e-7 of the distance, 1.6e-6 of the illuminance.
- The edge of the spot falls over a range of cosines of 0.045.  Floats of 1 are 6e-8 apart: 1.3e-6 of the range, and
  twice as much of the intensity in the middle of the edge.
- The steepest part of the IES file changes by 1 % for 0.1 degrees, so 1e-7 rad change 1e-6 of its candela.

So FILES = 1e-5 is ample, and every wrong unit, angle or mirror is far beyond it.
"""
import array
import math
import pathlib
import sys
import unittest

import grpc

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD, STUBS = (pathlib.Path(a).resolve() for a in sys.argv[1:3])
sys.path[:0] = [str(STUBS), str(pathlib.Path(__file__).parent)]
from lucerna.v1 import accuracy_pb2, render_pb2, render_pb2_grpc  # noqa: E402
from server_process import ServerProcess  # noqa: E402

FILES = 1e-5
PBRT, GLTF = "two_formats/scene.pbrt", "two_formats/scene.gltf"
# x, y, z and normal: the floor, the table, the right wall, and a point under the leaf.
POINTS = [(0.35 + 0.66 * i, 0, 0.4 + 0.6 * j, 0, 1, 0) for i in range(6) for j in range(5)]
POINTS += [(1.5 + 0.2 * i, 0.74, 1.0 + 0.17 * j, 0, 1, 0) for i in range(5) for j in range(3)]
POINTS += [(4, 0.4 + 0.6 * i, 0.5 + 0.7 * j, -1, 0, 0) for i in range(4) for j in range(4)]
# The window behind the leaf, the red wall, an edge of a stool, and the tiles of the floor.
TILES = [(448, 330), (8, 360), (672, 480), (160, 620)]
TILE_SIZE = 32


class TwoFormats(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = cls.enterClassContext(ServerProcess(BUILD, ROOT / "scenes"))
        cls.loaded = {path: cls.server.ask("load", path) for path in (PBRT, GLTF)}

    def both(self, *arguments, stdin=""):
        return [self.server.ask(arguments[0], path, *arguments[1:], stdin=stdin) for path in (PBRT, GLTF)]

    def irradiance(self, *arguments):
        points = "".join(",".join(f"{x:g}" for x in point) + "\n" for point in POINTS)
        return self.both("irradiance", "--points", "-", *arguments, stdin=points)

    def assert_near(self, a, b, what, relative=FILES, absolute=0.0):
        self.assertLessEqual(abs(a - b), relative * max(abs(a), abs(b)) + absolute, f"{what}: {a} and {b}")

    def test_everything_in_both_files_is_modelled(self):
        for path, answer in self.loaded.items():
            self.assertEqual(answer["remarks"], [], path)

    def test_lights_have_the_same_names_and_powers(self):
        lights = [{light["name"]: light for light in answer["lights"]} for answer in self.both("lights")]
        self.assertEqual(sorted(lights[0]), ["bulb", "panel", "spot", "sun", "wallwasher"])
        self.assertEqual(sorted(lights[1]), sorted(lights[0]))
        for name, of_pbrt in lights[0].items():
            self.assert_near(of_pbrt["powerLm"], lights[1][name]["powerLm"], name)
        # Levels by hand.
        level = 0.2126390058715104 * 800 + 0.7151686787677559 * 720 + 0.0721923153607337 * 640
        self.assert_near(lights[0]["panel"]["powerLm"], math.pi * 0.6 * level, "panel")
        level = 40 * (0.2126390058715104 + 0.7151686787677559 * 0.8 + 0.0721923153607337 * 0.55)
        self.assert_near(lights[1]["bulb"]["powerLm"], 4 * math.pi * level, "bulb")

    def test_direct_light_of_each_light_is_the_same(self):
        answers = self.irradiance("--bounces", 0, "--per-light", "--seed", 1)
        self.assertEqual(len(answers[0]["illuminanceLx"]), len(POINTS))
        names = [{light["id"]: light["name"] for light in answer["lights"]} for answer in self.both("lights")]
        shares = [{of[s["lightId"]]: s for s in a["shares"]} for of, a in zip(names, answers)]
        self.assertEqual(sorted(shares[0]), sorted(shares[1]))
        exact = dict.fromkeys(shares[0], 0)
        for name, of_pbrt in shares[0].items():
            of_gltf = shares[1][name]
            for i, point in enumerate(POINTS):
                a, b = of_pbrt["illuminanceLx"][i], of_gltf["illuminanceLx"][i]
                errors = of_pbrt["standardErrorLx"][i], of_gltf["standardErrorLx"][i]
                if errors == (0, 0):
                    exact[name] += a > 0
                    self.assert_near(a, b, f"{name} at {point}")
                else:
                    self.assert_near(a, b, f"{name} at {point}", FILES, self.combined(of_pbrt, of_gltf, i))
        # Each light reaches some points, without random error.
        for name, count in exact.items():
            self.assertGreater(count, 1 if name == "sun" else 3, name)

    @staticmethod
    def combined(a, b, i):
        """How far two answers may be apart so that each is within the other's interval, added as errors are."""
        half = [max(x["upperLx"][i] - x["illuminanceLx"][i], x["illuminanceLx"][i] - x["lowerLx"][i]) for x in (a, b)]
        return math.hypot(*half)

    def test_light_with_reflections_is_the_same_within_the_intervals(self):
        """The seeds are equal.  So the paths are too, but for those that a rounding error sends elsewhere."""
        a, b = self.irradiance("--samples", 512, "--seed", 2)
        for i, point in enumerate(POINTS):
            self.assertGreater(a["lowerLx"][i], 0, point)
            self.assert_near(a["illuminanceLx"][i], b["illuminanceLx"][i], point, 0, self.combined(a, b, i))
        # A per cent or two shows in the mean of all points.
        n = len(POINTS)
        error = math.sqrt(sum(self.combined(a, b, i) ** 2 for i in range(n))) / n
        means = [sum(answer["illuminanceLx"]) / n for answer in (a, b)]
        self.assertLess(error, 0.03 * means[0])
        self.assert_near(*means, "mean of all points", 0, error)

    def tile(self, path, x0, y0):
        """Means of blocks of 8 by 8 pixels and of the tile, with squared standard errors, by place and channel."""
        with grpc.insecure_channel(self.server.target) as channel:
            request = render_pb2.RenderTileRequest(
                scene_id=self.loaded[path]["sceneId"],
                rect=render_pb2.PixelRect(x0=x0, y0=y0, x1=x0 + TILE_SIZE, y1=y0 + TILE_SIZE),
                seed=3,
                bounces=3,
                accuracy=accuracy_pb2.Accuracy(samples=64),
            )
            tile = render_pb2_grpc.RenderServiceStub(channel).RenderTile(request, timeout=900).tile
        self.assertEqual((tile.image_width, tile.image_height), (960, 720))
        sums, deviations, n = array.array("d", tile.sum), array.array("d", tile.deviation), tile.block_count
        means = {}
        for i, (total, deviation) in enumerate(zip(sums, deviations)):
            pixel, channel = divmod(i, 3)
            row, column = divmod(pixel, TILE_SIZE)
            for place, pixels in (((column // 8, row // 8), 64), ("all", TILE_SIZE**2)):
                mean, variance = means.get((place, channel), (0, 0))
                variance += deviation / (n * (n - 1)) / pixels**2
                means[place, channel] = mean + total / n / pixels, variance
        return means

    def test_tiles_of_the_picture_are_the_same_within_their_errors(self):
        """By luck, a mean of pixels differs by more than six combined standard errors in 2e-9 of all cases."""
        for place in TILES:
            a, b = self.tile(PBRT, *place), self.tile(GLTF, *place)
            self.assertEqual(len(a), 51)
            for key, (mean, variance) in a.items():
                what = f"tile {place}, {key}"
                self.assertGreater(mean, 0, what)
                self.assert_near(mean, b[key][0], what, 0, 6 * math.sqrt(variance + b[key][1]))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
