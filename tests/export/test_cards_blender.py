"""Cards in Blender, as Cycles renders them."""

import ast
import builtins

import numpy as np
import pytest

import envlights as el
from envlights.export import AXES
from tests.export import cards
from tests.export.rigs import DISCS, relative
from tests.export.test_blender import needs_bpy, run_blender
from tests.helpers import NORMALS

SKY = el.EnvMap(np.full((32, 64, 3), [0.2, 0.3, 0.4], np.float32))


@needs_bpy
@pytest.mark.parametrize("name", ["window", "oblique"])
def test_each_corner_has_its_colour_before_the_map(name, tmp_path):
    card = cards.ALL[name]
    el.export.save(card, tmp_path / "scene.py", SKY)
    np.save(tmp_path / "towards.npy", AXES["blender"].to_target(cards.directions(card)))
    run_blender("towards", tmp_path / "towards.npy", tmp_path / "scene.py")
    seen = [el.io.read_image(tmp_path / f"scene.{j}.exr").pixels[2, 2] for j in range(4)]
    wanted = cards.CORNERS.reshape(-1, 3) + SKY.radiance[0, 0]
    np.testing.assert_allclose(seen, wanted, rtol=0.005, atol=0.005)


@needs_bpy
def test_far_cards_light_as_at_infinity(tmp_path):
    np.save(tmp_path / "normals.npy", AXES["blender"].to_target(NORMALS))
    for name, card in cards.ALL.items():
        el.export.save(card, tmp_path / f"{name}.py", SKY)
    scripts = [tmp_path / f"{name}.py" for name in cards.ALL]
    run_blender("irradiance", tmp_path / "normals.npy", *scripts)
    for name, card in cards.ALL.items():
        seen, wanted = np.load(tmp_path / f"{name}.npy"), cards.irradiance(card, NORMALS, SKY)
        assert relative(seen, wanted) < 0.005, name
        np.testing.assert_allclose(seen.mean(axis=0), wanted.mean(axis=0), rtol=0.003)


def test_scripts_compile():
    for card in cards.ALL.values():
        compile(el.export.blender(card, SKY), "script", "exec")


@pytest.mark.parametrize("rig", [*cards.ALL.values(), DISCS])
def test_a_script_calls_each_of_its_functions_and_defines_what_it_calls(rig):
    script = ast.parse(el.export.blender(rig, SKY))
    nodes = list(ast.walk(script))
    defined = {node.name for node in nodes if isinstance(node, ast.FunctionDef)}
    calls = [node.func for node in nodes if isinstance(node, ast.Call)]
    called = {each.id for each in calls if isinstance(each, ast.Name)}
    assert defined <= called
    assert called <= defined | set(dir(builtins)) | {"Color", "Vector", "Matrix"}
