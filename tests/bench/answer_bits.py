#!/usr/bin/python3
"""Writes down the bits of many answers of a build, or compares two such records.

    tests/bench/answer_bits.py record BUILD RECORD [FOLDER ...] [--few] [--threads 2]
    tests/bench/answer_bits.py compare BEFORE NOW

BUILD is a build folder with bin/lucernad; the contract is that of this checkout.  The scenes are all scene files in the
folders, by default scenes and tests/data.  Each scene gets every query with many settings.  `--few`, and a scene of
many primitives, leaves out settings that take long or differ little.  A record is JSON: for each query a digest of its
answer, or the text of its error.  Not part of a digest are costs, bytes, and build steps of a scene.  Queries with a
time budget are left out, since their number of samples differs from run to run.
`compare` prints each answer that differs or that only one record has, and exits with 1 if there is one.
Needs python3-grpcio, python3-protobuf, protobuf-compiler and NumPy.
"""
import argparse
import concurrent.futures
import hashlib
import json
import pathlib
import sys
import tempfile

import grpc
import numpy as np

from compare_builds import ROOT, Server, messages

FOLDERS = [ROOT / "scenes", ROOT / "tests/data"]
SCENE_FILES = (".pbrt", ".gltf", ".glb")
SERVERS = 2  # at once; each has its own Python process
POINTS = 8  # of each of two kinds: seen by the camera, and anywhere in the scene
MANY_PRIMITIVES = 20000
LIGHTS = 3  # of a scene, or more: one of each sort
PICTURE = 1 << 17  # most pixels of a whole picture
WAVES = [450.0, 550.0, 650.0]
LEASE_S = 3600.0
# Fields that may differ between equal answers, by message.  `cost` is left out everywhere.
LOAD = {"already_loaded", "lease_id", "lease_s"}
LEFT_OUT = {
    "ItemCosts": {"rays", "time_s"}, "LoadSceneResponse": LOAD, "EditLightsResponse": LOAD,
    "GetSceneResponse": {"parts"}, "SceneSummary": {"path", "leased_s", "bytes", "own_bytes"},
    "RenderImageResponse": {"samples_done"}, "ListAvailableScenesResponse": {"root"},
    "GetServerInfoResponse": {"version", "threads"},
}


def clear(message):
    for field, value in message.ListFields():
        if field.name == "cost" or field.name in LEFT_OUT.get(message.DESCRIPTOR.name, ()):
            message.ClearField(field.name)
        elif field.message_type:
            for part in value if field.label == field.LABEL_REPEATED else [value]:
                clear(part)


def digest(*answers):
    """Of messages in any order, which it changes."""
    parts = []
    for answer in answers:
        clear(answer)
        parts.append(hashlib.sha256(answer.SerializeToString(deterministic=True)).digest())
    return hashlib.sha256(b"".join(sorted(parts))).hexdigest()[:32]


class Scene:
    """Asks the queries about one scene, and keeps their answers' digests."""

    def __init__(self, server, few):
        from lucerna.v1 import admin_pb2, lighting_pb2, render_pb2, scene_pb2
        self.modules = {"Admin": admin_pb2, "Lighting": lighting_pb2, "Render": render_pb2, "Scene": scene_pb2}
        self.server, self.few, self.found = server, few, {}

    def call(self, service, call, **fields):
        module = self.modules[service]
        request, response = (getattr(module, call + kind) for kind in ("Request", "Response"))
        how = self.server.stream if call == "RenderImage" else self.server.call
        return how(f"{service}Service/{call}", request(**fields), response)

    def ask(self, service, call, label="", **fields):
        """The answer, whose digest it keeps; None after an error, and for a stream."""
        name = f"{call} {label}".strip()
        assert name not in self.found, name
        try:
            answer = self.call(service, call, **fields)
            if call == "RenderImage":
                self.found[name] = digest(*answer)
                return None
        except grpc.RpcError as error:
            if error.code() in (grpc.StatusCode.DEADLINE_EXCEEDED, grpc.StatusCode.UNAVAILABLE):
                raise
            self.found[name] = f"{error.code().name}: {error.details()}"
            return None
        copy = type(answer)()
        copy.CopyFrom(answer)
        self.found[name] = digest(copy)
        return answer

    def of_server(self):
        self.ask("Admin", "GetServerInfo")
        self.ask("Scene", "ListAvailableScenes", page_size=5)
        return self.found

    def answers(self, path):
        """The digests of the scene file's answers."""
        loaded = self.ask("Scene", "LoadScene", path=path, lease_s=LEASE_S)
        asset = {"name": path, "sha256": bytes(32)}
        self.ask("Scene", "LoadScene", "uploaded", manifest={"main": path, "assets": [asset]})
        if path.endswith(("gltf", "glb")):
            blender = self.ask("Scene", "LoadScene", "blender", path=path, lease_s=LEASE_S, blender={"mode": 1})
            if blender:
                self.revision(blender, "blender")
        if loaded:
            self.scene(loaded)
        return self.found

    def scene(self, loaded):
        got = self.ask("Scene", "GetScene", scene_id=loaded.scene_id)
        self.few = self.few or got.summary.primitives > MANY_PRIMITIVES
        lights = self.ask("Scene", "ListLights", scene_id=loaded.scene_id).lights
        self.prepare(loaded.scene_id, got.summary)
        self.irradiance(loaded.scene_id)
        self.pictures(loaded.scene_id, got.summary)
        self.rays(loaded.scene_id)
        named = chosen(lights)
        self.samples(loaded.scene_id, [light.id for light in named])
        self.powers(loaded.scene_id, [light.id for light in named])
        self.edits(loaded.scene_id, got.summary, named)
        self.release(loaded)

    def release(self, loaded):
        self.call("Scene", "ReleaseScene", scene_id=loaded.scene_id, lease_id=loaded.lease_id)

    def prepare(self, scene, summary):
        """Makes receivers and directions."""
        random = np.random.default_rng(1)
        radius = summary.radius_m if 0 < summary.radius_m < 1e30 else 1
        width, height = max(1, summary.image_width), max(1, summary.image_height)
        self.rect = {"x0": width // 3, "y0": height // 3,
                     "x1": min(width, width // 3 + 8), "y1": min(height, height // 3 + 6)}
        places = (random.uniform(0, 1, (POINTS, 2)) * (width, height)).ravel()
        seen = self.ask("Render", "FindSurfaces", scene_id=scene, places=places)
        self.ask("Render", "FindSurfaces", "later", scene_id=scene, places=places, time_s=0.3)
        self.ask("Render", "FindSurfaces", "beside", scene_id=scene,
                 places=[-1, 0, width + 1, 2, float("nan"), 0, 0, 0])

        def floats(*arrays):
            return np.concatenate([np.ravel(a) for a in arrays]).astype(np.float32)

        def directions(n):
            d = random.normal(size=(n, 3))
            return d / np.linalg.norm(d, axis=1, keepdims=True)

        origin = summary.origin_m
        center = np.array([summary.center_m.x - origin.x, summary.center_m.y - origin.y, summary.center_m.z - origin.z])

        def points(n):
            return np.clip(center + 0.8 * radius * random.uniform(-1, 1, (n, 3)), -3e38, 3e38)

        hits = np.array([i for i in range(POINTS) if seen and seen.found[i // 8] >> i % 8 & 1], int)
        on = np.reshape(seen.points.offsets_m if seen else [], (-1, 3))[hits]
        up = np.reshape(seen.normals if seen else [], (-1, 3))[hits]
        bad = [[np.nan, 0, 0], [3e38, 0, 0]]
        n = len(hits) + POINTS + len(bad)
        self.at = {"origin_m": origin, "offsets_m": floats(on, points(POINTS), bad)}
        self.to = {"origin_m": origin, "offsets_m": floats(points(n))}
        self.normals = floats(up, directions(POINTS), directions(len(bad)))
        self.wi = floats(directions(n))
        self.u = random.uniform(0, 1, 2 * n).astype(np.float32)
        self.u_light = random.uniform(0, 1, n)
        self.n = n

    def settings(self):
        """Name and settings of methods; the first few for scenes of which little is asked."""
        common = {
            "": {"samples": 16}, "uniform": {"light_selection": 2}, "power": {"light_selection": 3},
            "bvh": {"light_selection": 4}, "independent": {"sampler": 2}, "lights": {"combination": 3},
            "open": {"closed_forms": 1},
        }
        more = {
            "maps": {"visibility": 2},
            "1 sample": {"samples": 1}, "100 samples": {"samples": 100}, "all": {"light_selection": 1},
            "balance": {"combination": 2}, "surfaces": {"combination": 4}, "shafts": {"closed_forms": 2},
            "glass blocks": {"thin_glass": 2}, "3 points": {"samples_per_light": 3}, "far": {"far_light_radii": 2.0},
            **{f"area {i}": {"area_sampling": i} for i in range(1, 8)},
        }
        chosen_settings = common if self.few else {**common, **more}
        return {name: {"samples": 16, **fields} for name, fields in chosen_settings.items()}

    def target(self, relative=0.1, most=256, **more):
        return {"target_error": {"relative": relative, "max_samples": most, **more}}

    def irradiance(self, scene):
        fields = {"scene_id": scene, "receivers": self.at, "normals": self.normals, "seed": {"seed": 7}}

        def ask(label, **more):
            self.ask("Lighting", "EstimateIrradiance", label, **{**fields, **more})

        for name, settings in self.settings().items():
            ask(f"direct {name}", bounces=0, accuracy=settings)
            if not self.few or not name:
                ask(f"all bounces {name}", accuracy=settings)
        some = {"samples": 16}
        ask("shares", bounces=0, per_light=True, accuracy=some)
        ask("spectral", bounces=0, wavelengths_nm=WAVES, accuracy=some)
        ask("later", time_s=0.3, accuracy=some)
        ask("target", bounces=0, accuracy=self.target(0.02, 1024))
        if self.few:
            return
        ask("one bounce", bounces=1, accuracy=some)
        ask("all bounces shares", per_light=True, accuracy=some)
        ask("all bounces target", accuracy=self.target())
        ask("target shares", bounces=0, per_light=True, wavelengths_nm=WAVES, accuracy=self.target(confidence=0.8))
        ask("open target", bounces=0, accuracy={**self.target(), "closed_forms": 1})
        ask("defaults", bounces=0)
        ask("another seed", seed={"seed": 1 << 40, "first_item": 5}, position_error_m=1e-3, accuracy=some)
        ask("no normals", normals=[])
        ask("no samples", accuracy={"samples": 0})
        ask("spectral bounces", wavelengths_nm=WAVES)

    def pictures(self, scene, summary):
        fields = {"scene_id": scene, "rect": self.rect, "seed": 7}

        def ask(label, **more):
            self.ask("Render", "RenderTile", label, **{**fields, **more})

        for name, settings in self.settings().items():
            ask(name, accuracy=settings)
        some = {"samples": 16}
        ask("one sequence", one_sequence=True, accuracy=some)
        ask("intervals", intervals=True, accuracy=some)
        ask("target", accuracy=self.target())
        if self.few:
            return
        ask("direct", bounces=0, accuracy=some)
        ask("later", time_s=0.3, accuracy=some)
        ask("shutter", shutter={"offset_s": 0.1, "length_s": 0.2}, accuracy=some)
        ask("second run", first_sample=16, samples_per_block=4, accuracy=some)
        ask("outside", rect={"x1": 1 << 20, "y1": 1})
        if summary.image_width * summary.image_height <= PICTURE:
            self.ask("Render", "RenderImage", scene_id=scene, final_only=True, accuracy={"samples": 1})

    def rays(self, scene):
        segments = {"from": self.at, "to": self.to}

        def visibility(label, **more):
            self.ask("Lighting", "TestVisibility", label, scene_id=scene, **more)

        def le(label, **more):
            self.ask("Lighting", "Le", label, scene_id=scene, points=self.at, directions=self.wi, **more)

        visibility("segments", segments=segments)
        visibility("off surfaces", segments=segments, normals=self.normals)
        visibility("rays", rays={"from": self.at, "directions": self.wi}, time_s=0.3)
        visibility("glass blocks", rays={"from": self.at, "directions": self.wi, "lengths_m": [3] * self.n},
                   position_error_m=1e-3, accuracy={"thin_glass": 2})
        le("", wavelengths_nm=WAVES)
        le("later", time_s=0.3)
        le("glass blocks", accuracy={"thin_glass": 2})

    def samples(self, scene, lights):
        seed = {"seed": 7}
        at = {"scene_id": scene, "receivers": self.at}

        def li(label, **more):
            self.ask("Lighting", "SampleLi", label, **{**at, "seed": seed, **more})

        def le(label, **more):
            self.ask("Lighting", "SampleLe", label, scene_id=scene, count=self.n, **more)

        for name, settings in self.settings().items():
            li(name, normals=self.normals, test_visibility=True, accuracy={**settings, "samples": 2})
        li("spectral", wavelengths_nm=WAVES)
        li("target", normals=self.normals, test_visibility=True, wavelengths_nm=WAVES, accuracy=self.target())
        li("free space", test_visibility=True, time_s=0.3, position_error_m=1e-3, accuracy=self.target())
        u = {"u": self.u, "u_light": self.u_light}
        self.ask("Lighting", "SampleLi", "own values", **at, u=u)
        le("", seed=seed, wavelengths_nm=WAVES)
        le("own values", u={"u": np.concatenate([self.u, self.u]), "u_light": self.u_light}, time_s=0.3)
        for light in [*lights, 1 << 60]:
            which = {"light_id": light}
            li(f"light {light}", normals=self.normals, test_visibility=True, wavelengths_nm=WAVES, **which)
            li(f"light {light} later", accuracy={"samples": 4}, time_s=0.3, **which)
            for way in (0, 7) if self.few else range(8):
                self.ask("Lighting", "PdfLi", f"light {light} area {way}", **at, wi=self.wi, normals=self.normals,
                         accuracy={"area_sampling": way}, **which)
            self.light_rays(scene, light)

    def light_rays(self, scene, light):
        """Rays of a light; densities of rays that it emits and of others; densities of its samples."""
        which = {"scene_id": scene, "light_id": light}
        rays = self.ask("Lighting", "SampleLe", f"light {light}", count=self.n, seed={"seed": 7}, time_s=0.3,
                        wavelengths_nm=WAVES, **which)
        self.ask("Lighting", "PdfLe", f"light {light}", points=self.at, directions=self.wi, **which)
        self.ask("Lighting", "Le", f"light {light}", points=self.at, directions=self.wi, wavelengths_nm=WAVES, **which)
        if rays:
            self.ask("Lighting", "PdfLe", f"light {light} its rays", points=rays.points, directions=rays.directions,
                     time_s=0.3, **which)
            sampled = self.call("Lighting", "SampleLi", receivers=self.at, seed={"seed": 9}, **which)
            self.ask("Lighting", "PdfLi", f"light {light} its samples", receivers=self.at, wi=sampled.wi, **which)
            self.ask("Lighting", "Le", f"light {light} its samples", points=self.at, directions=sampled.wi,
                     wavelengths_nm=WAVES, **which)
            self.ask("Lighting", "TestVisibility", f"light {light}", scene_id=scene,
                     rays={"from": self.at, "directions": sampled.wi})

    def powers(self, scene, lights):
        for method in range(1, 4):
            self.ask("Lighting", "EstimatePower", f"method {method}", scene_id=scene, method=method, seed=7,
                     wavelengths_nm=WAVES, accuracy={"samples": 64}, page_size=100)
        self.ask("Lighting", "EstimatePower", "of lights", scene_id=scene, light_ids=lights, method=3, seed=7,
                 accuracy=self.target())
        self.ask("Lighting", "EstimatePower", "of one twice", scene_id=scene, light_ids=[1, 1, 1 << 60])

    def edits(self, scene, summary, lights):
        """Revisions of the scene, and what is asked of them."""
        c, r = summary.center_m, summary.radius_m if 0 < summary.radius_m < 1e30 else 1
        level = {"r": 3, "g": 2, "b": 1}
        at = {"x": c.x, "y": c.y, "z": c.z + 0.4 * r}
        put = [
            {"point": {"position_m": at, "intensity_cd": level}, "name": "new", "samples_per_light": 2},
            *({"spot": {"position_m": at, "axis": {"x": 0.1, "z": -2}, "intensity_cd": level, "profile": profile,
                        "cone_half_angle_rad": 1.2, "falloff_start_rad": 0.4}} for profile in range(4)),
            {"distant": {"to_light": {"y": 0.2, "z": 1}, "illuminance_lx": level}},
            {"sun": {"to_light": {"x": 0.3, "z": 1}, "illuminance_lx": level, "angular_diameter_rad": 0.01}},
            {"uniform_infinite": {"radiance_cd_m2": level}},
        ]
        changes = {
            "scale": {"scale": 0.5}, "tint": {"tint": level}, "off": {"on": False},
            "shift": {"placement": {"shift_m": {"z": -0.01 * r}}},
            "turn": {"placement": {"turn_axis": {"x": 1, "z": 1}, "turn_rad": 0.5}},
        }
        edits = {"put": [{"put": light} for light in put], "add": [{"add": {"path": summary.path}}]}
        for change, fields in changes.items():
            movable = [x for x in lights if not x.HasField("motion") and (x.HasField("bounds") or change != "shift")]
            edits[change] = [{"change": {"light_id": light.id, **fields}}
                             for light in (movable if "placement" in fields else lights)]
        if lights:
            edits["shift of all"] = [{"change": {"light_id": light.id, **changes["shift"]}} for light in lights]
            edits["remove"] = [{"remove": lights[0].id}]
            edits["put again"] = [{"put": {**put[0], "id": lights[-1].id}}]
        for name, edit in edits.items():
            revision = self.ask("Scene", "EditLights", name, scene_id=scene, edits=edit, lease_s=LEASE_S)
            if revision:
                self.revision(revision, f"after {name}")

    def revision(self, loaded, label):
        """A few queries of a revision."""
        scene = loaded.scene_id
        self.ask("Scene", "GetScene", label, scene_id=scene)
        self.ask("Scene", "ListLights", label, scene_id=scene)
        if hasattr(self, "at"):
            at = {"scene_id": scene, "receivers": self.at, "normals": self.normals, "seed": {"seed": 7}}
            settings = {"": {}, "by tree": {"light_selection": 4}}
            if label == "after shift" and not self.few:
                settings["maps"] = {"visibility": 2}
            for name, fields in settings.items():
                self.ask("Lighting", "EstimateIrradiance", f"{label} {name}", bounces=1, **at,
                         accuracy={"samples": 4, **fields})
            self.ask("Lighting", "SampleLi", label, test_visibility=True, **at, wavelengths_nm=WAVES)
            self.ask("Lighting", "SampleLi", f"{label} by name", **at, light_name="new")
            self.ask("Lighting", "SampleLe", label, scene_id=scene, count=self.n, seed={"seed": 7})
            self.ask("Lighting", "Le", label, scene_id=scene, points=self.at, directions=self.wi)
            self.ask("Render", "RenderTile", label, scene_id=scene, rect=self.rect, accuracy={"samples": 4})
        self.ask("Lighting", "EstimatePower", label, scene_id=scene, page_size=100)
        self.release(loaded)


def chosen(lights):
    """One light of each sort, and others if these are few."""
    def sort(light):
        kind = light.WhichOneof("kind")
        part = getattr(light, kind)
        return (kind, getattr(part, "shape", 0), light.HasField("motion"), light.HasField("spectrum"),
                *(field.name for field, _ in part.ListFields() if field.message_type))

    first = {}
    for light in lights:
        first.setdefault(sort(light), light)
    rest = [light for light in lights if first[sort(light)] is not light]
    return [*first.values(), *rest][:max(LIGHTS, len(first))]


def answers(build, folder, threads, few, paths):
    """The digests of some of the folder's scenes, by the name of the scene."""
    with tempfile.TemporaryDirectory() as generated:
        messages(generated)
        server = Server(build, folder, threads)
        try:
            return {folder.name: Scene(server, few).of_server(),
                    **{f"{folder.name}/{path}": Scene(server, few).answers(path) for path in paths}}
        finally:
            server.stop()


def record(options):
    result = {}
    with concurrent.futures.ProcessPoolExecutor(SERVERS) as pool:
        tasks = []
        for folder in map(pathlib.Path.resolve, options.folders):
            paths = sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.suffix in SCENE_FILES)
            size = max(1, min(50, len(paths) // SERVERS // 4))
            tasks += [pool.submit(answers, options.build, folder, options.threads, options.few, paths[i:i + size])
                      for i in range(0, len(paths), size)]
        for task in tasks:
            result.update(task.result())
    return result


def compare(before, now):
    """The number of answers that differ, or that only one record has."""
    differ = 0
    for scene in sorted(before.keys() | now.keys()):
        old, new = before.get(scene, {}), now.get(scene, {})
        for query in sorted(old.keys() | new.keys()):
            if old.get(query) != new.get(query):
                print(f"{scene}: {query}: {old.get(query)} {new.get(query)}")
                differ += 1
    return differ


def existing(text):
    path = pathlib.Path(text)
    if not path.exists():
        raise argparse.ArgumentTypeError(f"{text} does not exist, allowed: an existing file or folder")
    return path


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    recording = commands.add_parser("record")
    recording.add_argument("build", type=pathlib.Path)
    recording.add_argument("record", type=pathlib.Path)
    recording.add_argument("folders", type=existing, nargs="*", default=FOLDERS)
    recording.add_argument("--few", action="store_true")
    recording.add_argument("--threads", type=int, default=2, help="compute threads of each server")
    comparing = commands.add_parser("compare")
    comparing.add_argument("before", type=existing)
    comparing.add_argument("now", type=existing)
    options = parser.parse_args()
    if options.command == "record":
        result = record(options)
        options.record.write_text(json.dumps(result, indent=1, sort_keys=True))
        print(f"{sum(map(len, result.values()))} answers of {len(result)} scenes")
        return 0
    before, now = (json.loads(f.read_text()) for f in (options.before, options.now))
    differ = compare(before, now)
    print(f"{sum(map(len, now.values()))} answers, {differ} differ")
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
