"""Ball on a floor in MuJoCo, for `one_picture.py`: ``mujoco.py FOLDER``."""

import json
import sys
from pathlib import Path

import numpy as np

if __name__ == "__main__":
    # The folder of this file holds no package mujoco.
    sys.path[0] = ""
    import mujoco

    folder = Path(sys.argv[1])
    scene = json.loads((folder / "scene.json").read_text())
    right, up, _ = scene["frame"]
    words = lambda values: " ".join(map(str, values))  # noqa: E731
    grey = words([scene["albedo"]] * 3 + [1])
    columns, rows = scene["size"]
    height = 2 * np.degrees(np.arctan(np.tan(np.radians(scene["fov"] / 2)) * rows / columns))
    (folder / "model.xml").write_text(
        f"""<mujoco><include file="rig.mujoco.xml"/>
        <statistic extent="3" center="0 0 0.5"/>
        <visual><quality shadowsize="8192" offsamples="8" numslices="256" numstacks="128"/></visual>
        <asset><material name="white" rgba="{grey}" specular="0" shininess="0"/></asset>
        <worldbody>
        <geom type="plane" size="20 20 1" material="white"/>
        <geom type="sphere" size="{scene["radius"]}" pos="0 0 {scene["radius"]}" material="white"/>
        <camera name="eye" pos="{words(scene["eye"])}" xyaxes="{words(right + up)}"
          fovy="{height}"/>
        </worldbody></mujoco>"""
    )
    model = mujoco.MjModel.from_xml_path(str(folder / "model.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    with mujoco.Renderer(model, rows, columns) as renderer:
        renderer.update_scene(data, "eye")
        np.save(folder / "picture.npy", renderer.render() / 255 / scene["scale"])
