"""Blender: a Python script, or the same lights in a running Blender."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from envlights._common.words import fill_template
from envlights._native import EnvLightsError
from envlights.environment.reading import AnyMap
from envlights.export.files import AnyPath, check_link
from envlights.export.formats import blender_cards
from envlights.export.scene import Exportable, Scene, scene_of
from envlights.export.targets import AXES
from envlights.export.textures import Beside, save_beside
from envlights.kernels.angles import POLES, angle_cells

#: Function of scripts. Blender 5 has other working spaces than Rec.709, and mixes in them.
WORKING_SPACE = '''
def in_working_space(rgb):
    """Linear Rec.709 in the primaries of this file, as Color Management names them."""
    return tuple(Color(rgb).from_rec709_linear_to_scene_linear())
'''
#: Runs in Blender 4.2 and newer. A second run replaces the objects of the first.
_SCRIPT = '''\
"""Lights of envlights: run this in Blender's Text Editor, or by blender --python."""

import math
import os

import bpy
from mathutils import Color, Matrix, Vector

# Units: @UNITS@.
# Colours are linear Rec.709, whatever the working space of the file.
# Direction towards the light (z up), irradiance at normal incidence, full angle in radians.
# Comments: azimuth in the map, from its left edge to the right, and elevation above the horizon.
LIGHTS = [
@LIGHTS@]
# Radiance of the world, and an equirectangular map in its place.
AMBIENT = @AMBIENT@
MAP = @MAP@
@CARDS@
@WORKING_SPACE@

def add_lights(collection):
    for j, (towards, rgb, angle) in enumerate(LIGHTS):
        name, irradiance = f"envlights_{j}", in_working_space(rgb)
        lamp = bpy.data.lights.new(name, "SUN")
        lamp.energy = max(irradiance)  # W/m2
        lamp.color = [value / (max(irradiance) or 1) for value in irradiance]
        lamp.angle = angle
        sun = bpy.data.objects.new(name, lamp)
        sun.rotation_mode = "QUATERNION"
        sun.rotation_quaternion = Vector(towards).to_track_quat("Z", "Y")  # shines along -z
        collection.objects.link(sun)


def set_world(scene):
    world = bpy.data.worlds.new("envlights")
    if world.node_tree is None:  # before Blender 5
        world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    nodes.clear()
    background = nodes.new("ShaderNodeBackground")
    background.inputs["Color"].default_value = (*in_working_space(AMBIENT), 1)
    background.inputs["Strength"].default_value = 1
    links.new(background.outputs[0], nodes.new("ShaderNodeOutputWorld").inputs["Surface"])
    if MAP:
        texture = nodes.new("ShaderNodeTexEnvironment")
        texture.image = load(MAP)
        links.new(texture.outputs["Color"], background.inputs["Color"])
    scene.world = world


def load(name):
    """An image of linear Rec.709 in this file, which needs no other."""
    image = bpy.data.images.load(beside(name))
    image.colorspace_settings.name = "Linear Rec.709"
    image.pack()
    return image


def beside(name):
    """A file beside this script, which Blender may have opened as a text."""
    texts = [bpy.path.abspath(text.filepath) for text in bpy.data.texts if text.filepath]
    places = [os.path.join(os.path.dirname(path), name) for path in (__file__, *texts)]
    found = [path for path in places if os.path.isfile(path)]
    if not found:
        raise FileNotFoundError(f"the map {name} must be beside this script, at {places[0]}")
    return os.path.abspath(found[0])


def main():
    old = bpy.data.collections.get("envlights")
    if old:  # from an earlier run
        for thing in list(old.objects):
            bpy.data.objects.remove(thing)
        bpy.data.collections.remove(old)
    new = bpy.data.collections.new("envlights")
    bpy.context.scene.collection.children.link(new)
    add_lights(new)
@ADD_CARDS@    set_world(bpy.context.scene)


main()
'''


def blender(
    rig: Exportable, environment: AnyMap | None = None, texture: str = "ambient.exr"
) -> str:
    """A Python script that makes sun lamps and a world; it replaces those of its last run.

    Axes: our x, y, z are y, z, x in Blender, +z up. So the lights fit the panorama as an
    environment texture without rotation. Blender's importers of glTF and OBJ convert +y up in
    another way: rotate imported objects by 90 degrees about the vertical.

    Units: the strength of a sun lamp is irradiance at normal incidence in W/m², its colour is a
    factor, and `angle` is the full angle of the disc. The background is radiance. After
    `EnvMap.calibrated` the numbers are lux and cd/m² over 683 lm/W, as Blender's glTF importer
    converts them, so that a glTF of the rig gives the same lamps. Exposure is a setting of the
    scene, in Color Management; the view transform "Standard" shows the map's colours unchanged.
    Numbers are linear Rec.709; the script converts them to the working space of the open file,
    which Blender 5 can choose.

    Kept: directions, irradiances, sizes; a constant ambient term as background, harmonics and an
    ambient term over a floor as a small map. Lost: harmonics where they are negative.

    Parameters
    ----------
    rig : Rig, Lights or Cards
    environment : EnvMap or array_like, optional
        Map that replaces the ambient term.
    texture : str
        Name of the map's file beside the script, if there is a map; `save_blender` writes it.

    See Also
    --------
    add_to_blender : add the lights to a running Blender.

    Examples
    --------
    >>> import envlights as el
    >>> script = el.export.blender(el.Lights([[0, 1, 0]], [[3, 2, 1]], [0.25]))
    >>> next(line for line in script.splitlines() if line.startswith("    ("))
    '    ([0.0, 0.0, 1.0], [3.0, 2.0, 1.0], 0.5),  # zenith'
    """
    return _script(scene_of(rig, environment, target="blender"), Beside(texture))


def save_blender(
    rig: Exportable, path: AnyPath, environment: AnyMap | None = None, *, texture: str | None = None
) -> None:
    """Write `blender` at `path`, and its map beside it, unless the map is the file `texture`."""
    scene = scene_of(rig, environment, target="blender")
    save_beside(path, scene, "blender", _script, texture, crop_of=lambda panel: panel.texture)


def add_to_blender(rig: Exportable, environment: AnyMap | None = None) -> None:
    """Run the script of `blender` in this process: in Blender, or with `bpy` from PyPI.

    The open scene gets a collection "envlights" of sun lamps, and a new world; a map is packed.

    Parameters
    ----------
    rig : Rig, Lights or Cards
    environment : EnvMap or array_like, optional
        Map that replaces the ambient term.

    Raises
    ------
    EnvLightsError
        If `bpy` cannot be imported.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "lights.py"
        save_blender(rig, path, environment)
        code = compile(path.read_text(encoding="utf-8"), str(path), "exec")
        try:
            exec(code, {"__file__": str(path), "__name__": "envlights_in_blender"})
        except ImportError as error:
            raise EnvLightsError(
                f"Blender cannot be imported: {error}; run this inside Blender, or install bpy"
            ) from None


def _place(direction: NDArray[np.float64]) -> str:
    """Azimuth and elevation of a light in its map, as ASCII."""
    azimuth, elevation = (cell.replace("°", " degrees") for cell in angle_cells(direction))
    return azimuth if azimuth in POLES else f"azimuth {azimuth}, elevation {elevation}"


def _script(scene: Scene, names: Beside) -> str:
    if scene.environment is not None:
        # Blender takes backslashes in paths for slashes on all systems.
        check_link(names.map, "Blender", "\\")
    lights = scene.lights
    towards = AXES["blender"].to_target(lights.direction).tolist()
    arrays = towards, lights.irradiance.tolist(), lights.angular_radius.tolist()
    rows = zip(*arrays, map(_place, lights.direction), strict=True)
    written = "".join(
        f"    ({there}, {at}, {2 * radius}),  # {place}\n" for there, at, radius, place in rows
    )
    return fill_template(
        _SCRIPT,
        units=scene.statement,
        working_space=WORKING_SPACE,
        lights=written,
        ambient=str(scene.constant.tolist()),
        map="None" if scene.environment is None else ascii(names.map),
        cards=blender_cards.code(scene.panels, names.prefix),
        add_cards="    add_cards(new)\n" if scene.panels else "",
    )
