#!/usr/bin/python3
"""Checks the pack that `lucerna conformance` writes.

    tests/e2e/conformance_test.py BUILD_DIR lights|numbers|files

lights: every kind of light of the contract has an ordinary and an extreme case, and every variant has a case.
numbers: tables agree with closed forms.  files: packs are complete, load again, repeat bit by bit, and errors leave
nothing.
"""
import csv
import filecmp
import json
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from server_process import ServerProcess  # noqa: E402

CONTRACT = pathlib.Path(__file__).resolve().parents[2] / "proto/lucerna/v1/light.proto"
TIMEOUT_S = 1800  # ends a program that hangs
FLOAT = 2**-23  # relative spacing of 32-bit floats
TABLES = ("samples", "densities", "emission", "power", "irradiance", "irradiance_intervals", "visibility")
# Cases that verify cannot judge; docs/decisions/064-conformance.md has the reason.
KNOWN = {"infinite_bright_texel"}
FLAT = {"AREA_SHAPE_TRIANGLE_MESH", "AREA_SHAPE_BILINEAR_MESH", "AREA_SHAPE_DISK"}  # may have a profile


def expect(condition, message):
    if not condition:
        sys.exit(str(message))


def run(build, server, *words):
    return subprocess.run([build / "bin/lucerna", *map(str, words)], capture_output=True, text=True, check=False,
                          timeout=TIMEOUT_S, env=os.environ | {"LUCERNA_SERVER": server})


def write_pack(build, folder, *options, server_options=()):
    with tempfile.TemporaryDirectory() as empty, ServerProcess(build, empty, *server_options) as server:
        ran = run(build, server.target, "conformance", folder, *options)
        expect(ran.returncode == 0, ran.stderr)
        expect(json.loads(run(build, server.target, "scenes", "--json").stdout)["scenes"] == [], "scenes stay loaded")
    return json.loads((folder / "manifest.json").read_text())


def read(folder, case, table):
    with open(folder / case / f"{table}.csv", newline="") as file:
        return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file, strict=True)]


def camel(name):
    return re.sub("_(.)", lambda m: m[1].upper(), name)


def lights_of(build, folder, manifest):
    """The light of each case, as the server describes it."""
    found = {}
    with ServerProcess(build, folder) as server:
        for case in manifest["cases"]:
            loaded = server.ask("load", case["scene"])
            expect(loaded["remarks"] == [], f"{case['name']}: {loaded['remarks']}")
            (light,) = server.ask("lights", case["scene"])["lights"]
            found[case["name"]] = light
    return found


def uncovered(manifest, lights):
    """What the contract can describe and no case has."""
    text = CONTRACT.read_text()
    kinds = re.findall(r"^    \w+ (\w+) = \d+;", re.search(r"oneof kind \{(.*?)^  \}", text, re.M | re.S)[1], re.M)
    settings = {(c["kind"], c["setting"]) for c in manifest["cases"]}
    for kind in kinds:
        for setting in ("ordinary", "extreme"):
            if (kind, setting) not in settings:
                yield f"no {setting} case of the light {kind}"
    everything = json.dumps(list(lights.values()))
    # Filters and forms of cones and maps.
    for enum in ("SpotProfile", "SphereMapping", "ImageFilter"):
        for value in re.findall(r"^  (\w+) = [1-9]\d*;", re.search(rf"enum {enum} \{{(.*?)^\}}", text, re.M | re.S)[1], re.M):
            if f'"{value}"' not in everything:
                yield f"no case has {value}"
    for shape in re.findall(r"^  (AREA_SHAPE_\w+) = [1-9]\d*;", text, re.M):
        of_shape = [light["diffuseArea"] for light in lights.values() if light.get("diffuseArea", {}).get("shape") == shape]
        for what, has in (("plain", lambda a: not a.get("image") and not a.get("profile")),
                          ("with a picture", lambda a: a.get("image")),
                          ("with a profile", lambda a: a.get("profile"))):
            if (what != "with a profile" or shape in FLAT) and not any(map(has, of_shape)):
                yield f"no case of {shape}, {what}"
    optional = {"two sides": any(light.get("diffuseArea", {}).get("twoSided") for light in lights.values()),
                "a portal": any(light.get("imageInfinite", {}).get("portalM") for light in lights.values()),
                "a photometric file": any(light.get("goniometric", {}).get("photometricFile") for light in lights.values()),
                "a projected picture": any(light.get("projection", {}).get("image") for light in lights.values()),
                "a beam with a picture": any(light.get("beam", {}).get("image") for light in lights.values())}
    yield from (f"no case has {what}" for what, has in optional.items() if not has)
    for name in ("gltf_point", "gltf_spot", "gltf_directional", "gltf_emissive"):
        if not lights.get(name):
            yield f"no case {name}"


def check_lights(build, folder):
    manifest = write_pack(build, folder, "--samples", 1, "--irradiance-samples", 16)
    lights = lights_of(build, folder, manifest)
    missing = list(uncovered(manifest, lights))
    expect(not missing, "\n".join(missing))
    # A pack without the cases of one kind is not complete.
    for kind in {c["kind"] for c in manifest["cases"]}:
        rest = [c for c in manifest["cases"] if c["kind"] != kind]
        expect(list(uncovered({"cases": rest}, {c["name"]: lights[c["name"]] for c in rest})),
               f"no fault is found without the cases of {kind}")


def close(value, right, tolerance, what):
    expect(abs(value - right) <= tolerance * abs(right), f"{what}: {value}, right: {right}")


def luminance(r, g, b):
    return 0.2126 * r + 0.7152 * g + 0.0722 * b


def power(folder, case):
    (row,) = read(folder, case, "power")
    return row["power"]


def point_lights(folder):
    # I cos / d2 with the numbers of the scene file, which pbrt reads as floats.
    level = luminance(12, 6, 3)
    close(power(folder, "point"), 4 * math.pi * level, 2e-4, "power of the point light")
    for row in read(folder, "point", "irradiance"):
        to = [0.3 - row["x"], -0.2 - row["y"], 3 - row["z"]]
        d = math.hypot(*to)
        cos = sum(a * b for a, b in zip(to, (row["nx"], row["ny"], row["nz"]))) / d
        if cos > 0:
            close(row["illuminance"], level * cos / d**2, 2e-4, f"illuminance of {row}")
        expect(row["stderr"] == 0, row)
    for row in read(folder, "point", "samples"):
        to = [0.3 - row["x"], -0.2 - row["y"], 3 - row["z"]]
        close(row["distance"], math.hypot(*to), 8 * FLOAT, f"distance of {row}")
        close(row["g"], 6 / math.hypot(*to)**2, 16 * FLOAT, f"value of {row}")
        expect(row["pdf"] == 0, row)
    for row in read(folder, "point", "emission"):
        close(row["pdf_direction"], 1 / (4 * math.pi), 4 * FLOAT, f"density of {row}")
    close(power(folder, "gltf_point"), 4 * math.pi * luminance(12, 6, 3), 2e-4, "power of the point light in glTF")


def spots(folder):
    # The smoothstep of the cosine from a to b has the mean (a + b) / 2, so the cone has the solid angle 2 pi (1 - mean).
    mean = (math.cos(math.radians(40)) + math.cos(math.radians(25))) / 2
    close(power(folder, "spot"), 2 * math.pi * luminance(40, 30, 20) * (1 - mean), 2e-4, "power of the spot")
    hard = 2 * math.pi * luminance(40, 30, 20) * (1 - math.cos(math.radians(40)))
    close(power(folder, "spot_hard"), hard, 2e-4, "power of the hard spot")


def areas(folder):
    level = luminance(10, 12, 8)
    for case, flux in (("rectangle", math.pi * level * 1.2 * 0.6), ("triangle", math.pi * level * 1.2 * 1.1 / 2),
                       ("disk", math.pi * level * math.pi * 0.4**2), ("sphere", math.pi * level * 4 * math.pi * 0.35**2),
                       ("cylinder", math.pi * level * 2 * math.pi * 0.1 * 1),
                       ("disk_ring", math.pi * level * math.pi * (0.5**2 - 0.4**2)),
                       ("rectangle_two_sided", 2 * math.pi * 5 * 1.2 * 0.6)):
        close(power(folder, case), flux, 2e-4, f"power of {case}")
    # The illuminance of a sphere on a surface that faces it well: pi L (r/d)2 cos.
    seen = 0
    for row, interval in zip(read(folder, "sphere", "irradiance"), read(folder, "sphere", "irradiance_intervals")):
        to = [0.3 - row["x"], -0.2 - row["y"], 3 - row["z"]]
        d = math.hypot(*to)
        cos = sum(a * b for a, b in zip(to, (row["nx"], row["ny"], row["nz"]))) / d
        if cos > 0.35 / d:
            right = math.pi * level * (0.35 / d)**2 * cos
            # Six standard errors: wrong by luck in 1 of 1e8 cases.
            expect(abs(row["illuminance"] - right) <= 6 * row["stderr"] + 2e-4 * right, f"{row}, right: {right}")
            expect(interval["lower"] <= row["illuminance"] <= interval["upper"], f"{row} {interval}")
            seen += 1
    expect(seen > 8, "too few receivers face the sphere")
    # Uniform in the cone of the sphere.
    for row in read(folder, "sphere", "samples"):
        sine2 = (0.35 / math.hypot(0.3 - row["x"], -0.2 - row["y"], 3 - row["z"]))**2
        solid_angle = 2 * math.pi * sine2 / (1 + math.sqrt(1 - sine2))
        close(row["pdf"], 1 / solid_angle, 2e-5, f"density of {row}")


def infinite_lights(folder):
    for row in read(folder, "infinite", "irradiance"):
        level = luminance(0.5, 0.6, 0.7)
        # The floor hides the lower half of the sky from tilted surfaces.
        if row["nz"] == 1:
            expect(abs(row["illuminance"] - math.pi * level) <= 6 * row["stderr"] + 2e-4 * math.pi * level, row)
    axis = [c / math.sqrt(14) for c in (1, -2, 3)]
    for row in read(folder, "distant", "irradiance"):
        cos = sum(a * b for a, b in zip(axis, (row["nx"], row["ny"], row["nz"])))
        close(row["illuminance"], luminance(2, 3, 4) * max(cos, 0), 2e-4, f"illuminance of {row}")
    expect(all(row["distance"] == math.inf for row in read(folder, "sun", "samples")), "the sun has a distance")


def visibility(folder):
    for row in read(folder, "point", "visibility"):
        expect(row["visible"] == (1 if row["tz"] > 0 else 0), f"the floor does not hide {row}")


def densities_of_samples(folder, manifest):
    """The densities of the samples' directions are those of the samples."""
    for case in manifest["cases"]:
        if case["setting"] == "extreme":
            continue  # rounded directions may miss the light
        samples, densities = read(folder, case["name"], "samples"), read(folder, case["name"], "densities")
        expect(len(densities) == len(samples) + 16 * 32, f"{case['name']}: {len(densities)} densities")
        # At the silhouette of a curved light the density grows without limit, and rounding the direction changes it.
        off = sum(abs(s["pdf"] - d["pdf"]) > 1e-3 * s["pdf"] for s, d in zip(samples, densities))
        expect(off <= 0.03 * len(samples), f"{case['name']}: {off} of {len(samples)} densities differ from the samples")


def verify_agrees(build, folder, manifest):
    """`lucerna verify` reads the tables, and finds no difference."""
    with ServerProcess(build, folder) as server:
        for case in manifest["cases"]:
            if case["name"] in KNOWN:
                continue
            files = [word for table in ("samples", "densities", "emission", "power", "irradiance", "visibility")
                     for word in (f"--{table}", folder / case["name"] / f"{table}.csv")]
            ran = run(build, server.target, "verify", case["scene"], *files)
            expect(ran.returncode == 0, f"{case['name']}: {ran.stdout}{ran.stderr}")


def check_numbers(build, folder):
    manifest = write_pack(build, folder)
    verify_agrees(build, folder, manifest)
    point_lights(folder)
    spots(folder)
    areas(folder)
    infinite_lights(folder)
    visibility(folder)
    densities_of_samples(folder, manifest)


def files_of(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def check_files(build, folder):
    first, second = folder / "first", folder / "second"
    options = ("--samples", 4, "--irradiance-samples", 64)
    manifest = write_pack(build, first, *options)
    write_pack(build, second, *options, server_options=("--max-batch-items", "1024"))
    names = files_of(first)
    expect(names == files_of(second), "two packs have different files")
    _, different, broken = filecmp.cmpfiles(first, second, names, shallow=False)
    expect(not different and not broken, f"two packs differ in {different + broken}")
    for case in manifest["cases"]:
        for table in TABLES:
            expect(f"{case['name']}/{table}.csv" in names, f"{case['name']} has no {table}.csv")
            rows = read(first, case["name"], table)
            expect(rows and all(len(row) == len(rows[0]) for row in rows), f"{case['name']}/{table}.csv: {rows[:2]}")
    readme = (first / "README.md").read_text()
    for column in {name for table in TABLES for name in read(first, "point", table)[0]}:
        expect(f"`{column}`" in readme, f"the README of the pack does not explain {column}")

    with tempfile.TemporaryDirectory() as empty, ServerProcess(build, empty) as server:
        ran = run(build, server.target, "conformance", first)
        expect(ran.returncode == 2 and "exists; name a new folder, or an empty one" in ran.stderr, ran)
        expect(files_of(first) == names, "a pack that exists has changed")
        ran = run(build, server.target, "conformance", "/proc/pack")
        expect(ran.returncode == 2 and "cannot be made" in ran.stderr, ran)
        target = server.target
    ran = run(build, target, "conformance", folder / "third")
    expect(ran.returncode == 1 and "cannot reach a server" in ran.stderr, ran)
    expect(sorted(os.listdir(folder)) == ["first", "second"], f"left behind: {os.listdir(folder)}")


def main():
    build = pathlib.Path(sys.argv[1]).resolve()
    checks = {"lights": check_lights, "numbers": check_numbers, "files": check_files}
    with tempfile.TemporaryDirectory() as directory:
        folder = pathlib.Path(directory, "pack")
        if sys.argv[2] == "files":
            folder.mkdir()
        checks[sys.argv[2]](build, folder)


main()
