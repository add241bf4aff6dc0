"""glTF, checked by its specification, the Khronos validator and the loader of three.js."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import envlights as el
from envlights.export import AXES, gltf
from tests.export import node
from tests.export.rigs import DISCS, POINTS, relative_error, rigs
from tests.helpers import NORMALS

pytestmark = pytest.mark.filterwarnings("ignore:glTF 2.0 shows:UserWarning")

RIGS = rigs(POINTS)


def read(asset):
    """Directions towards the lights and irradiances, as KHR_lights_punctual defines them."""
    found = asset["extensions"]["KHR_lights_punctual"]["lights"]
    nodes = [asset["nodes"][j] for j in asset["scenes"][asset["scene"]]["nodes"]]
    which = [each["extensions"]["KHR_lights_punctual"]["light"] for each in nodes]
    assert {found[j]["type"] for j in which} == {"directional"}
    shines = Rotation.from_quat([each["rotation"] for each in nodes]).apply([0, 0, -1])
    return -shines, np.array([found[j]["intensity"] * np.array(found[j]["color"]) for j in which])


def irradiance(direction, at_normal):
    normals = AXES["gltf"].to_target(NORMALS)
    return np.maximum(normals @ np.transpose(direction), 0) @ at_normal


def irradiance_of_file(path):
    """Irradiance of the lights, and of the ambient term that is to be set by hand."""
    asset = json.loads(path.read_text())
    ambient = asset["scenes"][0].get("extras", {"ambient": [0, 0, 0]})["ambient"]
    return irradiance(*read(asset)) + np.pi * np.array(ambient)


def test_the_irradiance_by_the_specification_is_that_of_the_rig():
    rig = RIGS["none"]
    assert relative_error(irradiance(*read(gltf(rig))), rig) < 1e-12


@pytest.mark.parametrize("direction", [*np.eye(3), *-np.eye(3), [1e-9, 0, -1], [1e-9, 0, 1]])
def test_each_axis_and_what_is_close_to_it(direction):
    direction = np.array(direction) / np.linalg.norm(direction)
    asset = gltf(el.Lights([direction], [[0, 0, 0]]))
    np.testing.assert_allclose(read(asset)[0], [direction], atol=1e-8)
    assert np.linalg.norm(asset["nodes"][0]["rotation"]) == pytest.approx(1, abs=1e-12)


def test_extras_hold_what_gltf_cannot():
    rig = el.Rig([0.1, 0.2, 0.3], DISCS, error=0.0, floor=True)
    asset = gltf(rig)
    found = asset["extensions"]["KHR_lights_punctual"]["lights"]
    radii = [light["extras"]["angular_radius"] for light in found]
    assert radii == DISCS.angular_radius.tolist()
    assert asset["scenes"][0]["extras"]["ambient"] == [0.1, 0.2, 0.3]
    assert asset["scenes"][0]["extras"]["floor"] is True


@node.needs("gltf-validator")
@pytest.mark.parametrize("lights", [POINTS, DISCS[:1], POINTS[:0]], ids=["points", "disc", "none"])
@pytest.mark.parametrize("name", RIGS)
def test_the_khronos_validator_has_nothing_to_say(name, lights, tmp_path):
    rigs(lights)[name].save(tmp_path / "rig.gltf")
    found = node.report("validate_gltf.mjs", tmp_path / "rig.gltf")
    assert found["info"]["version"] == "2.0"
    assert found["issues"]["messages"] == []


@node.needs("gltf-validator")
def test_the_validator_has_nothing_to_say_of_a_map(tmp_path):
    DISCS.save(tmp_path / "rig.gltf", environment=np.ones((4, 8, 3), np.float32))
    found = node.report("validate_gltf.mjs", tmp_path / "rig.gltf")
    assert found["issues"]["messages"] == []


@node.needs("gltf-validator")
def test_the_validator_does_see_errors(tmp_path):
    asset = gltf(POINTS)
    asset["nodes"][0]["rotation"] = [1, 1, 0, 0]
    (tmp_path / "rig.gltf").write_text(json.dumps(asset))
    assert node.report("validate_gltf.mjs", tmp_path / "rig.gltf")["issues"]["numErrors"] > 0


@node.needs("three")
def test_the_irradiance_that_three_js_reads_is_that_of_the_rig(tmp_path):
    POINTS.save(tmp_path / "rig.gltf")
    found = node.report("three_lights.mjs", tmp_path / "rig.gltf")
    direction, at_normal = zip(*found["directional"], strict=True)
    assert relative_error(irradiance(direction, at_normal), RIGS["none"]) < 1e-6
