"""Exported scripts in Blender, run by `bpy` in a new process.

``in_blender.py irradiance NORMALS.npy SCRIPT.py ...`` writes SCRIPT.npy, irradiance on surfaces
with these normals; ``rec2020`` writes it in a file of that working space, and ``near`` at a point,
which is the first row of NORMALS.npy.
``in_blender.py balls CAMERA.npy SCRIPT.py`` writes an image, SCRIPT.exr;
``in_blender.py towards DIRECTIONS.npy SCRIPT.py`` writes one for each direction, SCRIPT.0.exr.
"""

import runpy
import sys
from pathlib import Path

import numpy as np


def empty_scene(samples):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.seed = samples, 1
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.cycles.sample_clamp_indirect = 0
    scene.view_settings.view_transform = "Standard"
    return scene


def material(thing, shader, **inputs):
    made = bpy.data.materials.new("surface")
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    surface = nodes.new(shader)
    for name, value in {"Roughness": 0, "Color": (1, 1, 1, 1), **inputs}.items():
        surface.inputs[name].default_value = value
    links.new(surface.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    thing.data.materials.append(made)


def facets(normals, radius=1.0):
    """White triangles that touch a sphere: none shades another."""
    corners, triangles = [], []
    for normal in map(Vector, normals):
        side = normal.orthogonal().normalized()
        up = normal.cross(side)
        triangles.append([len(corners) + k for k in range(3)])
        corners += [normal + 0.01 * side, normal + 0.01 * (up - side), normal - 0.01 * (up + side)]
    mesh = bpy.data.meshes.new("facets")
    mesh.from_pydata(corners, [], triangles)
    thing = bpy.data.objects.new("facets", mesh)
    thing.scale = (radius, radius, radius)
    bpy.context.scene.collection.objects.link(thing)
    material(thing, "ShaderNodeBsdfDiffuse")
    return thing


def irradiance(normals, script, working_space=None, point=None):
    empty_scene(samples=512 if point is None else 4096)
    if working_space:
        if not hasattr(bpy.data, "colorspace"):  # before Blender 5
            return np.zeros((0, 3))
        bpy.ops.wm.set_working_color_space(working_space=working_space)
    thing = facets(normals, 1.0 if point is None else 5e-4)
    runpy.run_path(str(script))
    for each in bpy.data.collections["envlights"].objects if point is not None else ():
        each.location -= Vector(point)
    mesh = thing.data
    found = mesh.color_attributes.new("found", "FLOAT_COLOR", "CORNER")
    mesh.color_attributes.active_color = found
    bpy.context.view_layer.objects.active = thing
    thing.select_set(True)
    passes = {"DIRECT", "INDIRECT"}
    bpy.ops.object.bake(type="DIFFUSE", pass_filter=passes, target="VERTEX_COLORS")
    colours = np.zeros(4 * len(mesh.loops), np.float32)
    mesh.color_attributes["found"].data.foreach_get("color", colours)
    return np.pi * colours.reshape(-1, 3, 4)[..., :3].mean(axis=1)


def ball(place, shader):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64, location=place)
    thing = bpy.context.object
    bpy.ops.object.shade_smooth()
    material(thing, shader)


def balls(camera, script):
    """A matte and a mirror ball, from the axes of a camera: right, up, towards the eye."""
    right, up, back = map(Vector, camera)
    empty_scene(samples=64)
    ball(-1.05 * right, "ShaderNodeBsdfDiffuse")
    ball(1.05 * right, "ShaderNodeBsdfGlossy")
    runpy.run_path(str(script))
    eye = bpy.data.objects.new("eye", bpy.data.cameras.new("eye"))
    eye.data.type, eye.data.ortho_scale = "ORTHO", 4.2
    eye.matrix_world = (
        Matrix.Translation(20 * back) @ Matrix((right, up, back)).transposed().to_4x4()
    )
    photograph(eye, (256, 128), script.with_suffix(".exr"))


def still_life(matrices, script):
    """The scene of `plot.scene`, from the matrices of its shapes and its eye; two noises."""
    scene = empty_scene(samples=256)
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = 2
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 1
    bpy.ops.mesh.primitive_plane_add(size=2)
    floor = bpy.context.object
    bpy.ops.mesh.primitive_cube_add(size=2)
    box = bpy.context.object
    bpy.ops.mesh.primitive_uv_sphere_add(segments=256, ring_count=128)
    round_one = bpy.context.object
    bpy.ops.object.shade_smooth()
    for name, thing in {"floor": floor, "box": box, "ball": round_one}.items():
        thing.matrix_world = Matrix(matrices[name])
        material(thing, "ShaderNodeBsdfDiffuse", Color=(0.7, 0.7, 0.7, 1))
    runpy.run_path(str(script))
    eye = bpy.data.objects.new("eye", bpy.data.cameras.new("eye"))
    eye.data.sensor_fit, eye.data.angle = "HORIZONTAL", np.radians(32)
    eye.matrix_world = Matrix(matrices["eye"])
    for seed in (1, 2):
        scene.cycles.seed = seed
        photograph(eye, (120, 80), script.with_suffix(f".{seed}.exr"))


def towards(directions, script):
    """Render one image for each direction from the origin."""
    scene = empty_scene(samples=4)
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 1
    # Before the script, which must let the camera see as far as the cards.
    eye = bpy.data.objects.new("eye", bpy.data.cameras.new("eye"))
    eye.data.type, eye.data.ortho_scale = "ORTHO", 1e-3
    runpy.run_path(str(script))
    eye.rotation_mode = "QUATERNION"
    for j, there in enumerate(directions):
        eye.rotation_quaternion = Vector(there).to_track_quat("-Z", "Y")
        photograph(eye, (4, 4), script.with_suffix(f".{j}.exr"))


def photograph(eye, size, path):
    scene = bpy.context.scene
    if eye.name not in scene.collection.objects:
        scene.collection.objects.link(eye)
    scene.camera = eye
    render = scene.render
    render.resolution_x, render.resolution_y = size
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"
    render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    # Not above: pytest imports this file too, to look for doctests.
    import bpy
    from mathutils import Matrix, Vector

    task, given, *scripts = sys.argv[1:]
    for path in map(Path, scripts):
        if task == "irradiance":
            np.save(path.with_suffix(".npy"), irradiance(np.load(given), path))
        elif task == "rec2020":
            there = irradiance(np.load(given), path, "Linear Rec.2020")
            np.save(path.with_suffix(".npy"), there)
        elif task == "near":
            point, *normals = np.load(given).tolist()
            np.save(path.with_suffix(".npy"), irradiance(normals, path, point=point))
        elif task == "still_life":
            still_life({name: each.tolist() for name, each in np.load(given).items()}, path)
        elif task == "towards":
            towards(np.load(given).tolist(), path)
        else:
            balls(np.load(given).tolist(), path)
