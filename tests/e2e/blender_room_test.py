#!/usr/bin/python3
"""Checks the room that Blender exported: tests/data/gltf/blender_room.glb, made by scenes/blender/room.py.

    tests/e2e/blender_room_test.py BUILD_DIR

The second half runs Blender.  It is skipped where `blender` is not installed.  Expected levels follow from Blender's
watts by hand: a lamp of P watts has P / (4 pi) W/sr in all directions, also within the cone of a spot.
"""
import ast
import json
import math
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(sys.argv[1]).resolve()
sys.path.insert(0, str(pathlib.Path(__file__).parent))
from server_process import ServerProcess  # noqa: E402

SCRIPT = ROOT / "scenes/blender/room.py"
STORED = ROOT / "tests/data/gltf/blender_room.glb"
NAME = STORED.name
GENERATOR = "Khronos glTF Blender I/O v3.4.50"
BLENDER_S = 600  # ends a Blender that hangs
LM_PER_W = 683
# Blender's numbers are floats, and the server computes with floats: a few times 2^-24.
FLOATS = 2e-6


def numbers_of_the_script():
    """The constants at the top of room.py, which only Blender can import."""
    found = {}
    for statement in ast.parse(SCRIPT.read_text()).body:
        if isinstance(statement, ast.Assign):
            targets = statement.targets[0]
            names = [t.id for t in getattr(targets, "elts", [targets])]
            values = ast.literal_eval(statement.value)
            found.update(zip(names, values if isinstance(values, tuple) else (values,)))
    return found


def document(path):
    """The JSON part of a .glb file."""
    content = path.read_bytes()
    (length,) = struct.unpack("<I", content[12:16])
    return json.loads(content[20 : 20 + length])


def luminance(rgb):
    return 0.2126390058715104 * rgb[0] + 0.7151686787677559 * rgb[1] + 0.0721923153607337 * rgb[2]


def world(x, y, z):
    """Blender's z up as glTF's y up."""
    return f"{x:.9g},{z:.9g},{-y:.9g}"


class StoredFile(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = cls.enterClassContext(ServerProcess(BUILD, ROOT / "scenes"))
        cls.loaded = cls.server.ask("load", "--upload", STORED)
        cls.lights = {light["name"]: light for light in cls.server.ask("lights", NAME)["lights"]}
        cls.script = numbers_of_the_script()

    def assert_near(self, value, expected, what=""):
        self.assertLessEqual(abs(value - expected), FLOATS * abs(expected), f"{what}: {value}, expected {expected}")

    def lux(self, point, normal, *arguments):
        return self.server.ask("irradiance", NAME, "--point", world(*point), "--normal", world(*normal), "--bounces", 0,
                               "--per-light", *arguments)

    def share(self, answer, name):
        return next(s["illuminanceLx"][0] for s in answer["shares"] if s["lightId"] == self.lights[name]["id"])

    def test_comes_from_the_exporter_that_the_page_describes(self):
        self.assertEqual(document(STORED)["asset"]["generator"], GENERATOR)

    def test_everything_in_it_is_modelled(self):
        self.assertEqual(self.loaded["remarks"], [])

    def test_holds_what_the_script_models(self):
        contents = self.server.ask("inspect", "--upload", STORED)["contents"]
        self.assertEqual((contents["objects"], contents["instances"]), ("1", "4"))  # the legs
        self.assertEqual({m["kind"]: m["count"] for m in contents["materials"]}, {"metallic-roughness": "8", "thindielectric": "1"})
        self.assertEqual({(p["width"], p["height"]) for p in contents["pictures"]}, {(16, 16)})
        self.assertEqual(len({p["name"] for p in contents["pictures"]}), 2)
        # Floor, ceiling, 2 walls, pane, leaf, strip: 2 each; far wall 8, leg and block 12 each, the bevelled table 108, and
        # the cube that was divided twice: 6 * 4^2 quadrilaterals.
        self.assertEqual(contents["shapes"], [{"kind": "triangle mesh", "count": "12", "primitives": str(7 * 2 + 8 + 2 * 12 + 108 + 192),
                                                "withoutArea": "0"}])
        with_colours = [m["name"] for m in document(STORED)["meshes"] if "COLOR_0" in m["primitives"][0]["attributes"]]
        self.assertEqual(with_colours, ["Painted block"])

    def test_has_the_lamps_that_gltf_can_hold(self):
        kinds = {name: next(k for k in ("point", "spot", "distant", "diffuseArea") if k in light) for name, light in self.lights.items()}
        self.assertEqual(kinds, {"Bulb": "point", "Moving lamp": "point", "Table lamp": "point", "Spot": "spot", "Sun": "distant", "Strip": "diffuseArea"})

    def test_lamps_have_683_lm_for_each_watt(self):
        watts = {"Bulb": "BULB_W", "Moving lamp": "MOVING_W", "Table lamp": "TABLE_LAMP_W", "Spot": "SPOT_W"}
        for name, key in watts.items():
            light = self.lights[name]
            level = light.get("point", light.get("spot"))["intensityCd"]["r"]  # all colours have red 1
            self.assert_near(level, LM_PER_W * self.script[key] / (4 * math.pi), name)
        self.assert_near(self.lights["Sun"]["distant"]["illuminanceLx"]["r"], LM_PER_W * self.script["SUN_W_M2"], "Sun")
        # The colour counts as RGB, and its luminance as the level.
        self.assert_near(self.lights["Bulb"]["powerLm"], LM_PER_W * self.script["BULB_W"] * luminance((1, 0.8, 0.6)), "Bulb")

    def test_emissive_meshes_have_their_strength_in_candela_per_square_metre(self):
        strip = self.lights["Strip"]
        self.assertFalse(strip["diffuseArea"]["twoSided"])
        self.assert_near(strip["diffuseArea"]["radianceCdM2"]["r"], self.script["STRIP_STRENGTH"])
        level = self.script["STRIP_STRENGTH"] * luminance((1, 0.9, 0.75))
        self.assert_near(strip["powerLm"], math.pi * 1.2 * 0.3 * level)

    def test_blenders_factors_fit_the_strip_to_the_lamps(self):
        room = self.server.ask("load", "--upload", "--blender", "standard", STORED)["sceneId"]
        self.addCleanup(self.server.ask, "release", room)
        lights = {light["name"]: light for light in self.server.ask("lights", room)["lights"]}
        self.assert_near(lights["Strip"]["powerLm"], LM_PER_W * self.lights["Strip"]["powerLm"])
        for name in ("Bulb", "Spot", "Sun"):
            self.assertEqual(lights[name]["powerLm"], self.lights[name]["powerLm"], name)

    def test_the_spot_has_blenders_cones(self):
        spot = self.lights["Spot"]["spot"]
        self.assert_near(spot["coneHalfAngleRad"], math.radians(30))
        self.assert_near(spot["falloffStartRad"], math.radians(30) * (1 - 0.25))

    def test_a_lamp_beneath_an_object_moves_with_it(self):
        p, turn = self.lights["Table lamp"]["point"]["positionM"], math.radians(20)
        self.assert_near(p["x"], 1.2 - 0.4 * math.cos(turn))
        self.assert_near(p["y"], 0.72 + 0.35)
        self.assert_near(p["z"], -(1.9 - 0.4 * math.sin(turn)))

    def test_light_falls_where_the_lamps_are(self):
        bulb = LM_PER_W * self.script["BULB_W"] / (4 * math.pi) * luminance((1, 0.8, 0.6))
        self.assert_near(self.share(self.lux((3.0, 2.2, 0), (0, 0, 1)), "Bulb"), bulb / 2.1**2, "below the bulb")
        # Blender's frame 1 is at 1/24 s.  The lamp goes from x = 0.4 to 3.6 within 24 frames.
        moving = LM_PER_W * self.script["MOVING_W"] / (4 * math.pi)
        below = self.lux((2, 2.6, 0), (0, 0, 1), "--time", 13 / 24)
        # The positions at the frames are floats of 2 m, 0.4 m away.
        self.assertAlmostEqual(self.share(below, "Moving lamp") / (moving / 0.4**2), 1, delta=1e-5)

    def passes(self, start, end):
        """The share of direct light that passes from one point to the other."""
        answer = self.server.ask("visible", NAME, "--point", world(*start), "--to", world(*end))
        return answer["transmittance"][0]

    def test_the_leaf_has_holes(self):
        def across(u, v):
            """Through the point (u, v) of the leaf."""
            x, y, z = 1.5 + 0.25 * u, 1.75 + 0.15 * u + 0.05 * v, 0.75 + 0.45 * v
            return [(x + s * 0.05, y - s * 0.08, z) for s in (1, -1)]

        # Row 4 of the picture, from below, is solid in the columns 6 to 9; row 7 in all columns.
        self.assertEqual(self.passes(*across(0.1, 4.5 / 16)), 1)
        self.assertEqual(self.passes(*across(0.5, 4.5 / 16)), 0)
        self.assertEqual(self.passes(*across(0.1, 7.5 / 16)), 0)

    def test_direct_light_passes_the_pane(self):
        # Both surfaces of a pane of index n reflect by Fresnel's equations.  They let 2 n / (n^2 + 1) pass.
        self.assert_near(self.passes((3, 2.9, 1.5), (3, 3.2, 1.5)), 3 / 3.25)


@unittest.skipUnless(shutil.which("blender"), "blender is not installed")
class FreshExport(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory(prefix="lucerna-blender-")))
        cls.documents = {}
        for mode in ("SPEC", "COMPAT", "RAW"):
            path = folder / f"{mode}.glb"
            command = ["blender", "-b", "--factory-startup", "--python-exit-code", "1", "-P", SCRIPT, "--", path, mode]
            outcome = subprocess.run(command, capture_output=True, text=True, timeout=BLENDER_S, stdin=subprocess.DEVNULL, check=False)
            if outcome.returncode != 0 or not path.exists():
                raise RuntimeError(f"blender fails: {outcome.stdout}{outcome.stderr}")
            cls.documents[mode] = document(path)

    def assert_same(self, a, b, where):
        """Equal but for the last digits of numbers."""
        if isinstance(a, float) or isinstance(b, float):
            self.assertAlmostEqual(a, b, delta=FLOATS * max(1, abs(a)), msg=where)
        elif isinstance(a, dict) and isinstance(b, dict):
            self.assertEqual(sorted(a), sorted(b), where)
            for key, value in a.items():
                self.assert_same(value, b[key], f"{where}/{key}")
        elif isinstance(a, list) and isinstance(b, list):
            self.assertEqual(len(a), len(b), where)
            for i, (x, y) in enumerate(zip(a, b)):
                self.assert_same(x, y, f"{where}/{i}")
        else:
            self.assertEqual(a, b, where)

    def test_is_the_stored_file(self):
        fresh = self.documents["SPEC"]
        if fresh["asset"]["generator"] != GENERATOR:
            self.skipTest(f"this is {fresh['asset']['generator']}")
        self.assert_same(document(STORED), fresh, "")

    def test_the_factors_of_the_page_turn_each_lighting_mode_into_candela(self):
        """The table in docs/gltf.md: standard 1, unitless 683, raw 683 / (4 pi), for suns 683."""
        factors = {"SPEC": (1, 1), "COMPAT": (683, 683), "RAW": (54.35, 683)}
        standard = self.documents["SPEC"]["extensions"]["KHR_lights_punctual"]["lights"]
        strength = None
        for mode, (lamp, sun) in factors.items():
            file = self.documents[mode]
            lights = file["extensions"]["KHR_lights_punctual"]["lights"]
            self.assertEqual([light["name"] for light in lights], [light["name"] for light in standard])
            for a, b in zip(lights, standard):
                factor = sun if a["type"] == "directional" else lamp
                # 54.35 has four digits.
                self.assertAlmostEqual(a["intensity"] * factor / b["intensity"], 1, delta=2e-4, msg=f"{mode}, {a['name']}")
            glow = next(m for m in file["materials"] if m["name"] == "glow")["extensions"]["KHR_materials_emissive_strength"]
            strength = strength or glow
            self.assertEqual(glow, strength, mode)  # no mode has a factor for emission


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
