"""Blender: irradiance as Cycles renders it, in a process of its own."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import envlights as el
from envlights.export import AXES, blender
from tests.export.balls import CAMERA, check_balls, environment
from tests.export.rigs import AXES as LAMPS
from tests.export.rigs import DISCS, POINTS, relative_error, rigs
from tests.helpers import NORMALS

RIGS = {
    f"{name}_{size}": rig
    for size, lights in {"points": POINTS, "discs": DISCS}.items()
    for name, rig in rigs(lights).items()
}
needs_bpy = pytest.mark.skipif(importlib.util.find_spec("bpy") is None, reason="needs bpy")


def run(*arguments):
    # A process of its own: bpy may be in a process only once, and never leaves it.
    command = [sys.executable, Path(__file__).with_name("in_blender.py"), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]


@pytest.fixture(scope="module")
def irradiances(tmp_path_factory):
    """What Cycles makes of each script."""
    folder = tmp_path_factory.mktemp("blender")
    np.save(folder / "normals.npy", AXES["blender"].to_target(NORMALS))
    scripts = [folder / f"{name}.py" for name in RIGS]
    for rig, script in zip(RIGS.values(), scripts, strict=True):
        rig.save(script)
    run("irradiance", folder / "normals.npy", *scripts)
    return {script.stem: np.load(script.with_suffix(".npy")) for script in scripts}


@needs_bpy
@pytest.mark.parametrize("name", RIGS)
def test_the_irradiance_that_cycles_renders_is_that_of_the_rig(name, irradiances):
    assert relative_error(irradiances[name], RIGS[name]) < 0.005


@needs_bpy
def test_map_and_lights_meet_on_two_balls(tmp_path):
    np.save(tmp_path / "camera.npy", AXES["blender"].to_target(CAMERA))
    LAMPS.save(tmp_path / "balls.py", environment=environment())
    run("balls", tmp_path / "camera.npy", tmp_path / "balls.py")
    check_balls(el.io.read_image(tmp_path / "balls.exr").pixels)


@needs_bpy
def test_the_lights_of_an_earlier_run_are_replaced(tmp_path):
    code = """
import bpy, envlights as el
rig = el.Rig([0.1, 0.2, 0.3], el.Lights([[0, 1, 0]] * 2, [[1, 1, 1]] * 2), error=0.0, floor=True)
for _ in range(2):
    el.export.add_to_blender(rig)
suns = [thing.name for thing in bpy.context.scene.objects if thing.name.startswith("envlights")]
world = bpy.context.scene.world
image = next(node.image for node in world.node_tree.nodes if node.type == "TEX_ENVIRONMENT")
print("found:", len(suns), world.name[:9], image.packed_file is not None, tuple(image.size))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert "found: 2 envlights True (" in done.stdout, done.stderr[-2000:]


def test_the_script_compiles_whatever_it_holds():
    for rig in (*RIGS.values(), POINTS[:0]):
        compile(blender(rig, texture="a'b\\\"\n.exr"), "script", "exec")


@pytest.mark.skipif(importlib.util.find_spec("bpy") is not None, reason="bpy is here")
def test_without_blender_there_is_one_sentence():
    with pytest.raises(el.EnvLightsError, match=r"Blender cannot be imported: .*; run this inside"):
        el.export.add_to_blender(POINTS)
