"""Seeds: a request for each call, written in the text form of its message."""
import hashlib
import pathlib
import subprocess
import sys
import tempfile

PROTO = pathlib.Path(__file__).resolve().parent.parent.parent / "proto"
ASSET = b'WorldBegin LightSource "point"\n'  # as in request_fuzz.cpp


def escaped(content):
    return "".join(f"\\{byte:03o}" for byte in content)


POINT = "origin_m { x: 100 y: -50 z: 0.5 } offsets_m: [0, 0, 0]"
POINTS = "origin_m { x: 100 y: -50 z: 0.5 } offsets_m: [0, 0, 0, 1, 1, 0.5]"
SCENE = 'scene_id: "S" '
ACCURACIES = {
    "samples": "accuracy { samples: 4 }",
    "target": "accuracy { target_error { relative: 0.1 absolute_floor: 1 confidence: 0.9 "
              "max_samples: 16 } }",
    "budget": "accuracy { time_budget_s: 0.001 }",
    "methods": "accuracy { samples: 2 area_sampling: AREA_SAMPLING_COSINE_SOLID_ANGLE "
               "light_selection: LIGHT_SELECTION_BVH samples_per_light: 2 far_light_radii: 3 "
               "sampler: SAMPLER_INDEPENDENT combination: COMBINATION_BALANCE_HEURISTIC }",
    "approximations": "accuracy { samples: 2 closed_forms: CLOSED_FORMS_EMPTY_SHAFTS "
                      "visibility: VISIBILITY_RAYS thin_glass: THIN_GLASS_BLOCKS }",
    "shadow_maps": "accuracy { samples: 2 visibility: VISIBILITY_SHADOW_MAPS }",
    "bad": "accuracy { samples: 0 light_selection: 77 }",
    "bad_target": "accuracy { target_error { relative: -1 } }",
    "bad_methods": "accuracy { samples: 3 samples_per_light: 0 far_light_radii: -1 area_sampling: 99 "
                   "sampler: 99 combination: 99 closed_forms: 99 visibility: 99 thin_glass: 99 }",
}
WAVELENGTHS = "wavelengths_nm: [450, 550.5]"
RGB = "{ r: 1 g: 2 b: 3 }"
LIGHTS = {
    "point": f"point {{ position_m {{ x: 100 y: -50 z: 2 }} intensity_cd {RGB} }}",
    "spot": f"spot {{ position_m {{ x: 100 y: -50 z: 2 }} axis {{ z: -1 }} intensity_cd {RGB} "
            "cone_half_angle_rad: 0.5 falloff_start_rad: 0.4 profile: SPOT_PROFILE_QUARTIC }",
    "bad_spot": "spot { cone_half_angle_rad: 9 profile: 9 }",
    "distant": f"distant {{ to_light {{ z: 1 }} illuminance_lx {RGB} }}",
    "sun": f"sun {{ to_light {{ z: 1 }} angular_diameter_rad: 0.1 illuminance_lx {RGB} }}",
    "disk": f"diffuse_area {{ radiance_cd_m2 {RGB} two_sided: true shape: AREA_SHAPE_DISK round {{ "
            "center_m { x: 100 y: -50 z: 2 } axes { x { x: 1 } y { y: 1 } z { z: 1 } } radius_m: 1 "
            "phi_max_rad: 6.2 } }",
    "quad": f"diffuse_area {{ radiance_cd_m2 {RGB} shape: AREA_SHAPE_BILINEAR_MESH "
            "corners_m { } corners_m { x: 1 } corners_m { y: 1 } corners_m { x: 1 y: 1 } }",
    "uniform": f"uniform_infinite {{ radiance_cd_m2 {RGB} }}",
    "none": "",
}


def messages():
    """(call, name, message in text form) for protoc."""
    yield "FindMissingAssets", "one", f'sha256: "{escaped(hashlib.sha256(ASSET).digest())}" sha256: "x"'
    yield "FindMissingAssets", "held", f'sha256: "{escaped(hashlib.sha256(ASSET).digest())}" sha256: "{escaped(bytes(32))}"'
    digest = escaped(hashlib.sha256(ASSET).digest())
    manifest = f'manifest {{ main: "a.pbrt" assets {{ name: "a.pbrt" sha256: "{digest}" size_bytes: {len(ASSET)} }} }}'
    for name, text in (
            ("path", 'path: "lights/every_light.pbrt" lease_s: 5'), ("manifest", manifest),
            ("small", 'path: "pbrt/parts.pbrt"'),
            ("gltf", 'path: "gltf/room.gltf" blender { mode: BLENDER_LIGHTING_MODE_STANDARD }'),
            ("gltf_unitless", 'path: "gltf/room.gltf" blender { mode: BLENDER_LIGHTING_MODE_UNITLESS lumens_per_watt: 100 }'),
            ("gltf_raw", 'path: "gltf/room.gltf" blender { mode: BLENDER_LIGHTING_MODE_RAW }'),
            ("bad_mode", 'path: "gltf/room.gltf" blender { mode: 9 }'),
            ("bad_blender", 'path: "a.pbrt" blender { mode: 1 }'),
            ("bad_watts", 'path: "gltf/room.gltf" blender { mode: 1 lumens_per_watt: -1 }'),
            ("missing", f'manifest {{ main: "a.pbrt" assets {{ name: "a.pbrt" sha256: "{escaped(bytes(32))}" }} }}'),
            ("no_main", f'manifest {{ main: "b.pbrt" assets {{ name: "a.pbrt" sha256: "{digest}" }} }}'),
            ("bad_name", 'manifest { main: "../a" assets { name: "../a" } }'),
            ("twice", f'manifest {{ main: "a" assets {{ name: "a" sha256: "{digest}" }} assets {{ name: "a" sha256: "{digest}" }} }}'),
            ("bad_digest", 'manifest { main: "a" assets { name: "a" sha256: "x" } }'),
            ("nothing", ""), ("not_found", 'path: "no.pbrt"'), ("absolute", 'path: "/etc/passwd"'),
            ("bad_lease", 'path: "pbrt/parts.pbrt" lease_s: nan'),
            ("edited", 'path: "lights/every_light.pbrt" edits { change { light_id: 1 scale: 0.5 } }'),
            ("edited_remove", manifest + ' edits { remove: 1 } edits { remove: 1 }')):
        yield "LoadScene", name, text
    for call in ("GetScene", "ListLights", "ReleaseScene", "RenewLease"):
        yield call, "scene", SCENE
        yield call, "unknown", 'scene_id: "no"'
    for call in ("ListScenes", "ListAvailableScenes", "ListLeases"):
        yield call, "page", "page_size: 2"
        yield call, "token", 'page_size: 2 page_token: "a"'
        yield call, "all", ""
    yield "ListLights", "page", SCENE + 'page_size: 3 page_token: "2"'
    yield "ListLights", "bad_page", SCENE + 'page_token: "x"'
    yield "RenewLease", "renew", SCENE + 'lease_s: 9 lease_id: "L"'
    yield "RenewLease", "bad", SCENE + 'lease_s: -1'
    yield "ReleaseScene", "lease", SCENE + 'lease_id: "L"'
    yield "ReleaseScene", "break", SCENE + "break_leases: true"
    for name, light in LIGHTS.items():
        yield "EditLights", "put_" + name, SCENE + f'edits {{ put {{ name: "new" {light} }} }}'
        yield "EditLights", "replace_" + name, SCENE + f"edits {{ put {{ id: 1 {light} }} }}"
    placement = "placement { shift_m { x: 1 } turn_axis { z: 1 } turn_rad: 0.5 }"
    for name, text in (
            ("remove", "edits { remove: 1 }"), ("remove_unknown", "edits { remove: 999 }"),
            ("dim", "edits { change { light_id: 1 scale: 0.5 tint { r: 1 g: 0.5 b: 0.1 } on: false } }"),
            ("move", f"edits {{ change {{ light_id: 1 {placement} }} }}"),
            ("move_surface", f"edits {{ change {{ light_id: 28 {placement} }} }}"),
            ("move_nothing", "edits { change { light_id: 1 placement { turn_rad: 1 } } }"),
            ("bad_change", "edits { change { light_id: 1 scale: -1 tint { r: nan } } }"),
            ("add", 'edits { add { path: "pbrt/parts.pbrt" } }'),
            ("add_lights", f'edits {{ add {{ {manifest} }} }}'),
            ("add_nothing", "edits { add { } }"), ("nothing", "edits { }"), ("none", "lease_s: 3"),
            ("bad_lease", "edits { remove: 1 } lease_s: -3")):
        yield "EditLights", name, SCENE + text
    receivers = f"receivers {{ {POINTS} }} "
    for name, text in ACCURACIES.items():
        for call, rest in (
                ("SampleLi", receivers + "seed { seed: 3 } test_visibility: true " + WAVELENGTHS),
                ("EstimateIrradiance", receivers + "normals: [0, 0, 1, 0, 0, 1] bounces: 1 "),
                ("EstimatePower", "method: METHOD_SAMPLED "),
                ("RenderTile", "rect { x0: 4 y0: 4 x1: 8 y1: 6 } bounces: 1 "),
                ("RenderImage", "bounces: 0 tile_size: 8 "),
                ("TestVisibility", f"segments {{ from {{ {POINT} }} to {{ origin_m {{ x: 100 y: -50 z: 3 }} offsets_m: [0, 0, 0] }} }} "),
                ("SampleLe", "count: 3 seed { } "), ("PdfLi", receivers + "wi: [0, 0, 1, 0, 0, 1] light_id: 3 "),
                ("PdfLe", f"light_id: 1 points {{ {POINT} }} directions: [0, 0, -1] "),
                ("Le", f"points {{ {POINT} }} directions: [0, 0, 1] ")):
            yield call, "accuracy_" + name, SCENE + rest + text
    for name, text in (
            ("light", receivers + "light_id: 2 seed { seed: 1 first_item: 5 }"),
            ("every", receivers + "u { u: [0.1, 0.2, 0.3, 0.4] u_light: [0.5, 0.6] }"),
            ("normals", receivers + "seed { } normals: [0, 0, 1, 0, 1, 0] position_error_m: 0.001 time_s: 0.5"),
            ("named", receivers + 'seed { } light_name: "lamp"'),
            ("bad_u", receivers + "u { u: [0.1, 2] }"), ("no_seed", receivers),
            ("bad_points", "receivers { offsets_m: [1, 2] } seed { }"),
            ("nan", "receivers { origin_m { x: nan } offsets_m: [nan, inf, 3e38] } seed { }"),
            ("far", "receivers { origin_m { x: 1e300 } offsets_m: [0, 0, 0] } seed { }"),
            ("no_light", receivers + "light_id: 999 seed { }"),
            ("bad_normals", receivers + "seed { } normals: [1, 2]"),
            ("bad_wavelengths", receivers + "seed { } wavelengths_nm: [1e9]"),
            ("many", "receivers { offsets_m: [" + ", ".join(["0"] * 300) + "] } seed { }")):
        yield "SampleLi", name, SCENE + text
    yield "SampleLe", "values", SCENE + "light_id: 1 count: 2 u { u: [" + ", ".join(["0.5"] * 8) + "] u_light: [0.1, 0.2] } " + WAVELENGTHS
    yield "SampleLe", "too_many", SCENE + "count: 100000 seed { }"
    yield "Le", "light", SCENE + f"points {{ {POINTS} }} directions: [0, 0, 1, 1, 0, 0] light_id: 30 {WAVELENGTHS}"
    yield "Le", "bad_directions", SCENE + f"points {{ {POINTS} }} directions: [0, 0, 0, 1, 0, nan]"
    yield "PdfLi", "bad", SCENE + receivers + "wi: [0] light_id: 3"
    yield "PdfLe", "bad", SCENE + f'points {{ {POINT} }} directions: [0, 2, 0] light_name: "x"'
    for method in ("EXACT", "APPROXIMATE", "UNSPECIFIED"):
        yield "EstimatePower", method.lower(), SCENE + f"method: METHOD_{method} {WAVELENGTHS}"
    yield "EstimatePower", "some", SCENE + "light_ids: [1, 20, 30] method: METHOD_SAMPLED seed: 3 accuracy { samples: 8 }"
    yield "EstimatePower", "page", SCENE + "method: METHOD_EXACT page_size: 4"
    yield "EstimatePower", "bad", SCENE + 'light_ids: [999] light_names: "x" method: 9 page_token: "z"'
    yield "TestVisibility", "rays", SCENE + f"rays {{ from {{ {POINT} }} directions: [0, 0, 1] lengths_m: [2] }} normals: [0, 0, 1] time_s: 1"
    yield "TestVisibility", "bad_rays", SCENE + f"rays {{ from {{ {POINT} }} directions: [0, 0] lengths_m: [-2] }}"
    yield "TestVisibility", "nothing", SCENE
    yield "EstimateIrradiance", "per_light", SCENE + receivers + "normals: [0, 0, 1, 0, 0, 1] per_light: true accuracy { samples: 2 } " + WAVELENGTHS
    yield "EstimateIrradiance", "bad", SCENE + receivers + "normals: [0, 0, 0] bounces: 9999"
    yield "RenderTile", "intervals", SCENE + "rect { x1: 2 y1: 2 } intervals: true accuracy { samples: 8 } samples_per_block: 4 first_sample: 4 time_s: 0.5"
    yield "RenderTile", "shutter", SCENE + "rect { x1: 2 y1: 2 } accuracy { samples: 1 } shutter { offset_s: 1 length_s: 2 }"
    for name, text in (("empty", ""), ("outside", "rect { x0: 90 y0: 90 x1: 99 y1: 99 }"),
                       ("too_large", "rect { x1: 32 y1: 24 }"), ("turned", "rect { x0: 5 y1: 3 }"),
                       ("first", "rect { x1: 1 y1: 1 } first_sample: 3 samples_per_block: 2"),
                       ("shutter_bad", "rect { x1: 1 y1: 1 } shutter { length_s: -1 }")):
        yield "RenderTile", name, SCENE + text
    yield "RenderImage", "final", SCENE + "final_only: true intervals: true tile_size: 8 accuracy { samples: 2 } time_s: 0.5"
    yield "RenderImage", "bad", SCENE + "tile_size: 0 samples_per_block: 3"
    yield "FindSurfaces", "places", SCENE + "places: [1.5, 2.5, 0, 0, 32, 24] time_s: 0.5"
    yield "FindSurfaces", "outside", SCENE + "places: [-1, 2.5, nan, 0, 33, 24]"
    yield "FindSurfaces", "odd", SCENE + "places: [1, 2, 3]"
    yield "GetServerInfo", "empty", ""
    yield "GetStats", "empty", ""


CALLS = ("FindMissingAssets UploadAsset LoadScene GetScene ListScenes ListAvailableScenes ListLights "
         "EditLights RenewLease ReleaseScene SampleLi PdfLi SampleLe PdfLe Le EstimatePower "
         "TestVisibility EstimateIrradiance RenderTile RenderImage GetServerInfo GetStats "
         "ListLeases FindSurfaces").split()  # in the order of monitor::Call


def request():
    with tempfile.TemporaryDirectory() as made:
        files = sorted(str(path) for path in (PROTO / "lucerna/v1").glob("*.proto"))
        subprocess.run(["protoc", f"-I{PROTO}", f"--python_out={made}", *files], check=True)
        sys.path.insert(0, made)
        from google.protobuf import text_format
        from lucerna.v1 import admin_pb2, lighting_pb2, render_pb2, scene_pb2
        modules = (scene_pb2, lighting_pb2, render_pb2, admin_pb2)

        def encoded(kind, text):
            module = next(m for m in modules if hasattr(m, kind))
            message = getattr(module, kind)()
            text_format.Parse(text, message)
            return message.SerializeToString(deterministic=True)

        for call, name, text in messages():
            yield f"{call}_{name}", bytes([CALLS.index(call)]) + encoded(call + "Request", text)
        content = b"WorldBegin\n"
        digest = escaped(hashlib.sha256(content).digest())
        uploads = {
            "whole": [f'header {{ sha256: "{digest}" size_bytes: {len(content)} }}',
                      f'chunk: "{escaped(content)}"'],
            "part": [f'header {{ sha256: "{digest}" size_bytes: 90 }}', 'chunk: "ab"'],
            "held": [f'header {{ sha256: "{escaped(hashlib.sha256(ASSET).digest())}" size_bytes: 31 }}'],
            "bad_digest": ['header { sha256: "x" }'], "no_header": ['chunk: "a"'],
            "two_headers": [f'header {{ sha256: "{digest}" size_bytes: 50 }}'] * 2,
            "too_much": [f'header {{ sha256: "{digest}" size_bytes: 1 }}', 'chunk: "abc"'],
            "too_large": [f'header {{ sha256: "{digest}" size_bytes: 999999 }}'],
            "bad_offset": [f'header {{ sha256: "{digest}" size_bytes: 9 offset_bytes: 99 }}'],
            "other_bytes": [f'header {{ sha256: "{digest}" size_bytes: 3 }}', 'chunk: "abc"'],
            "none": [],
        }
        for name, parts in uploads.items():
            body = b""
            for part in parts:
                message = encoded("UploadAssetRequest", part)
                body += bytes([len(message)]) + message
            yield "UploadAsset_" + name, bytes([CALLS.index("UploadAsset")]) + body
        yield "malformed", bytes([CALLS.index("SampleLi")]) + b"\xff\xff\xff"
