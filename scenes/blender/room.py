"""Models a room in Blender and exports it with Blender's own glTF exporter.

    blender -b --factory-startup -P scenes/blender/room.py -- OUT.glb [SPEC|COMPAT|RAW]

The last argument is the exporter's lighting mode, by default SPEC, which Blender shows as "Standard".  The room has what
such files hold: a lamp of each kind, an emissive mesh, a pane, a picture, a leaf with holes, a bevelled and a subdivided
object, copies that share a mesh, vertex colours, a lamp that moves, and a lamp beneath another object.

tests/data/gltf/blender_room.glb is the output of Blender 3.4.1 (Debian 12), whose exporter is Khronos glTF Blender I/O
v3.4.50.  Debian package: blender.  Lengths in metres, z up; the exporter turns the scene to y up.
"""
import math
import sys

import bpy

WIDTH, DEPTH, HEIGHT = 4.0, 3.0, 2.5  # x, y, z
# Watts of lamps, W/m2 of the sun, and the strength of the emissive mesh.  The test reads these numbers from here.
BULB_W, SPOT_W, MOVING_W, TABLE_LAMP_W, AREA_W = 40.0, 60.0, 10.0, 5.0, 30.0
SUN_W_M2 = 2.0
STRIP_STRENGTH = 12.0
FRAMES = 24  # of the moving lamp, at 24 frames per second


def material(name, colour=(0.8, 0.8, 0.8), roughness=0.6, **inputs):
    """Principled BSDF; inputs by their names in Blender 3.4, with `_` for a space."""
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    shader = m.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*colour, 1)
    shader.inputs["Roughness"].default_value = roughness
    for key, value in inputs.items():
        shader.inputs[key.replace("_", " ")].default_value = value
    return m


def picture(name, pixel, size=16):
    """A picture of RGB and alpha in 0 to 1, packed into the file."""
    image = bpy.data.images.new(name, size, size, alpha=True)
    image.pixels = [x for row in range(size) for column in range(size) for x in pixel(column, row)]
    image.pack()
    return image


def show(m, image, alpha=False):
    """Makes a picture the base colour, and its alpha that of the material."""
    texture = m.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    shader = m.node_tree.nodes["Principled BSDF"]
    m.node_tree.links.new(texture.outputs["Color"], shader.inputs["Base Color"])
    if alpha:
        m.node_tree.links.new(texture.outputs["Alpha"], shader.inputs["Alpha"])
        m.blend_method = "CLIP"
        m.alpha_threshold = 0.5


def mesh_object(name, m, vertices, faces, uv=None, at=(0, 0, 0)):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    if uv:
        layer = mesh.uv_layers.new(name="UVMap")
        for loop in mesh.loops:
            layer.data[loop.index].uv = uv[loop.vertex_index]
    mesh.materials.append(m)
    return add(name, mesh, at)


def add(name, data, at=(0, 0, 0), turn=(0, 0, 0)):
    """turn: Euler angles in degrees."""
    thing = bpy.data.objects.new(name, data)
    thing.location = at
    thing.rotation_euler = [math.radians(a) for a in turn]
    bpy.context.scene.collection.objects.link(thing)
    return thing


def quad(name, m, corners, uv=None):
    """Seen counterclockwise from outside."""
    return mesh_object(name, m, corners, [(0, 1, 2, 3)], uv)


def box(name, m, size, at):
    x, y, z = (s / 2 for s in size)
    vertices = [(i * x, j * y, k * z) for k in (-1, 1) for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    faces = [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    return mesh_object(name, m, vertices, faces, at=at)


def light(name, kind, energy, at, turn=(0, 0, 0), colour=(1, 1, 1)):
    lamp = bpy.data.lights.new(name, kind)
    lamp.energy, lamp.color = energy, colour
    return add(name, lamp, at, turn)


def building():
    w, d, h = WIDTH, DEPTH, HEIGHT
    boards = picture("boards", lambda x, y: (0.55 + 0.08 * (x // 4 % 2), 0.36 + 0.05 * (x // 4 % 2), 0.22, 1))
    floor = material("floor", roughness=0.5)
    show(floor, boards)
    wall, coloured = material("wall", (0.75, 0.74, 0.7)), material("coloured wall", (0.2, 0.36, 0.45))
    quad("Floor", floor, [(0, 0, 0), (w, 0, 0), (w, d, 0), (0, d, 0)], [(0, 0), (4, 0), (4, 3), (0, 3)])
    quad("Ceiling", wall, [(0, d, h), (w, d, h), (w, 0, h), (0, 0, h)])
    quad("Left wall", coloured, [(0, 0, 0), (0, d, 0), (0, d, h), (0, 0, h)])
    quad("Right wall", wall, [(w, d, 0), (w, 0, 0), (w, 0, h), (w, d, h)])
    # The far wall has an opening, from (a, c) to (b, e), which the pane closes.
    a, b, c, e = 2.4, 3.6, 0.9, 2.0
    outer, inner = [(0, 0), (w, 0), (w, h), (0, h)], [(a, c), (b, c), (b, e), (a, e)]
    vertices = [(x, d, z) for x, z in outer + inner]
    mesh_object("Far wall", wall, vertices, [(i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i) for i in range(4)])
    glass = material("glass", (1, 1, 1), roughness=0, Transmission=1.0, IOR=1.5)
    quad("Pane", glass, [(a, d + 0.05, c), (b, d + 0.05, c), (b, d + 0.05, e), (a, d + 0.05, e)])


def furniture():
    wood = material("wood", (0.4, 0.22, 0.1), roughness=0.4)
    table = box("Table", wood, (1.2, 0.7, 0.06), (1.2, 1.9, 0.72))
    bevel = table.modifiers.new("Bevel", "BEVEL")
    bevel.width, bevel.segments = 0.02, 2
    # Four legs share one mesh.
    leg = box("Leg", wood, (0.05, 0.05, 0.69), (0.66, 1.6, 0.345))
    for i, (x, y) in enumerate(((1.74, 1.6), (1.74, 2.2), (0.66, 2.2)), 2):
        add(f"Leg {i}", leg.data, (x, y, 0.345))
    metal = material("metal", (0.9, 0.7, 0.4), roughness=0.25, Metallic=1.0)
    bowl = box("Pebble", metal, (0.3, 0.3, 0.3), (1.0, 1.8, 0.87))
    bowl.modifiers.new("Subdivision", "SUBSURF").levels = 2
    for face in bowl.data.polygons:
        face.use_smooth = True
    # Vertex colours, which the shader multiplies with nothing: Blender exports them beside a white base colour.
    painted = material("painted", (1, 1, 1))
    block = box("Painted block", painted, (0.4, 0.4, 0.8), (3.2, 1.2, 0.4))
    colours = block.data.color_attributes.new("Colour", "FLOAT_COLOR", "POINT")
    for i, vertex in enumerate(block.data.vertices):
        colours.data[i].color = (0.8, 0.2, 0.1, 1) if vertex.co.z < 0 else (0.9, 0.8, 0.3, 1)
    node = painted.node_tree.nodes.new("ShaderNodeVertexColor")
    node.layer_name = "Colour"
    painted.node_tree.links.new(node.outputs["Color"], painted.node_tree.nodes["Principled BSDF"].inputs["Base Color"])
    leaf = material("leaf", (0.1, 0.4, 0.1))
    show(leaf, picture("leaf", lambda x, y: (0.1, 0.45, 0.12, 1.0 if abs(x - 7.5) < 2 + 2 * (y % 4) else 0.0)), alpha=True)
    corners = [(1.5, 1.75, 0.75), (1.75, 1.9, 0.75), (1.75, 1.95, 1.2), (1.5, 1.8, 1.2)]
    quad("Leaf", leaf, corners, [(0, 0), (1, 0), (1, 1), (0, 1)])


def lights():
    light("Bulb", "POINT", BULB_W, (3.0, 2.2, 2.1), colour=(1, 0.8, 0.6))
    spot = light("Spot", "SPOT", SPOT_W, (0.8, 0.6, 2.4), (-25, 0, 10))
    spot.data.spot_size, spot.data.spot_blend = math.radians(60), 0.25
    light("Sun", "SUN", SUN_W_M2, (3, 6, 5), (-55, 0, 10), (1, 0.95, 0.85))
    # The exporter leaves out area lamps; the strip below stands for them.
    area = light("Area lamp", "AREA", AREA_W, (2, 1.5, 2.45))
    area.data.size = 0.6
    glow = material("glow", (0, 0, 0), Emission=(1, 0.9, 0.75, 1), Emission_Strength=STRIP_STRENGTH)
    glow.use_backface_culling = True  # otherwise both sides shine
    quad("Strip", glow, [(1.6, 0.9, 2.45), (1.6, 1.2, 2.45), (2.8, 1.2, 2.45), (2.8, 0.9, 2.45)])
    moving = light("Moving lamp", "POINT", MOVING_W, (0.4, 2.6, 0.4))
    moving.keyframe_insert("location", frame=1)
    moving.location = (3.6, 2.6, 0.4)
    moving.keyframe_insert("location", frame=1 + FRAMES)
    for curve in moving.animation_data.action.fcurves:
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
    # A lamp that stands on the table, turned and shifted with it.
    table = bpy.data.objects["Table"]
    table.rotation_euler = (0, 0, math.radians(20))
    lamp = light("Table lamp", "POINT", TABLE_LAMP_W, (-0.4, 0, 0.35))
    lamp.parent = table


def main():
    target, mode = (sys.argv[sys.argv.index("--") + 1 :] + ["SPEC"])[:2]
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 1 + FRAMES
    building()
    furniture()
    lights()
    camera = add("Camera", bpy.data.cameras.new("Camera"), (1.9, -2.6, 1.5), (86, 0, 0))
    camera.data.angle = math.radians(58)
    scene.camera = camera
    scene.render.resolution_x, scene.render.resolution_y = 960, 720
    bpy.ops.export_scene.gltf(
        filepath=target,
        export_format="GLB",
        export_apply=True,  # modifiers
        export_cameras=True,
        export_lights=True,
        export_image_format="AUTO",
        convert_lighting_mode=mode,
    )


main()
