"""Seeds: a glTF file with everything that the server models, and files with one error."""
import base64
import copy
import json
import pathlib
import struct
import zlib

DATA = pathlib.Path(__file__).resolve().parent.parent / "data"


def data_uri(kind, content):
    return f"data:{kind};base64," + base64.b64encode(content).decode()


def png_2_x_2():
    """Four texels with alpha.  A large face of a cube map would take most of the time of a run."""
    def chunk(kind, content):
        return (struct.pack(">I", len(content)) + kind + content +
                struct.pack(">I", zlib.crc32(kind + content)))

    rows = b"\0\xff\x80\x40\xff\x10\x20\x30\x80" + b"\0\x40\x80\xff\x01\0\0\0\0"
    stored = b"\x78\x01\x01" + struct.pack("<2H", len(rows), len(rows) ^ 0xffff) + rows
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", 2, 2, 8, 6, 0, 0, 0)) +
            chunk(b"IDAT", stored + struct.pack(">I", zlib.adler32(rows))) + chunk(b"IEND", b""))


class Buffer:
    """Accessors of one buffer."""

    def __init__(self):
        self.bytes, self.views, self.accessors = b"", [], []

    def view(self, content):
        self.bytes += bytes(-len(self.bytes) % 4)
        self.views.append({"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(content)})
        self.bytes += content
        return len(self.views) - 1

    def add(self, kind, code, rows, **more):
        letter = {5120: "b", 5121: "B", 5122: "h", 5123: "H", 5125: "I", 5126: "f"}[code]
        content = b"".join(struct.pack(f"<{len(row)}{letter}", *row) for row in rows)
        columns = list(zip(*rows))
        self.accessors.append({"bufferView": self.view(content), "componentType": code,
                               "count": len(rows), "type": kind,
                               "min": [min(c) for c in columns], "max": [max(c) for c in columns],
                               **more})
        return len(self.accessors) - 1


CORNERS = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)]


def everything():
    b = Buffer()
    position = b.add("VEC3", 5126, CORNERS)
    small = b.add("VEC3", 5122, [(0, 0, 0), (9, 0, 0), (9, 9, 0), (0, 9, 0)])
    normal = b.add("VEC3", 5126, [(0.0, 0.0, 1.0)] * 4)
    tangent = b.add("VEC4", 5126, [(1.0, 0.0, 0.0, 1.0)] * 4)
    uv = b.add("VEC2", 5126, [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    small_uv = b.add("VEC2", 5121, [(0, 0), (255, 0), (255, 255), (0, 255)], normalized=True)
    colour = b.add("VEC3", 5126, [(1.0, 0.5, 0.2)] * 4)
    indices = {code: b.add("SCALAR", code, [(i,) for i in (0, 1, 2, 0, 2, 3)])
               for code in (5121, 5123, 5125)}
    strip = b.add("SCALAR", 5121, [(0,), (1,), (3,), (2,)])
    times = b.add("SCALAR", 5126, [(0.0,), (1.0,)])
    moves = b.add("VEC3", 5126, [(0.0, 0.0, 0.0), (0.0, 0.5, 0.0)])
    turns = b.add("VEC4", 5126, [(0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.6, 0.8)])
    sparse = b.add("VEC3", 5126, CORNERS, sparse={
        "count": 1, "indices": {"bufferView": b.view(b"\1\0\0\0"), "componentType": 5121},
        "values": {"bufferView": b.view(struct.pack("<3f", 2, 0, 0))}})
    picture = b.view((DATA / "reference/tiles.png").read_bytes())
    texture = {"index": 0, "extensions": {"KHR_texture_transform": {
        "offset": [0.1, 0.2], "scale": [2, 2], "rotation": 0.5, "texCoord": 0}}}
    plain = {"index": 0}
    face = png_2_x_2()
    materials = [
        {"name": "all", "doubleSided": True, "alphaMode": "MASK", "alphaCutoff": 0.4,
         "normalTexture": {"index": 0, "scale": 0.5}, "occlusionTexture": {"index": 0, "strength": 0.5},
         "pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0.2, 0.9], "baseColorTexture": plain,
                                  "metallicFactor": 0.5, "roughnessFactor": 0.3,
                                  "metallicRoughnessTexture": plain},
         "extensions": {
             "KHR_materials_transmission": {"transmissionFactor": 0.3, "transmissionTexture": plain},
             "KHR_materials_clearcoat": {"clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.1,
                                         "clearcoatTexture": plain, "clearcoatNormalTexture": plain},
             "KHR_materials_specular": {"specularFactor": 0.5, "specularColorFactor": [1, 1, 0.5],
                                        "specularTexture": plain},
             "KHR_materials_anisotropy": {"anisotropyStrength": 0.5, "anisotropyRotation": 1},
             "KHR_materials_ior": {"ior": 1.4}}},
        {"emissiveFactor": [1, 1, 0.5], "emissiveTexture": texture, "alphaMode": "BLEND",
         "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 100}}},
        {"extensions": {"KHR_materials_unlit": {}},
         "pbrMetallicRoughness": {"baseColorTexture": texture}},
    ]
    meshes = [
        {"name": "quad", "primitives": [
            {"attributes": {"POSITION": position, "NORMAL": normal, "TANGENT": tangent,
                            "TEXCOORD_0": uv, "COLOR_0": colour},
             "indices": indices[5121], "material": 0},
            {"attributes": {"POSITION": position, "TEXCOORD_0": small_uv},
             "indices": indices[5123], "material": 1}]},
        {"primitives": [{"attributes": {"POSITION": small}, "indices": indices[5125], "material": 2},
                        {"attributes": {"POSITION": sparse}, "indices": strip, "mode": 5},
                        {"attributes": {"POSITION": position}, "indices": strip, "mode": 6},
                        {"attributes": {"POSITION": position}, "mode": 1}]},
    ]
    nodes = [
        {"name": "root", "children": [1, 2, 3], "scale": [1, 1, 1]},
        {"mesh": 0, "translation": [0, 0, -2], "rotation": [0, 0, 0.6, 0.8]},
        {"mesh": 1, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 2, 0, 0, 1]},
        {"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": moves}}}},
        {"camera": 0}, {"camera": 1},
        {"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [0, 1, 0]},
        {"extensions": {"KHR_lights_punctual": {"light": 1}}},
        {"extensions": {"KHR_lights_punctual": {"light": 2}}},
        {"extensions": {"EXT_lights_ies": {"light": 0, "multiplier": 2, "color": [1, 0.5, 1]}}},
    ]
    return {
        "asset": {"version": "2.0"}, "scene": 0,
        "extensionsUsed": ["KHR_lights_punctual", "EXT_lights_ies", "EXT_lights_image_based",
                           "KHR_mesh_quantization", "EXT_mesh_gpu_instancing", "KHR_texture_transform"],
        "scenes": [{"nodes": [0, 4, 5, 6, 7, 8, 9],
                    "extensions": {"EXT_lights_image_based": {"light": 0}}}],
        "nodes": nodes, "meshes": meshes, "materials": materials,
        "cameras": [{"type": "perspective",
                     "perspective": {"yfov": 0.7, "znear": 0.1, "aspectRatio": 1.5}},
                    {"type": "orthographic",
                     "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 9}}],
        "animations": [{"channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}},
                                     {"sampler": 1, "target": {"node": 1, "path": "rotation"}}],
                        "samplers": [{"input": times, "output": moves, "interpolation": "LINEAR"},
                                     {"input": times, "output": turns}]}],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}],
        "images": [{"bufferView": picture, "mimeType": "image/png"},
                   {"uri": data_uri("image/png", face)}],
        "extensions": {
            "KHR_lights_punctual": {"lights": [
                {"type": "point", "intensity": 5, "color": [1, 0.9, 0.8], "name": "lamp", "range": 9},
                {"type": "spot", "intensity": 5, "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.6}},
                {"type": "directional", "intensity": 3}]},
            "EXT_lights_ies": {"lights": [{"uri": data_uri(
                "application/x-ies-lm-63", (DATA / "lights/downlight.ies").read_bytes())}]},
            "EXT_lights_image_based": {"lights": [{
                "intensity": 2, "rotation": [0, 0, 0, 1], "specularImageSize": 2,
                "specularImages": [[1] * 6],
                "irradianceCoefficients": [[0.1, 0.1, 0.1]] * 9}]}},
        "buffers": [{"byteLength": len(b.bytes),
                     "uri": data_uri("application/octet-stream", b.bytes)}],
        "bufferViews": b.views, "accessors": b.accessors,
    }


def paths(value, path=()):
    """The paths of all values in a JSON value."""
    yield path
    entries = (value.items() if isinstance(value, dict) else
               enumerate(value) if isinstance(value, list) else ())
    for key, inner in entries:
        yield from paths(inner, path + (key,))


def changed(value, path, to):
    result = copy.deepcopy(value)
    at = result
    for key in path[:-1]:
        at = at[key]
    at[path[-1]] = to
    return result


def gltf():
    good = everything()
    yield "everything", json.dumps(good).encode()
    text = json.dumps({**good, "buffers": [{"byteLength": good["buffers"][0]["byteLength"]}]})
    text += " " * (-len(text) % 4)
    content = base64.b64decode(good["buffers"][0]["uri"].split(",")[1])
    content += bytes(-len(content) % 4)
    yield "everything_binary", (
        struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(content)) +
        struct.pack("<I4s", len(text), b"JSON") + text.encode() +
        struct.pack("<I4s", len(content), b"BIN\0") + content)
    yield "room", ((DATA / "gltf/room.gltf").read_bytes() + b"\n#FILE room.bin\n" +
                   (DATA / "gltf/room.bin").read_bytes())
    yield "blender_room", (DATA / "gltf/blender_room.glb").read_bytes()
    yield "empty", b'{"asset":{"version":"2.0"}}'
    yield "no_json", b"{"
    yield "glb_cut_off", b"glTF\2\0\0\0"
