"""Blender: irradiance as Cycles renders it, in a process of its own."""

import ast
import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import envlights as el
from envlights.export import AXES, blender
from envlights.scene.mitsuba.renderer import mitsuba
from tests.export.balls import CAMERA, check_balls, environment
from tests.export.rigs import AXES as LAMPS
from tests.export.rigs import DISCS, POINTS, relative, relative_error, rigs
from tests.helpers import NORMALS

RIGS = {
    f"{name}_{size}": rig
    for size, lights in {"points": POINTS, "discs": DISCS}.items()
    for name, rig in rigs(lights).items()
}
# A light whose angle matters: a half would be seen.
RIGS["one_wide"] = el.Rig([0, 0, 0], el.Lights([[0.48, 0.8, 0.36]], [[3, 2, 1]], [0.7]), 0.0)
#: Python with `bpy`: this one, or that of another release of Blender.
BLENDER = os.environ.get("ENVLIGHTS_BLENDER_PYTHON", sys.executable)
needs_bpy = pytest.mark.skipif(
    importlib.util.find_spec("bpy") is None and sys.executable == BLENDER, reason="needs bpy"
)


def run_blender(*arguments):
    # A process of its own: bpy may be in a process only once, and never leaves it.
    command = [BLENDER, Path(__file__).with_name("in_blender.py"), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]


def texture_of_file(path):
    """Value of `MAP` in a script; None without a map."""
    for node in compile(path.read_bytes(), "script", "exec", ast.PyCF_ONLY_AST).body:
        if isinstance(node, ast.Assign) and node.targets[0].id == "MAP":
            return ast.literal_eval(node.value)
    return None


def irradiance_of_file(path):
    """Irradiance at `NORMALS` that Cycles renders."""
    np.save(path.parent / "normals.npy", AXES["blender"].to_target(NORMALS))
    run_blender("irradiance", path.parent / "normals.npy", path)
    return np.load(path.with_suffix(".npy"))


@pytest.fixture(scope="module")
def irradiances(tmp_path_factory):
    """Irradiance that Cycles renders from each script."""
    folder = tmp_path_factory.mktemp("blender")
    np.save(folder / "normals.npy", AXES["blender"].to_target(NORMALS))
    scripts = [folder / f"{name}.py" for name in RIGS]
    for rig, script in zip(RIGS.values(), scripts, strict=True):
        rig.save(script)
    run_blender("irradiance", folder / "normals.npy", *scripts)
    return {script.stem: np.load(script.with_suffix(".npy")) for script in scripts}


@needs_bpy
@pytest.mark.parametrize("name", RIGS)
def test_the_irradiance_that_cycles_renders_is_that_of_the_rig(name, irradiances):
    assert relative_error(irradiances[name], RIGS[name]) < 0.005


#: Linear Rec.709 to linear Rec.2020 (Recommendation ITU-R BT.2087).
TO_REC2020 = [[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0114], [0.0164, 0.0880, 0.8956]]


@needs_bpy
@pytest.mark.parametrize("name", ["constant", "harmonics"])
def test_colours_are_converted_to_the_working_space_of_the_file(name, tmp_path):
    red = el.Lights([[0.48, 0.8, 0.36]], [[3, 0.1, 0.1]], [0.1])
    rig = rigs(red)[name]
    rig.save(tmp_path / "rig.py")
    np.save(tmp_path / "normals.npy", AXES["blender"].to_target(NORMALS))
    run_blender("rec2020", tmp_path / "normals.npy", tmp_path / "rig.py")
    found = np.load(tmp_path / "rig.npy")
    if not len(found):
        pytest.skip("Blender before release 5 has one working space")
    assert relative(found, rig.probe(NORMALS) @ np.transpose(TO_REC2020)) < 0.005


@needs_bpy
def test_map_and_lights_meet_on_two_balls(tmp_path):
    np.save(tmp_path / "camera.npy", AXES["blender"].to_target(CAMERA))
    LAMPS.save(tmp_path / "balls.py", environment=environment())
    run_blender("balls", tmp_path / "camera.npy", tmp_path / "balls.py")
    check_balls(el.io.read_image(tmp_path / "balls.exr").pixels)


@needs_bpy
def test_image_errors_of_rigs_are_those_of_mitsuba(tmp_path):
    """A ball and a box on a floor under a map, and under two rigs for it."""
    pytest.importorskip("mitsuba")
    stills = importlib.import_module("envlights.scene.still_life")
    env = el.EnvMap(el.synthetic.hall(128).radiance)
    rigs = {count: el.fit(env, lights=count) for count in (1, 4)}
    nothing = POINTS[:0]
    nothing.save(tmp_path / "map.py", environment=env)
    for count, rig in rigs.items():
        rig.save(tmp_path / f"rig_{count}.py")
    (ball, box), camera = stills.still_scene(1.0).solids, stills.still_camera(1.0)
    with mitsuba() as mi:
        place = mi.ScalarTransform4f()
        turned = place.translate(box.centre).rotate([0, 1, 0], np.rad2deg(box.turn))
        frames = {
            "floor": place.scale(40).rotate([1, 0, 0], -90),
            "ball": place.translate(ball.centre).scale(ball.radius),
            "box": turned.scale(0.4),
            "eye": place.look_at(camera.eye, camera.target, [0, 1, 0]),
        }
        frames = {name: np.array(each.matrix) for name, each in frames.items()}
    there = np.eye(4)
    there[:3, :3] = AXES["blender"].matrix
    # Mitsuba's eye looks along its +z with +x on the left, Blender's along -z with +x on the right.
    frames["eye"] = frames["eye"] @ np.diag([-1, 1, -1, 1])
    np.savez(tmp_path / "frames.npz", **{name: there @ each for name, each in frames.items()})
    names = ["map", "rig_1", "rig_4"]
    run_blender("still_life", tmp_path / "frames.npz", *(tmp_path / f"{name}.py" for name in names))
    pairs = [
        [el.io.read_image(tmp_path / f"{name}.{k}.exr").pixels for k in (1, 2)] for name in names
    ]
    map_here, *rigs_here = [stills.Still(*np.asarray(pair, float)) for pair in pairs]
    map_there = stills.still_life(env, 1.0, 64, 0)
    assert map_here.error(map_there) < 0.01
    # Noise is 1 to 2 %, as large as the error of four lights.
    for (count, rig), here, rel in zip(rigs.items(), rigs_here, (0.02, 0.2), strict=True):
        there = stills.still_life(rig, 1.0, 64, count)
        assert here.error(map_here) == pytest.approx(there.error(map_there), rel=rel)
        assert here.error(there) < 0.01


@needs_bpy
def test_the_parts_of_a_split_map_light_as_the_map(tmp_path):
    """The script in another folder than the remainder; without it, half of the light is missing."""
    env = el.Rig([0.2, 0.3, 0.5], DISCS[:2], error=0.0).to_map(128)
    for folder in ("maps", "scenes"):
        (tmp_path / folder).mkdir()
    el.split(env, 1).save(tmp_path / "maps/rest.exr", tmp_path / "scenes/sun.py")
    np.save(tmp_path / "normals.npy", AXES["blender"].to_target(NORMALS))
    run_blender("irradiance", tmp_path / "normals.npy", tmp_path / "scenes/sun.py")
    seen, wanted = np.load(tmp_path / "scenes/sun.npy"), env.probe(NORMALS)
    assert relative(seen, wanted) < 0.005
    np.testing.assert_allclose(seen.mean(axis=0), wanted.mean(axis=0), rtol=1e-3)


@pytest.mark.skipif(importlib.util.find_spec("bpy") is None, reason="needs bpy in this Python")
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
        compile(blender(rig, texture="a'b\"\n.exr"), "script", "exec")


@pytest.mark.skipif(importlib.util.find_spec("bpy") is not None, reason="bpy is here")
def test_without_blender_there_is_one_sentence():
    with pytest.raises(el.EnvLightsError, match=r"Blender cannot be imported: .*; run this inside"):
        el.export.add_to_blender(POINTS)


def test_by_the_formula_of_cycles_a_light_is_where_the_map_shows_it():
    """`direction_to_equirectangular` of Cycles; the script gives directions towards the lights."""
    script = el.export.blender(POINTS)
    listed = script[script.index("LIGHTS = ") + len("LIGHTS = ") : script.index("# Radiance of")]
    x, y, z = np.array([towards for towards, _, _ in ast.literal_eval(listed)]).T
    u = (0.5 - np.arctan2(y, x) / (2 * np.pi)) % 1
    v = 0.5 - np.arctan2(z, np.hypot(x, y)) / np.pi
    expected = el.kernels.direction_to_uv(POINTS.direction)
    np.testing.assert_allclose(np.stack([u, v], axis=1), expected, atol=1e-12)


@pytest.mark.parametrize("mark", ["LIGHTS", "AMBIENT", "CARDS", "UNITS", "MAP"])
def test_a_note_that_names_a_mark_of_the_template_stays_a_comment(mark):
    sun = [[0, 1, 0]], [[1, 1, 1]]
    script = blender(el.Lights(*sun, notes=[f"x @{mark}@import os;os.system('touch file')#"]))
    assert f"@{mark}@import" in script
    assert ast.dump(ast.parse(script)) == ast.dump(ast.parse(blender(el.Lights(*sun))))
