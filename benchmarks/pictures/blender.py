"""Ball on a floor in Cycles, for `one_picture.py`: ``blender.py FOLDER``."""

import json
import runpy
import sys
from pathlib import Path

import numpy as np

if __name__ == "__main__":
    sys.path[0] = ""
    import bpy
    from mathutils import Matrix, Vector

    folder = Path(sys.argv[1])
    given = json.loads((folder / "scene.json").read_text())
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.max_bounces = 1024, 0
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 1
    white = bpy.data.materials.new("white")
    white.use_nodes = True
    nodes = white.node_tree.nodes
    nodes.clear()
    shader = nodes.new("ShaderNodeBsdfDiffuse")
    shader.inputs["Color"].default_value = [given["albedo"]] * 3 + [1]
    output = nodes.new("ShaderNodeOutputMaterial")
    white.node_tree.links.new(shader.outputs[0], output.inputs["Surface"])
    bpy.ops.mesh.primitive_plane_add(size=40)
    bpy.context.object.data.materials.append(white)
    radius = given["radius"]
    place = (0, 0, radius)
    bpy.ops.mesh.primitive_uv_sphere_add(
        segments=512, ring_count=256, radius=radius, location=place
    )
    bpy.ops.object.shade_smooth()
    bpy.context.object.data.materials.append(white)
    runpy.run_path(str(folder / "rig.py"))
    eye = bpy.data.objects.new("eye", bpy.data.cameras.new("eye"))
    eye.data.sensor_fit, eye.data.angle = "HORIZONTAL", np.radians(given["fov"])
    turn = Matrix(given["frame"]).transposed().to_4x4()
    eye.matrix_world = Matrix.Translation(Vector(given["eye"])) @ turn
    scene.collection.objects.link(eye)
    scene.camera = eye
    scene.render.resolution_x, scene.render.resolution_y = given["size"]
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(folder / "picture.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(folder / "picture.exr"))
    columns, rows = given["size"]
    pixels = np.array(image.pixels[:]).reshape(rows, columns, 4)[::-1, :, :3]
    np.save(folder / "picture.npy", np.pi * pixels)
