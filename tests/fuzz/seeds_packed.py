"""Seeds: glTF files with compressed meshes, morph targets and skins.

The encoders of Draco 1.5.5 and meshoptimizer 0.18 wrote the compressed bytes.
"""
import base64
import copy
import json
import struct

from seeds_gltf import CORNERS, Buffer, data_uri

# Squares of two or eight triangles with positions (0), normals (1) and (u, v) (2).
DRACO = {
    "sequential": (
        "RFJBQ08CAgEAAAACBAEAAQIAAgMBAwAJAwAAAQkDAAEDCQIAAgAAAAAAAAAAAAAAAAAAAAAAgD8AAAAAAAAA"
        "AAAAgD8AAIA/zczMPQAAAAAAAIA/AAAAAAAAAAAAAAAAAACAP5vIyz0AAAAAwbp+P5vIyz0AAAAAwbp+PwAA"
        "AAAAAAAAAACAPwAAAAAAAAAAAACAPwAAAAAAAIA/AACAPwAAAAAAAIA/"),
    "sequential_quantised": (
        "RFJBQ08CAgEAAAACBAEAAQIAAgMBAwAJAwAAAQkDAAEDCQIAAgIDAgABAQAHAwEgDwEgAwAghAgQ0AIwAwAA"
        "AAD/AAAAAAMBAQU9ASgHAQhrAQhvAQgEAAAhhT8AAAAfAAAAAAEBAAMDATABEAMANIKkAAAAAAA/AAAAAAAA"
        "AAAAAAAAAAAAAACAPwgGAAAAAAAAAAAAAIA/Bg=="),
    "edgebreaker": (
        "RFJBQ08CAgEBAAAACQgCCAIAA3/aB/8BEf8CiED/AohAA/8AAAAAAAEAAAEACQMAAAIBAQkDAAEDAQMJAgAC"
        "AgEBAQECgAKNI1dhAmECfQm9BP///499CQmb3rQXP5ibHoMAAAAA/wAAAAAAAAAAAAAAAAAAAAAAAEAIAAMB"
        "AQI+GScDkQMdB2uRA28dB5EDB65a3XP+SoA/AAAAHwAAAAYBAQEBAUDJMfc5DgTS3W2MAAAAAD8AAAAAAAAA"
        "AAAAAAAAgD8G"),
    "edgebreaker_valence": (
        "RFJBQ08CAgEBAAAACQgCCAIAA3/aB/8BEf8CiEABAoBAA/8AAQAAAAEBAAEACQMAAAIBAQkDAAEDAQMJAgAC"
        "AgEBAQEFgAKNI1dhAmECfQm9BP///499CQmb3rQXP5ibHoMAAAAA/wAAAAAAAAAAAAAAAAAAAAAAAEAIBgMB"
        "AAcHHQcdBwfJMQRUlkSAe8EDfcB6guaITugAPwAAAB8AAAD/AplABgUBAQEGPq0WVQFVCWdVAa0CrQoBDK0C"
        "a1UBEtVCyqwBPr+tDJgAfkmgZ3wvgQgAAAAgA+AxgQAAAAA/AAAAAAAAAAAAAAAAAABABg=="),
    "edgebreaker_fast": (
        "RFJBQ08CAgEBAAAABgIAAgAAAT//ASIB/wAAAwAJAwAAAQkDAAEDCQIAAgAAAAAAgD8AAIA/zczMPQAAAAAA"
        "AIA/AAAAAAAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAgD8AAIA/zczMPQAAAAAAAAAAAAAAAJvIyz0AAAAA"
        "wbp+PwAAAAAAAAAAAACAPwAAAAAAAAAAAACAP5vIyz0AAAAAwbp+P5vIyz0AAAAAwbp+PwAAAAAAAAAAAACA"
        "PwAAAEAAAIA/AACAPwAAgD8AAIA/AAAAAAAAgD8AAAAAAACAPwAAgD8AAAAAAAAAAA=="),
}

# name: mode, filter, count, stride, component type, accessor type, bytes.  Four corners, or two
# triangles.
MESHOPT = {
    "attributes": ("ATTRIBUTES", "NONE", 4, 12, 5126, "VEC3",
                   (
                   "oAAAATMAAAD//wEzAAAAfn0AAAEMAAAA/wEMAAAAfgAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA"
                   "AAAAAA==")),
    "octahedral": ("ATTRIBUTES", "OCTAHEDRAL", 4, 4, 5120, "VEC3",
                   "oAEPAAAAbGsAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAB/AA=="),
    "octahedral_8": ("ATTRIBUTES", "OCTAHEDRAL", 4, 8, 5122, "VEC3",
                     "oAEPAAAA2tkBDwAAAAYFAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAP8HAAA="),
    "quaternion": ("ATTRIBUTES", "QUATERNION", 2, 8, 5122, "VEC4",
                   "oAAAAAABMAAAAG0BMAAAAAwAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAP8H"),
    "exponential": ("ATTRIBUTES", "EXPONENTIAL", 4, 12, 5126, "VEC3",
                    (
                    "oAABMwAAAEA/AAEgAAAAAAEMAAAAQAABIAAAAAAAAAEgAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAADyAAAA"
                    "8gAAAPI=")),
    "triangles": ("TRIANGLES", "NONE", 6, 4, 5125, "SCALAR", "4PAAAHaHVmd4qYZliWiYAWkAAA=="),
    "indices": ("INDICES", "NONE", 6, 4, 5125, "SCALAR", "0AAEBAYIBAAAAAA="),
}


def document(b, primitives, nodes, **more):
    return {"asset": {"version": "2.0"}, "scene": 0,
            "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes,
            "meshes": [{"primitives": primitives}],
            "buffers": [{"byteLength": len(b.bytes),
                         "uri": data_uri("application/octet-stream", b.bytes)}],
            "bufferViews": b.views, "accessors": b.accessors, **more}


def draco(packed):
    b = Buffer()
    view = b.view(base64.b64decode(packed))
    # Their values come from the compressed mesh.
    b.accessors = [{"componentType": 5126, "count": 4, "type": kind}
                   for kind in ("VEC3", "VEC3", "VEC2")]
    b.accessors.append({"componentType": 5123, "count": 6, "type": "SCALAR"})
    names = {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}
    primitive = {"attributes": names, "indices": 3, "extensions": {
        "KHR_draco_mesh_compression": {"bufferView": view, "attributes": names}}}
    return document(b, [primitive], [{"mesh": 0}],
                    extensionsRequired=["KHR_draco_mesh_compression"])


def meshopt():
    """Every mode and filter.  Not all accessors have a use."""
    b = Buffer()
    place = {}
    for name, (mode, kind, count, stride, code, shape, packed) in MESHOPT.items():
        content = base64.b64decode(packed)
        view = b.view(content)
        b.views[view]["extensions"] = {"EXT_meshopt_compression": {
            "buffer": 0, "byteOffset": b.views[view]["byteOffset"], "byteLength": len(content),
            "count": count, "byteStride": stride, "mode": mode, "filter": kind}}
        b.views[view].update(byteOffset=0, byteLength=count * stride)
        if mode == "ATTRIBUTES":
            b.views[view]["byteStride"] = stride
        place[name] = len(b.accessors)
        b.accessors.append({"bufferView": view, "componentType": code, "count": count,
                            "type": shape, "normalized": code in (5120, 5122)})
    times = b.add("SCALAR", 5126, [(0.0,), (1.0,)])
    primitives = [
        {"attributes": {"POSITION": place["attributes"], "NORMAL": place["octahedral"]},
         "indices": place["triangles"]},
        {"attributes": {"POSITION": place["exponential"], "NORMAL": place["octahedral_8"]},
         "indices": place["indices"]}]
    return document(b, primitives, [{"mesh": 0}],
                    extensionsRequired=["EXT_meshopt_compression"],
                    animations=[{"channels": [{"sampler": 0,
                                               "target": {"node": 0, "path": "rotation"}}],
                                 "samplers": [{"input": times, "output": place["quaternion"]}]}])


def with_one_error(good, path, to):
    result = copy.deepcopy(good)
    at = result
    for key in path[:-1]:
        at = at[key]
    at[path[-1]] = to
    return result


def deformed():
    """A mesh with morph targets on a node of its own weights, and on a node with a skin."""
    b = Buffer()
    attributes = {
        "POSITION": b.add("VEC3", 5126, CORNERS),
        "NORMAL": b.add("VEC3", 5126, [(0.0, 0.0, 1.0)] * 4),
        "JOINTS_0": b.add("VEC4", 5121, [(0, 1, 0, 0)] * 3 + [(0, 0, 0, 0)]),
        "WEIGHTS_0": b.add("VEC4", 5126, [(0.5, 0.5, 0.0, 0.0)] * 3 + [(0.0, 0.0, 0.0, 0.0)])}
    change = b.add("VEC3", 5126, [(0.0, 0.0, 0.5)] * 4)
    turn = b.add("VEC3", 5126, [(0.1, 0.0, 0.0)] * 4)
    one = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
    inverse = b.add("MAT4", 5126, [one, one])
    times = b.add("SCALAR", 5126, [(0.0,), (1.0,)])
    moves = b.add("VEC3", 5126, [(0.0, 0.0, 0.0), (0.0, 0.5, 0.0)])
    steps = b.add("SCALAR", 5126, [(0.0,), (1.0,)])
    triangle = {"attributes": {k: attributes[k] for k in ("POSITION", "NORMAL")},
                "indices": b.add("SCALAR", 5121, [(i,) for i in (0, 1, 2, 0, 2, 3)]),
                "targets": [{"POSITION": change, "NORMAL": turn}]}
    result = document(
        b, [triangle], [
            {"mesh": 0, "weights": [0.5]},
            {"mesh": 1, "skin": 0, "translation": [9, 9, 9]},
            {"translation": [1, 0, 0]}, {"translation": [0, 2, 0], "scale": [2, 2, 2]}],
        skins=[{"joints": [2, 3], "inverseBindMatrices": inverse, "skeleton": 2}],
        animations=[{"channels": [{"sampler": 0, "target": {"node": 2, "path": "translation"}},
                                  {"sampler": 1, "target": {"node": 0, "path": "weights"}}],
                     "samplers": [{"input": times, "output": moves, "interpolation": "STEP"},
                                  {"input": times, "output": steps}]}])
    result["meshes"][0]["weights"] = [0.25]
    result["meshes"].append({"primitives": [{**triangle, "attributes": attributes}]})
    return result


def gltf():
    text = lambda value: json.dumps(value).encode()
    for name, packed in DRACO.items():
        yield "draco_" + name, text(draco(packed))
    cut_off = base64.b64encode(base64.b64decode(DRACO["edgebreaker"])[:60]).decode()
    yield "draco_cut_off", text(draco(cut_off))
    cloud = base64.b64encode(struct.pack("<5sBBBBH", b"DRACO", 2, 2, 0, 1, 0)).decode()
    yield "draco_points", text(draco(cloud))
    good = meshopt()
    yield "meshopt", text(good)
    packed = ("bufferViews", 0, "extensions", "EXT_meshopt_compression")
    for key, to in (("mode", "LZ"), ("filter", "LINEAR"), ("filter", "QUATERNION"),
                    ("filter", "OCTAHEDRAL"), ("byteStride", 3), ("byteLength", 5)):
        yield f"meshopt_{key}_{to}", text(with_one_error(good, packed + (key,), to))
    triangles = ("bufferViews", 5, "extensions", "EXT_meshopt_compression")
    for key, to in (("count", 5), ("byteStride", 8), ("filter", "EXPONENTIAL")):
        yield f"meshopt_triangles_{key}", text(with_one_error(good, triangles + (key,), to))
    good = deformed()
    yield "deformed", text(good)
    yield "deformed_without_joints", text(with_one_error(good, ("skins", 0, "joints"), []))
    yield "deformed_joint_9", text(with_one_error(good, ("skins", 0, "joints", 1), 9))
