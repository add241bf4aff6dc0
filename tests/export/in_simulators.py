"""A white ball under an exported script, in SAPIEN or Genesis.

``in_simulators.py PROGRAM SIDES.npy SCRIPT.py`` writes SIDES.out.npy, codes of a picture from each
side: right, up, and towards the eye, in the program's frame. ``lights`` as the program writes what
Genesis has read: rows of towards and irradiance over scale, and the ambient term last.
"""

import runpy
import sys
from pathlib import Path

import numpy as np

#: Pixels of a picture and the width that it shows, as in `balls.py`, and the distance of the eye.
SIDE, SQUARE, FAR = 192, 2.1, 2000


def in_sapien(sides, script):
    import sapien

    scene = sapien.Scene()
    matte = sapien.render.RenderMaterial()
    matte.base_color, matte.metallic, matte.specular, matte.roughness = [1] * 4, 0, 0, 0
    builder = scene.create_actor_builder()
    builder.add_sphere_visual(radius=1, material=matte)
    builder.build_kinematic("ball")
    runpy.run_path(script)["add_lights"](scene)
    camera = scene.add_camera("eye", SIDE, SIDE, 2 * np.arctan(SQUARE / 2 / FAR), FAR - 9, FAR + 9)
    for right, up, back in sides:
        pose = np.eye(4)
        pose[:3] = np.stack([-back, -right, up, FAR * back], axis=1)  # x ahead, y to the left
        camera.set_pose(sapien.Pose(pose))
        scene.update_render()
        camera.take_picture()
        yield 255 * camera.get_picture("Color")[..., :3]


def lights_of_genesis(_, script):
    import genesis as gs

    gs.init(backend=gs.cpu, logging_level="warning")
    scene = gs.Scene(show_viewer=False, vis_options=runpy.run_path(script)["vis_options"]())
    scene.add_entity(gs.morphs.Plane())
    scene.build()
    drawn = scene.visualizer.context._scene
    for node in drawn.light_nodes:
        colour = node.light.intensity * np.array(node.light.color)
        yield np.stack([drawn.get_pose(node)[:3, 2], colour])
    yield np.stack([np.zeros(3), drawn.ambient_light])


def in_genesis(sides, script):
    import genesis as gs

    gs.init(backend=gs.cpu, logging_level="warning")
    options = runpy.run_path(script)["vis_options"](shadow=False)
    scene = gs.Scene(show_viewer=False, vis_options=options)
    white = gs.surfaces.Rough(color=(1, 1, 1))
    scene.add_entity(gs.morphs.Sphere(radius=1, fixed=True), surface=white)
    angle = np.degrees(2 * np.arctan(SQUARE / 2 / FAR))
    eyes = [
        scene.add_camera(
            res=(SIDE, SIDE), pos=FAR * back, lookat=(0, 0, 0), up=up, fov=angle,
            near=FAR - 9, far=FAR + 9, GUI=False,
        )
        for _, up, back in sides
    ]  # fmt: skip
    scene.build()
    for eye in eyes:
        yield np.array(eye.render()[0], float)


if __name__ == "__main__":
    program, given, script = sys.argv[1:]
    draw = {"sapien": in_sapien, "genesis": in_genesis, "lights": lights_of_genesis}[program]
    np.save(Path(given).with_suffix(".out.npy"), list(draw(np.load(given), script)))
