"""Cards in Blender: area lights with a texture, emissive planes if oblique or round, and points."""

from __future__ import annotations

import numpy as np

from envlights._common.words import fill_template
from envlights.export.files import check_link
from envlights.export.panels import Panel, crop_names

#: Part of the script. A light of Cycles hides nothing, and so do the planes, which are transparent.
_CODE = '''
# Rectangles: rotation and position (4 x 4), width, height, radiance, texture.
RECTANGLES = [
@RECTANGLES@]
# Planes: vertices, texture coordinates, texture.
PLANES = [
@PLANES@]
# Spheres: position, radius, radiant intensity.
SPHERES = [
@SPHERES@]


def add_cards(collection):
    for name, matrix, width, height, rgb, texture in RECTANGLES:
        radiance = in_working_space(rgb)
        lamp = bpy.data.lights.new(f"envlights_{name}", "AREA")
        lamp.shape, lamp.size, lamp.size_y = "RECTANGLE", width, height
        lamp.color = [value / (max(radiance) or 1) for value in radiance]
        lamp.energy = math.pi * width * height * max(radiance)  # W; EEVEE shows this one colour
        if lamp.node_tree is None:  # before Blender 5
            lamp.use_nodes = True
        nodes, links = lamp.node_tree.nodes, lamp.node_tree.links
        nodes.clear()
        emission = nodes.new("ShaderNodeEmission")
        links.new(emission.outputs[0], nodes.new("ShaderNodeOutputLight").inputs["Surface"])
        place = nodes.new("ShaderNodeNewGeometry").outputs["Parametric"]
        across = nodes.new("ShaderNodeMapping")  # x of the light is to the left
        across.inputs["Location"].default_value = (1, 0, 0)
        across.inputs["Scale"].default_value = (-1, 1, 1)
        links.new(place, across.inputs["Vector"])
        image = image_node(nodes, texture)
        links.new(across.outputs["Vector"], image.inputs["Vector"])
        relative = nodes.new("ShaderNodeVectorMath")
        relative.operation = "DIVIDE"
        relative.inputs[1].default_value = [value or 1 for value in radiance]
        links.new(image.outputs["Color"], relative.inputs[0])
        links.new(relative.outputs["Vector"], emission.inputs["Color"])
        light = bpy.data.objects.new(f"envlights_{name}", lamp)
        light.matrix_world = Matrix(matrix)
        light.visible_camera = True
        collection.objects.link(light)
    for name, centre, radius, rgb in SPHERES:
        intensity = in_working_space(rgb)
        lamp = bpy.data.lights.new(f"envlights_{name}", "POINT")
        lamp.color = [value / (max(intensity) or 1) for value in intensity]
        lamp.energy = 4 * math.pi * max(intensity)  # W
        lamp.shadow_soft_size, lamp.use_soft_falloff = radius, False
        light = bpy.data.objects.new(f"envlights_{name}", lamp)
        light.location, light.visible_camera = centre, True
        collection.objects.link(light)
    for name, points, places, texture in PLANES:
        mesh = bpy.data.meshes.new(f"envlights_{name}")
        mesh.from_pydata(points, [], [list(range(len(points)))])
        layer = mesh.uv_layers.new(name="UVMap")
        for loop in mesh.loops:
            layer.data[loop.index].uv = places[loop.vertex_index]
        mesh.materials.append(glowing(name, texture))
        collection.objects.link(bpy.data.objects.new(f"envlights_{name}", mesh))
    show_to_cameras()


def show_to_cameras():
    """Let cameras see as far as the cards; a new one ends at 100 m."""
    places = [Matrix(matrix).translation for _, matrix, *_ in RECTANGLES]
    places += [Vector(point) for _, points, *_ in PLANES for point in points]
    places += [Vector(centre) for _, centre, *_ in SPHERES]
    reach = 2 * max((place.length for place in places), default=0)
    for camera in bpy.data.cameras:
        camera.clip_end = max(camera.clip_end, reach)


def glowing(name, texture):
    """A surface that adds light on its front, and hides nothing."""
    made = bpy.data.materials.new(f"envlights_{name}")
    if made.node_tree is None:  # before Blender 5
        made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    emission, clear, both = map(
        nodes.new, ("ShaderNodeEmission", "ShaderNodeBsdfTransparent", "ShaderNodeAddShader")
    )
    front = nodes.new("ShaderNodeMath")
    front.operation = "SUBTRACT"
    front.inputs[0].default_value = 1
    facing = nodes.new("ShaderNodeNewGeometry")
    links.new(facing.outputs["Backfacing"], front.inputs[1])
    links.new(front.outputs[0], emission.inputs["Strength"])
    uv = nodes.new("ShaderNodeUVMap")
    image = image_node(nodes, texture)
    links.new(uv.outputs["UV"], image.inputs["Vector"])
    links.new(image.outputs["Color"], emission.inputs["Color"])
    links.new(emission.outputs[0], both.inputs[0])
    links.new(clear.outputs[0], both.inputs[1])
    links.new(both.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return made


def image_node(nodes, texture):
    node = nodes.new("ShaderNodeTexImage")
    node.image = load(texture)
    node.extension = "EXTEND"
    return node

'''


def code(panels: tuple[Panel, ...], prefix: str) -> str:
    """Numbers and functions for a script; empty without panels."""
    if not panels:
        return ""
    names = crop_names(panels, prefix, "blender")
    for name in names:
        check_link(name, "Blender", "\\")
    pairs = list(zip(panels, names, strict=True))
    rectangles = [_rectangle(*pair) for pair in pairs if _is_lamp(pair[0])]
    planes = [_plane(*pair) for pair in pairs if pair[1] and not _is_lamp(pair[0])]
    spheres = [_sphere(panel) for panel in panels if panel.shape == "sphere"]
    lists = {"rectangles": rectangles, "planes": planes, "spheres": spheres}
    return fill_template(_CODE, **{name: "".join(rows) for name, rows in lists.items()})


def _is_lamp(panel: Panel) -> bool:
    """True for a rectangle; an area light of Blender is not sheared."""
    return panel.is_rectangle and panel.shape in ("rectangle", "tube")


def _rectangle(panel: Panel, name: str) -> str:
    """Local x to the left, y up and z away, as seen from the origin; the light shines along -z."""
    u, v, facing, centre = panel.axes("blender")
    width, height = panel.size.tolist()
    matrix = np.eye(4)
    matrix[:3] = np.stack([-u / width, -v / height, -facing, centre], axis=1)
    row = panel.name, matrix.tolist(), width, height, panel.radiance.tolist(), name
    return f"    ({', '.join(map(ascii, row))}),\n"


def _sphere(panel: Panel) -> str:
    *_, centre = panel.axes("blender")
    row = panel.name, centre.tolist(), panel.radius, panel.intensity.tolist()
    return f"    ({', '.join(map(ascii, row))}),\n"


def _plane(panel: Panel, name: str) -> str:
    points, places = panel.outline("blender")
    uv = (places * [1, -1] + [0, 1]).tolist()
    return f"    ({', '.join(map(ascii, (panel.name, points.tolist(), uv, name)))}),\n"
