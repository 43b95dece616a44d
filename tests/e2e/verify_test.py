#!/usr/bin/python3
"""Holds a small renderer with known mistakes against Lucerna, by `lucerna verify`.

    tests/e2e/verify_test.py BUILD_DIR [SHARD SHARDS]

The renderer is docs/examples/python/small_renderer, which shares no code with Lucerna.  With SHARD and SHARDS, only
counts the false alarms of correct files: 1000 seeds in all shards together.
"""
import csv
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(sys.argv[1]).resolve()
SHARD, SHARDS = (int(a) for a in sys.argv[2:4]) if len(sys.argv) > 2 else (None, 1)
sys.path[:0] = [str(ROOT / "docs/examples/python/small_renderer"), str(pathlib.Path(__file__).parent)]
import renderer as small_renderer  # noqa: E402
from server_process import ServerProcess  # noqa: E402

TIMEOUT_S = 900  # ends tests that hang
SEEDS = 1000
# Mistakes that need more samples to show: the densities by area and by solid angle are alike.
ROWS = {"directions": 51200}
# Some mistakes are in quantities that follow from each other; others must not be accused.
KINDS = list(small_renderer.HEADERS)


class WithServer(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory(prefix="lucerna-verify-")))
        small_renderer.write_scene(cls.folder)
        data = ROOT / "tests/data"
        for folder in ("lights", "reference"):
            shutil.copytree(data / folder, cls.folder / folder)
        cls.server = cls.enterClassContext(ServerProcess(BUILD, cls.folder))

    def run_verify(self, *arguments):
        return subprocess.run(
            [BUILD / "bin/lucerna", "--server", self.server.target, "verify", *map(str, arguments)],
            capture_output=True, text=True, timeout=TIMEOUT_S, env=self.server.environment, check=False)

    def verify(self, *arguments, scene="scene.pbrt"):
        """The findings, and the exit status."""
        outcome = self.run_verify(scene, *arguments, "--json")
        self.assertIn(outcome.returncode, (0, 1), outcome.stderr)
        answer = json.loads(outcome.stdout)
        self.assertEqual(answer["differs"], outcome.returncode == 1)
        return answer["findings"]

    def files(self, kinds=KINDS):
        return [word for kind in kinds for word in (f"--{kind}", self.folder / f"{kind}.csv")]

    def write(self, seed, rows=6400, receivers=200, mistake=None, digits=9, only=None):
        small_renderer.write_tables(self.folder, seed, rows, receivers, mistake, digits, only)

    def differing(self, findings):
        return [f for f in findings if f["verdict"] == "differs"]


@unittest.skipIf(SHARD is not None, "only false alarms")
class Verify(WithServer):
    def test_a_correct_renderer_agrees(self):
        for seed in range(2):
            self.write(seed)
            findings = self.verify(*self.files())
            self.assertEqual(self.differing(findings), [])
            judged = {(f["lightName"], f["quantity"]) for f in findings if f["verdict"] == "agrees"}
            # The test sees what it must: each light has its value, and each kind of file its verdict.
            for light in small_renderer.Renderer().names:
                self.assertIn((light, "value"), judged)
            for light, quantity in (("sun", "directions"), ("ball", "integral"), ("bulb", "distance"),
                                    ("panel", "selection"), ("disk", "given density"), ("disk", "emitted power"),
                                    ("spot", "power"), ("panel", "illuminance"), ("", "visibility")):
                self.assertIn((light, quantity), judged)

    def test_every_mistake_is_named(self):
        for name, (what, light, quantity, word) in small_renderer.MISTAKES.items():
            with self.subTest(mistake=name):
                self.write(3, ROWS.get(name, 6400), mistake=name)
                differing = self.differing(self.verify(*self.files()))
                light = "" if light == "all" else light
                found = [f for f in differing if f["lightName"] == light and f["quantity"] == quantity]
                self.assertEqual(len(found), 1, f"{what}: {differing}")
                self.assertIn(word, found[0]["mistake"].split("|"), f"{what}: {found[0]}")
                self.assertNotEqual(found[0]["sentence"], "")
                # No other light is accused.
                self.assertEqual({f["lightName"] for f in differing} - {light}, set()
                                 if name != "selection" else {f["lightName"] for f in differing} - {light})

    def test_the_angle_of_a_rotated_map_is_found(self):
        self.write(4, mistake="rotated_37", only=["samples"])
        sentence = self.differing(self.verify(*self.files(["samples"])))[0]["sentence"]
        degrees = float(sentence.split("about ")[1].split()[0])
        # Texels are 22.5 degrees wide, and a step of the search is half a degree.
        self.assertAlmostEqual(abs(degrees), 37, delta=2, msg=sentence)

    def test_rounded_files_agree(self):
        for seed in range(2):
            self.write(seed, digits=6)
            self.assertEqual(self.differing(self.verify(*self.files())), [])
            # Coordinates to 0.05 mm.  Rays that leave lights must start on them, so they need more.
            self.write(seed, digits=5)
            files = self.files([kind for kind in KINDS if kind != "emission"])
            self.assertEqual(self.differing(self.verify(*files, "--angle", 1e-4)), [])
        # Three digits are too few, and the test sees it.
        self.write(0, digits=3)
        self.assertNotEqual(self.differing(self.verify(*self.files())), [])

    def test_lights_of_every_kind_agree_with_themselves(self):
        """Samples of the server for each light of every_light.pbrt: also beams, portals and panels with profiles."""
        scene = "lights/every_light.pbrt"
        rng = np.random.default_rng(5)
        points = "".join(f"{x},{y},{z}\n" for x, y, z in rng.random((12, 3)) * [3, 3, 1] + [98.5, -51.5, 0.3])
        lights = self.server.ask("lights", scene)["lights"]
        rows = []
        for light in lights:
            answer = self.server.ask("sample", scene, "--light", light["id"], "--points", "-", "--samples", 32,
                                     "--seed", light["id"], stdin=points)
            status = answer.get("status") or ["ITEM_STATUS_OK"] * len(answer["pdfPerSr"])
            places = points.split()
            for i, pdf in enumerate(answer["pdfPerSr"]):
                if status[i] != "ITEM_STATUS_OK":
                    continue
                three = slice(3 * i, 3 * i + 3)
                rows.append([places[i // 32], light["id"], *answer["wi"][three], pdf, *answer["value"][three],
                             answer["distanceM"][i] or "inf"])
        self.assertGreater(len(lights), 25)
        path = self.folder / "own.csv"
        lines = [",".join(map(str, row)) + "\n" for row in rows]
        path.write_text("x,y,z,light,wx,wy,wz,pdf,r,g,b,distance\n" + "".join(lines))
        findings = self.verify("--samples", path, scene=scene)
        self.assertEqual(self.differing(findings), [])
        self.assertEqual({str(f["light"]) for f in findings if f["verdict"] == "agrees"},
                         {r[1] for r in rows})

    def test_distances_to_meshes_and_balls_are_exact(self):
        rng = np.random.default_rng(8)
        (self.folder / "mesh.pbrt").write_text("""WorldBegin
AttributeBegin
AreaLightSource "diffuse" "rgb L" [50 50 50] "string name" "tent"
Shape "trianglemesh" "point3 P" [0 0 3  0 1 3.4  2 1 3.4  2 0 3  2 2 3  0 2 3]
  "integer indices" [0 1 2 0 2 3 1 5 4 1 4 2]
AttributeEnd
""")
        x = rng.random((300, 3)) * [2, 2, 1]
        y = rng.random((300, 2)) * [2, 2]
        p = np.stack([y[:, 0], y[:, 1], 3 + 0.4 * (1 - np.abs(y[:, 1] - 1))], axis=1)
        d = np.linalg.norm(p - x, axis=1)
        for factor, verdict in ((1, "agrees"), (1.0005, "agrees"), (1.002, "differs"), (1.09, "differs")):
            path = self.folder / "tent.csv"
            path.write_text("x,y,z,light,wx,wy,wz,distance\n" + "".join(
                ",".join(f"{v:.9g}" for v in a) + ",tent," + ",".join(f"{v:.9g}" for v in w) + f",{factor * t:.9g}\n"
                for a, w, t in zip(x, (p - x) / d[:, None], d)))
            found = [f for f in self.verify("--samples", path, scene="mesh.pbrt") if f["quantity"] == "distance"]
            self.assertEqual([f["verdict"] for f in found], [verdict], f"{factor}: {found}")
            self.assertAlmostEqual(found[0]["medianError"], factor - 1, delta=1e-5)
            self.assertGreater(found[0]["rows"], 250)
        self.write(3, only=["samples"])
        for f in self.verify(*self.files(["samples"])):
            if f["quantity"] == "distance" and f["rows"] > 0:
                self.assertLess(f["worstError"], 1e-3, f)

    def test_csv_and_numpy_files_have_the_same_answer(self):
        self.write(6, rows=1600)
        with open(self.folder / "samples.csv", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        ids = {light["name"]: int(light["id"]) for light in self.server.ask("lights", "scene.pbrt")["lights"]}
        names = list(rows[0])
        array = np.array([tuple(ids[r[n]] if n == "light" else float(r[n]) for n in names) for r in rows],
                         dtype=[(n, "<i8" if n == "light" else "<f8") for n in names])
        np.save(self.folder / "samples.npy", array)
        by_csv = self.verify("--samples", self.folder / "samples.csv")
        by_npy = self.verify("--samples", self.folder / "samples.npy")
        for a, b in zip(by_csv, by_npy):
            a.pop("where"), b.pop("where")
            self.assertEqual(a, b)
        # A plain array has the order of the page.
        order = "x,y,z,light,wx,wy,wz,pdf".split(",")
        np.save(self.folder / "plain.npy", np.array([[float(row[n]) for n in order] for row in array]))
        plain = self.verify("--samples", self.folder / "plain.npy")
        self.assertEqual({f["quantity"] for f in plain},
                         {"density", "directions", "integral", "Lucerna's directions"})

    def without(self, kind, *columns):
        """A copy of a table without columns."""
        with open(self.folder / f"{kind}.csv", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        path = self.folder / f"short_{kind}.csv"
        names = [n for n in rows[0] if n not in columns]
        path.write_text(",".join(names) + "\n" + "".join(",".join(r[n] for n in names) + "\n" for r in rows))
        return path

    def test_missing_columns_are_done_without(self):
        self.write(7)
        # Without densities, the directions must follow Lucerna's: uniform by area or by solid angle.
        findings = self.verify("--samples", self.without("samples", "pdf", "selection"))
        self.assertEqual({f["quantity"] for f in findings}, {"directions", "value", "distance"})
        of_ball = [f for f in findings if f["lightName"] == "ball" and f["quantity"] == "directions"]
        self.assertEqual(of_ball[0]["verdict"], "agrees")
        # Without lights, rays find them by the distance.  A point or a sky among several has no light then.
        findings = self.verify("--samples", self.without("samples", "light", "selection"))
        self.assertEqual(self.differing(findings), [])
        values = {f["lightName"]: f["rows"] for f in findings if f["quantity"] == "value"}
        self.assertGreater(values["disk"], 100)
        self.assertTrue(any(f["quantity"] == "samples" and f["rowsLeftOut"] > 0 for f in findings))
        # Without standard errors, the noise of the renderer counts as an error.
        findings = self.verify("--irradiance", self.without("irradiance", "stderr"))
        self.assertEqual([f["verdict"] for f in findings if f["lightName"] == "bulb"], ["agrees"])
        self.assertEqual([f["verdict"] for f in findings if f["lightName"] == "panel"], ["differs"])

    def test_the_sum_of_all_lights(self):
        """Illuminances without a light are those of all lights together."""
        points = [(x, y, 0.2) for x in (-1.5, 0.1, 1.3) for y in (-1.1, 1.7)]
        text = "".join(f"{x},{y},{z},0,0,1\n" for x, y, z in points)
        right = self.server.ask("irradiance", "scene.pbrt", "--points", "-", "--bounces", 0, "--samples", 4096,
                                stdin=text)
        for factor, word in ((1, None), (np.pi, "factor_pi")):
            path = self.folder / "sum.csv"
            path.write_text("x,y,z,nx,ny,nz,illuminance,stderr\n" + "".join(
                f"{line},{factor * e},{factor * s}\n" for line, e, s in
                zip(text.split(), right["illuminanceLx"], right["standardErrorLx"])))
            findings = self.verify("--irradiance", path)
            self.assertEqual([f["mistake"] for f in self.differing(findings)], [word] if word else [])

    def test_a_density_must_be_lucernas_only_on_request(self):
        self.write(8)
        findings = self.verify(*self.files(["samples"]), "--same-density")
        of = {(f["lightName"], f["quantity"]): f["verdict"] for f in findings}
        self.assertEqual(of["map", "density"], "differs")
        self.assertEqual(of["panel", "density"], "agrees")

    def test_the_table_is_for_people(self):
        self.write(9, mistake="pi")
        outcome = self.run_verify("scene.pbrt", *self.files())
        self.assertEqual(outcome.returncode, 1)
        self.assertIn("light 10 (panel), value: differs; likely mistake: a factor of pi is too many", outcome.stdout)
        self.assertIn("1 of ", outcome.stdout)
        self.assertIn("samples.csv:", outcome.stdout)
        # As CSV each row also has its mistake, and numbers are in full.
        outcome = self.run_verify("scene.pbrt", *self.files(), "--output", "csv")
        rows = {(r["light"], r["quantity"]): r for r in csv.DictReader(outcome.stdout.splitlines())}
        self.assertEqual(rows["10", "value"]["mistake"], "factor_pi")
        self.assertAlmostEqual(float(rows["10", "value"]["worst error"]), np.pi - 1, delta=1e-5)
        low, mean, high = (float(rows["12", "integral"][f"integral{n}"]) for n in (" low", "", " high"))
        self.assertTrue(low < mean < high)

    def test_wrong_files_are_refused(self):
        head = "x,y,z,light,wx,wy,wz,pdf\n"
        path = self.folder / "wrong.csv"
        for text, message in (
                (head + "0,0,0,panel,0,0,1,-1\n", f"{path}:2:19: pdf = -1, allowed: a finite number of at least 0"),
                (head + "0,0,0,panel,0,0,0,1\n", f"{path}:2:13: wx,wy,wz = 0,0,0, allowed: a direction of any"),
                (head + "0,0,0,17,0,0,1,1\n", f"{path}:2:7: light = 17, allowed: the id of a light of the scene: 1, 2"),
                (head + "0,0,0,pannel,0,0,1,1\n", f"{path}:2:7: light = \"pannel\": no light has this name, allowed:"),
                (head + "0,inf,0,panel,0,0,1,1\n", f"{path}:2:3: y = inf, allowed: a finite number"),
                (head + "0,,0,panel,0,0,1,1\n", f"{path}:2:3: y = nothing, allowed: a finite number"),
                ("x,y,z,wx,wy\n0,0,0,0,0\n", f"{path}: column \"wz\" is missing; samples require x,y,z,wx,wy,wz"),
                ("x,y,z,wx,wy,wz,pfd\n0,0,0,0,0,1,1\n", f"{path}: column \"pfd\" is not known, allowed in samples: x"),
                ("x,y,z,wx,wy,wz,nx\n0,0,0,0,0,1,1\n", f"{path}: column \"ny\" is missing; nx, ny and nz come"),
                (head + "0,0,0,panel,0,0,1,one\n", f"{path}:2:19: pdf = \"one\" is not a number"),
                (head, f"{path}: has no rows")):
            path.write_text(text)
            outcome = self.run_verify("scene.pbrt", "--samples", path)
            self.assertEqual(outcome.returncode, 2, outcome.stderr)
            self.assertIn(message, outcome.stderr)
            self.assertEqual(outcome.stdout, "")
        path.write_text("x,y,z,tx,ty,tz,visible\n0,0,0,1,1,1,2\n")
        outcome = self.run_verify("scene.pbrt", "--visibility", path)
        self.assertIn(f"{path}:2:13: visible = 2, allowed: 0 or 1", outcome.stderr)
        path.write_text("x,y,z,light,wx,wy,wz,pdf,selection\n0,0,0,panel,0,0,1,1,1.5\n")
        outcome = self.run_verify("scene.pbrt", "--samples", path)
        self.assertIn(f"{path}:2:21: selection = 1.5, allowed: a probability in (0, 1]", outcome.stderr)
        path.write_text("light\npanel\n")
        outcome = self.run_verify("scene.pbrt", "--power", path)
        self.assertIn(f"{path}: column \"power\" is missing, or the columns r,g,b", outcome.stderr)
        outcome = self.run_verify("scene.pbrt")
        self.assertEqual(outcome.returncode, 2)
        self.assertIn("verify requires --samples", outcome.stderr)
        outcome = self.run_verify("missing.pbrt", "--power", path)
        self.assertEqual(outcome.returncode, 1)
        # The server still answers.
        self.write(1, only=["power"])
        self.assertEqual(self.differing(self.verify(*self.files(["power"]))), [])


@unittest.skipIf(SHARD is None, "only mistakes")
class FalseAlarms(WithServer):
    def test_correct_files_agree_in_1000_seeds(self):
        """At each level, more alarms than the bound have a chance below 1e-6 (binomial)."""
        self.assertEqual(SEEDS % SHARDS, 0)
        seeds = range(SHARD, SEEDS, SHARDS)
        least = []
        for seed in seeds:
            self.write(10_000 + seed, rows=1600, receivers=100)
            findings = self.verify(*self.files(), "--seed", seed)
            # Rows that are compared exactly never differ.
            self.assertEqual([f for f in self.differing(findings) if "p" not in f], [])
            tests = [f for f in findings if "adjustedP" in f and f["quantity"] != "Lucerna's directions"]
            least.append(min(f["adjustedP"] for f in tests))
            for f in tests:
                if f["adjustedP"] <= 0.001:
                    print(f"seed {seed}: {f}")
        for level in (0.001, 0.05):
            alarms = sum(p <= level for p in least)
            print(f"{alarms} alarms of {len(least)} at level {level}")
            self.assertLessEqual(alarms, bound(len(least), level))


def bound(runs, level):
    """The smallest count that is exceeded with a chance below 1e-6."""
    chance, below, k = (1 - level) ** runs, 0.0, 0
    while True:
        below += chance
        if 1 - below < 1e-6:
            return k
        chance *= (runs - k) / (k + 1) * level / (1 - level)
        k += 1


if __name__ == "__main__":
    os.environ.pop("LUCERNA_SERVER", None)
    unittest.main(argv=sys.argv[:1], verbosity=2)
