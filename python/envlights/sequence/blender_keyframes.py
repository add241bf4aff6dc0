"""Blender: a Python script that makes sun lamps and a world with keyframes."""

from __future__ import annotations

from collections.abc import Iterable

from envlights._common.words import fill_template
from envlights.export.formats.blender import WORKING_SPACE
from envlights.export.targets import AXES
from envlights.sequence.frame_rig import FrameRig
from envlights.sequence.light_tracks import tracks_of

#: Runs in Blender 4.2 and newer. A second run replaces the objects of the first.
_SCRIPT = '''\
"""Animated lights of envlights: run this in Blender's Text Editor, or by blender --python."""

import bpy
from mathutils import Color, Vector

# Units: @UNITS@. Colours are linear Rec.709, whatever the working space of the file.
FPS = @FPS@
FRAMES = @FRAMES@
# Of each light by its identity, for each frame: direction towards the light (z up), colour,
# irradiance at normal incidence, full angle in radians.
LIGHTS = {
@LIGHTS@}
# Radiance of the world in each frame.
AMBIENT = @AMBIENT@

@WORKING_SPACE@

def add_light(collection, identity, keys):
    name = f"envlights_{identity}"
    lamp = bpy.data.lights.new(name, "SUN")
    sun = bpy.data.objects.new(name, lamp)
    sun.rotation_mode = "QUATERNION"
    collection.objects.link(sun)
    last = None
    for frame, (towards, colour, energy, angle) in zip(FRAMES, keys):
        turn = Vector(towards).to_track_quat("Z", "Y")  # shines along -z
        if last is not None:
            turn.make_compatible(last)  # the shorter way
        last = turn
        sun.rotation_quaternion = turn
        rgb = in_working_space(colour)
        most = max(rgb) or 1
        lamp.color = [value / most for value in rgb]
        lamp.energy, lamp.angle = most * energy, angle  # energy in W/m2
        sun.keyframe_insert("rotation_quaternion", frame=frame)
        for name in ("color", "energy", "angle"):
            lamp.keyframe_insert(name, frame=frame)


def set_world(scene):
    world = bpy.data.worlds.new("envlights")
    if world.node_tree is None:  # before Blender 5
        world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    nodes.clear()
    background = nodes.new("ShaderNodeBackground")
    background.inputs["Strength"].default_value = 1
    links.new(background.outputs[0], nodes.new("ShaderNodeOutputWorld").inputs["Surface"])
    for frame, radiance in zip(FRAMES, AMBIENT):
        background.inputs["Color"].default_value = (*in_working_space(radiance), 1)
        background.inputs["Color"].keyframe_insert("default_value", frame=frame)
    scene.world = world


def main():
    scene = bpy.context.scene
    old = bpy.data.collections.get("envlights")
    if old:  # from an earlier run
        for thing in list(old.objects):
            bpy.data.objects.remove(thing)
        bpy.data.collections.remove(old)
    new = bpy.data.collections.new("envlights")
    scene.collection.children.link(new)
    for identity, keys in LIGHTS.items():
        add_light(new, identity, keys)
    set_world(scene)
    scene.frame_start, scene.frame_end = FRAMES[0], FRAMES[-1]
    scene.render.fps = max(1, round(FPS))
    scene.render.fps_base = scene.render.fps / FPS


main()
'''


def blender(rigs: Iterable[FrameRig], fps: float | None = None) -> str:
    """A Python script that makes animated sun lamps and a world.

    Axes and units as in `el.export.blender`; frames of Blender have the numbers of the frames. A
    light has the strength 0 in frames without it. Over a floor, the world lights from below too.

    Parameters
    ----------
    rigs : iterable of FrameRig
        Rigs of the frames, such as a `RigSequence`.
    fps : float, optional
        Frames in a second. Default: 24.

    Returns
    -------
    str

    Examples
    --------
    >>> import envlights as el
    >>> lamp = el.Lights([[0, 1, 0]], [[3, 2, 1]], [0.25])
    >>> script = blender([el.sequence.FrameRig([0, 0, 0], lamp, 0.0, ids=(2,))])
    >>> "    2: [" in script, "[0.0, 0.0, 1.0]" in script
    (True, True)
    """
    tracks = tracks_of(rigs, "blender", fps)
    lights = ""
    for track in tracks.lights:
        towards = AXES["blender"].to_target(track.direction).tolist()
        columns = (
            towards,
            track.colour.tolist(),
            track.intensity.tolist(),
            (2 * track.radius).tolist(),
        )
        keys = "".join(f"        {key},\n" for key in zip(*columns, strict=True))
        lights += f"    {track.id}: [\n{keys}    ],\n"
    return fill_template(
        _SCRIPT,
        units=tracks.statement,
        working_space=WORKING_SPACE,
        fps=repr(tracks.fps),
        frames=repr(list(tracks.frames)),
        lights=lights,
        ambient=repr(tracks.ambient.tolist()),
    )
