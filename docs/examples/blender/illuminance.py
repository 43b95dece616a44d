"""Renders the illuminance of a plane under each kind of light of Blender, with Cycles.

    blender --background --factory-startup --python docs/examples/blender/illuminance.py -- OUT

The plane is white and diffuse, so that its radiance times pi is the irradiance.  An orthographic camera takes one
picture a light from above, without reflections.  A pixel is a receiver: its filter is so narrow that all its samples
have the same place.  Each light is rendered RUNS times with other random seeds.

OUT gets two files for each light.  `NAME.csv` has the receivers, the mean of the runs as the illuminance and its
standard error.  `NAME.pbrt` has the light for Lucerna, in the units that the manual of Blender states.  One watt counts
as one lumen in both, so that no luminous efficacy hides a factor.
"""
import csv
import math
import pathlib
import sys

import bpy
import numpy as np

OUT = pathlib.Path(sys.argv[sys.argv.index("--") + 1])
PIXELS = 8  # receivers along each side
SIDE_M = 4.0
RUNS = 8
SAMPLES = 256

WATTS = 100.0
SUN_W_M2 = 3.0
CONE = math.radians(40)  # half of the angle of a spot
RIM = 128  # corners of the polygon that stands for an ellipse
WEB = "web.ies"
PLACE = (0.3, -0.2, 1.5)
TILT = (0.35, 0.2, 0.5)  # radians about x, y and z, in this order


def lamp(kind, rotation=TILT, **values):
    """Adds a lamp.  Returns the lines of a .pbrt file that lead to its frame, in which it shines along -z."""
    data = bpy.data.lights.new("lamp", kind)
    for name, value in values.items():
        setattr(data, name, value)
    thing = bpy.data.objects.new("lamp", data)
    thing.location = PLACE
    thing.rotation_euler = rotation
    thing.visible_camera = False
    bpy.context.collection.objects.link(thing)
    bpy.context.view_layer.update()
    columns = [thing.matrix_world[row][column] for column in range(4) for row in range(4)]
    return data, "Transform [" + " ".join(f"{x:.9g}" for x in columns) + "]\n"


def point(radius=0.0):
    _, frame = lamp("POINT", energy=WATTS, shadow_soft_size=radius)
    if radius == 0:
        return frame + f'LightSource "point" "float power" {WATTS}\n'
    return frame + emission() + f'Shape "sphere" "float radius" {radius}\n'


def emission():
    return f'AreaLightSource "diffuse" "float power" {WATTS}\n'


def spot(blend):
    """The edge is a smoothstep of the cosine in Cycles and in pbrt-v4."""
    _, frame = lamp("SPOT", energy=WATTS, shadow_soft_size=0.0, spot_size=2 * CONE, spot_blend=blend)
    inner = math.acos(math.cos(CONE) + (1 - math.cos(CONE)) * blend)
    intensity = WATTS / (4 * math.pi)
    return frame + (f'LightSource "spot" "point3 to" [0 0 -1] "rgb I" [{intensity:.9g} {intensity:.9g} '
                    f'{intensity:.9g}] "float coneangle" {math.degrees(CONE):.9g} '
                    f'"float conedeltaangle" {max(0.0, math.degrees(CONE - inner)):.9g}\n')


def area(shape, size, size_y):
    _, frame = lamp("AREA", energy=WATTS, shape=shape, size=size, size_y=size_y)
    x, y = size / 2, size_y / 2
    if shape in ("SQUARE", "RECTANGLE"):
        # The normal is -z.
        return frame + emission() + (f'Shape "bilinearmesh" "point3 P" [{-x} {y} 0  {x} {y} 0  {-x} {-y} 0  '
                                     f'{x} {-y} 0]\n')
    if shape == "DISK":
        return frame + f'Scale 1 1 -1\n' + emission() + f'Shape "disk" "float radius" {x}\n'
    rim = [2 * math.pi * i / RIM for i in range(RIM)]
    corners = " ".join(f"{x * math.cos(a):.9g} {y * math.sin(a):.9g} 0" for a in rim)
    faces = " ".join(f"0 {i + 1} {i}" for i in range(1, RIM - 1))
    return frame + emission() + f'Shape "trianglemesh" "point3 P" [{corners}] "integer indices" [{faces}]\n'


def sun(angle):
    _, frame = lamp("SUN", energy=SUN_W_M2, angle=angle)
    disk = f'"float angulardiameter" {math.degrees(angle):.9g}' if angle > 0 else ""
    return frame + f'LightSource "distant" "point3 to" [0 0 -1] "float illuminance" {SUN_W_M2} {disk}\n'


def web_text():
    """An IES file without symmetry, in small steps: Cycles interpolates by cubics, Lucerna linearly."""
    tilts, turns = np.arange(0, 91, 2), np.arange(0, 361, 5)
    level = 1000 * np.cos(np.radians(tilts)) ** 2
    lobe = 0.5 * np.sin(np.radians(tilts))
    rows = [level * (1 + lobe * np.cos(np.radians(c)) + 0.5 * lobe * np.sin(np.radians(c))) for c in turns]
    lines = ["IESNA:LM-63-2002", "TILT=NONE", f"1 -1 1 {len(tilts)} {len(turns)} 1 2 0 0 0", "1 1 1"]
    for row in (tilts, turns, *rows):
        lines.append(" ".join(f"{x:.6g}" for x in row))
    return "\n".join(lines) + "\n"


def luminaire():
    data, frame = lamp("POINT", energy=1.0, shadow_soft_size=0.0, rotation=(0, 0, 0.5))
    data.use_nodes = True
    nodes, links = data.node_tree.nodes, data.node_tree.links
    web = nodes.new("ShaderNodeTexIES")
    web.mode = "EXTERNAL"
    (OUT / WEB).write_text(web_text())
    web.filepath = str(OUT / WEB)
    links.new(web.outputs["Fac"], nodes["Emission"].inputs["Strength"])
    # Straight down is +z of Lucerna's frame.  Cycles lays the half plane C0 along -y.
    return frame + f'Scale 1 1 -1\nRotate 270 0 0 1\nLightSource "goniometric" "string filename" "{WEB}"\n'


def sky():
    picture = bpy.data.images.new("sky", 64, 32, float_buffer=True)
    rows, columns = np.mgrid[0:32, 0:64]
    up = np.sin((rows + 0.5) / 32 * math.pi - math.pi / 2)
    around = (columns + 0.5) / 64 * 2 * math.pi
    level = 1 + 0.8 * up + 0.6 * np.cos(around) * np.sqrt(1 - up * up)
    pixels = np.stack([level, level, level, np.ones_like(level)], axis=-1).astype(np.float32)
    picture.pixels.foreach_set(pixels.ravel())
    picture.filepath_raw = str(OUT / "sky.exr")
    picture.file_format = "OPEN_EXR"
    picture.save()
    world = bpy.data.worlds.new("sky")
    bpy.context.scene.world = world
    world.use_nodes = True
    texture = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = bpy.data.images.load(str(OUT / "sky.exr"))
    texture.image.colorspace_settings.name = "Linear"
    texture.interpolation = "Closest"
    world.node_tree.links.new(texture.outputs["Color"], world.node_tree.nodes["Background"].inputs["Color"])
    # The top of the picture is +z in Blender and +y in the frame of a picture of latitude and longitude.
    return ('Transform [1 0 0 0  0 0 1 0  0 -1 0 0  0 0 0 1]\n'
            'LightSource "infinite" "string filename" "sky.exr" "string mapping" "latlong" "string filter" "nearest"\n')


LIGHTS = {
    "point": point,
    "point_with_radius": lambda: point(0.25),
    "spot_hard": lambda: spot(0.0),
    "spot_soft": lambda: spot(0.5),
    "area_square": lambda: area("SQUARE", 0.8, 0.8),
    "area_rectangle": lambda: area("RECTANGLE", 0.8, 0.3),
    "area_disk": lambda: area("DISK", 0.8, 0.8),
    "area_ellipse": lambda: area("ELLIPSE", 0.8, 0.3),
    "sun_parallel": lambda: sun(0.0),
    "sun_disk": lambda: sun(math.radians(10)),
    "ies": luminaire,
    "environment": sky,
}


def start_scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = PIXELS
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.view_settings.view_transform = "Raw"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples = SAMPLES
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    cycles.max_bounces = 0
    cycles.sample_clamp_direct = 0
    cycles.light_sampling_threshold = 0
    cycles.pixel_filter_type = "BLACKMAN_HARRIS"  # a box would be one pixel wide
    cycles.filter_width = 0.01
    bpy.ops.mesh.primitive_plane_add(size=10 * SIDE_M)
    white = bpy.data.materials.new("white")
    white.use_nodes = True
    white.node_tree.nodes.clear()
    diffuse = white.node_tree.nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (1, 1, 1, 1)
    output = white.node_tree.nodes.new("ShaderNodeOutputMaterial")
    white.node_tree.links.new(diffuse.outputs[0], output.inputs["Surface"])
    bpy.context.object.data.materials.append(white)
    camera = bpy.data.cameras.new("camera")
    camera.type = "ORTHO"
    camera.ortho_scale = SIDE_M
    thing = bpy.data.objects.new("camera", camera)
    thing.location = (0, 0, 5)
    bpy.context.collection.objects.link(thing)
    scene.camera = thing
    return scene


def picture(scene, seed):
    scene.cycles.seed = seed
    scene.render.filepath = str(OUT / "picture.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    pixels = np.empty(PIXELS * PIXELS * 4, dtype=np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(PIXELS, PIXELS, 4)[:, :, 1].astype(float)


def main():
    OUT.mkdir(parents=True, exist_ok=True)
    for name, make in LIGHTS.items():
        scene = start_scene()
        (OUT / f"{name}.pbrt").write_text("WorldBegin\n" + make())
        runs = math.pi * np.array([picture(scene, seed) for seed in range(RUNS)])
        mean = runs.mean(axis=0)
        error = runs.std(axis=0, ddof=1) / math.sqrt(RUNS)
        with open(OUT / f"{name}.csv", "w", newline="") as file:
            rows = csv.writer(file)
            rows.writerow(["x", "y", "z", "nx", "ny", "nz", "illuminance", "stderr"])
            for j in range(PIXELS):
                for i in range(PIXELS):
                    x = ((i + 0.5) / PIXELS - 0.5) * SIDE_M
                    y = ((j + 0.5) / PIXELS - 0.5) * SIDE_M
                    rows.writerow([x, y, 0, 0, 0, 1, f"{mean[j, i]:.9g}", f"{error[j, i]:.3g}"])


main()
