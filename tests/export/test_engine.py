"""Rigs in the axes of engines."""

import json
from itertools import permutations, product

import numpy as np
import pytest

import envlights as el
from envlights.export import AXES
from envlights.export.formats.engine import matrix_of
from tests.export.rigs import AXES as ON_AXES
from tests.export.rigs import DISCS, POINTS, environment, relative, rigs
from tests.helpers import NORMALS

RIGS = rigs(DISCS)


def rig_of(scene):
    """The rig in an engine's JSON, in the engine's own axes; right-handed formulas need no more."""
    lights = scene["lights"]
    ambient = scene.get("harmonics", scene.get("ambient", [0, 0, 0]))
    for light in lights:
        np.testing.assert_allclose(
            np.array(light["color"]) * light["intensity"], light["irradiance"], rtol=1e-15
        )
        np.testing.assert_array_equal(np.negative(light["forward"]), light["to_light"])
    return el.Rig(
        ambient,
        el.Lights(
            [light["to_light"] for light in lights],
            [light["irradiance"] for light in lights],
            [np.deg2rad(light["angular_diameter"]) / 2 for light in lights],
        ),
        0.0,
    )


def texture_of_file(path):
    """Name of the map."""
    return json.loads(path.read_text(encoding="utf-8"))["map"]


def irradiance_of_file(path):
    """Irradiance of the lights as points, and of harmonics or a map."""
    scene = json.loads(path.read_text())
    rig = rig_of(scene)
    points = el.Lights(rig.lights.direction, rig.lights.irradiance)
    there = NORMALS @ np.transpose(scene["matrix"])
    if "map" not in scene or "harmonics" in scene:
        return el.Rig(rig.ambient, points, 0.0).probe(there)
    sky = el.EnvMap.open(path.parent / scene["map"])
    return el.Rig([0, 0, 0], points, 0.0).probe(there) + sky.probe(NORMALS)


@pytest.mark.parametrize("make", [el.export.unity, el.export.unreal])
@pytest.mark.parametrize("name", ["none", "constant", "harmonics"])
def test_in_the_axes_of_the_engine_normals_receive_the_same(make, name):
    there = NORMALS @ np.transpose(AXES[make.__name__].matrix)
    assert relative(rig_of(make(RIGS[name])).probe(there), RIGS[name].probe(NORMALS)) < 1e-12


@pytest.mark.parametrize("target", ["unity", "unreal"])
@pytest.mark.parametrize("name", ["floor", "harmonics"])
def test_a_file_has_its_map_beside_it(target, name, tmp_path):
    rig = RIGS[name]
    el.Rig(rig.ambient, POINTS, 0.0, floor=rig.floor).save(tmp_path / f"scene.{target}.json")
    scene = json.loads((tmp_path / f"scene.{target}.json").read_text())
    env = el.EnvMap.open(tmp_path / scene["map"])
    ambient = el.Rig(rig.ambient, POINTS[:0], 0.0, floor=rig.floor)
    assert relative(env.probe(NORMALS), ambient.probe(NORMALS)) < 1e-4


def test_a_map_of_ones_own(tmp_path):
    el.export.save_engine(
        RIGS["harmonics"], tmp_path / "a.json", environment(), right="+x", up="+z", forward="+y"
    )
    scene = json.loads((tmp_path / "a.json").read_text())
    np.testing.assert_array_equal(
        el.EnvMap.open(tmp_path / scene["map"]).radiance, environment().radiance
    )
    assert "harmonics" not in scene


def unit_vector(name):
    return (1 if name[0] == "+" else -1) * np.eye(3)["xyz".index(name[1])]


def test_any_48_frames_keep_the_probe_and_say_their_hand():
    rig, hands = RIGS["harmonics"], []
    for letters in permutations("xyz"):
        for signs in product("+-", repeat=3):
            names = [sign + letter for sign, letter in zip(signs, letters, strict=True)]
            axes = dict(zip(("right", "up", "forward"), names, strict=True))
            scene = el.export.engine(rig, **axes)
            matrix = np.array(scene["matrix"])
            assert relative(rig_of(scene).probe(NORMALS @ matrix.T), rig.probe(NORMALS)) < 1e-12
            # By the rule of the hand: right x up = -forward in right-handed frames.
            right, up, forward = map(unit_vector, names)
            cross = np.cross(right, up) @ forward
            assert scene["handedness"] == ("right" if cross < 0 else "left")
            hands.append(scene["handedness"])
    assert hands.count("left") == hands.count("right") == 24


def test_presets_are_their_rows_of_the_table():
    assert matrix_of("+x", "+y", "+z") == AXES["unity"].matrix
    assert matrix_of("+y", "+z", "+x") == AXES["unreal"].matrix
    assert AXES["unity"].handedness == AXES["unreal"].handedness == -1


def test_unity_mirrors_x_as_importers_of_gltf_do():
    """Its importers' own words: +Y up, +Z forward, -X right becomes +X right; scale (-1, 1, 1)."""
    np.testing.assert_array_equal(AXES["unity"].matrix, np.diag([-1, 1, 1]))


#: One metre forward, two to the left and three up: as the centre of our map looks, +z, and our +x.
FORWARD_LEFT_UP = (1.0, 2.0, 3.0)
OURS = [2.0, 3.0, 1.0]


def test_unitys_axes_by_its_own_conversion_to_forward_left_up():
    """ROSGeometry.md of Unity's ROS-TCP-Connector: X right, Y up, Z forward is "RUF", not "FLU"."""
    right, up, forward = AXES["unity"].to_target(OURS)
    assert (forward, -right, up) == FORWARD_LEFT_UP


def test_unreals_axes_by_the_worked_conversion_of_a_coordinate():
    """(x, y, z) in an Unreal Engine scene is (x, -y, z) where x is forward, y left and z up.

    "Coordinate Systems for Unreal Engine Simulation", Robotics System Toolbox of MathWorks.
    """
    x, y, z = AXES["unreal"].to_target(OURS)
    assert (x, -y, z) == FORWARD_LEFT_UP


def turned_in_unity(euler):
    """Unity's forward after turns about z, x and y, in the left-handed sense of its manual.

    Counter-clockwise "when looking from the origin along the axis of rotation" (Quaternion.Euler):
    a positive turn about y takes forward (+z) to the right (+x), one about x takes it down.
    """
    pitch, yaw, _ = np.deg2rad(euler)
    forward = np.array([0, -np.sin(pitch), np.cos(pitch)])
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([c * forward[0] + s * forward[2], forward[1], c * forward[2] - s * forward[0]])


def test_unitys_angles_turn_a_light_to_its_direction():
    for light in el.export.unity(POINTS)["lights"]:
        np.testing.assert_allclose(
            turned_in_unity(light["euler_angles"]), light["forward"], atol=1e-12
        )


def test_unitys_first_light_of_a_new_scene():
    """It has the angles 50, -30, 0: it comes from above, from behind and from the right."""
    forward = turned_in_unity([50, -30, 0])
    towards = -forward
    assert towards[0] > 0
    assert towards[1] == pytest.approx(np.sin(np.deg2rad(50)))
    assert towards[2] < 0
    lamp = el.Lights([AXES["unity"].from_target(towards)], [[1, 1, 1]])
    (light,) = el.export.unity(lamp)["lights"]
    np.testing.assert_allclose(light["euler_angles"], [50, -30, 0], atol=1e-12)


def test_unreals_rotator_turns_a_light_to_its_direction():
    """Its forward vector is cos p cos y, cos p sin y, sin p.

    "Looking up and down (0=Straight Ahead, +Up, -Down)", "turning around (0=Forward, +Right,
    -Left)": Epic's words for the inputs of its node MakeRotator.
    """
    for light in el.export.unreal(POINTS)["lights"]:
        pitch, yaw = (np.deg2rad(light["rotator"][name]) for name in ("pitch", "yaw"))
        forward = [np.cos(pitch) * np.cos(yaw), np.cos(pitch) * np.sin(yaw), np.sin(pitch)]
        np.testing.assert_allclose(forward, light["forward"], atol=1e-12)
    # In our frame the centre of the map is forward, and its left quarter on the left.
    lights = el.export.unreal(ON_AXES)["lights"]
    shone = {tuple(light["irradiance"]): light["to_light"] for light in lights}
    assert shone[(0, 0, 3)] == [1, 0, 0]
    assert shone[(3, 0, 0)] == [0, -1, 0]
    assert shone[(0, 3, 0)] == [0, 0, 1]


def test_unitys_panorama_is_turned_to_the_lights():
    """By the formulas of its shader Skybox/Panoramic."""
    angle = np.deg2rad(el.export.unity(POINTS)["skybox_rotation"])
    c, s = np.cos(angle), np.sin(angle)
    uv = np.random.default_rng(0).uniform(0.05, 0.95, (50, 2))
    for (u, v), ours in zip(uv, el.kernels.uv_to_direction(uv), strict=True):
        # A direction of the mesh is read at u = 0.5 - atan2(z, x) / 2 pi ...
        phi = 2 * np.pi * (0.5 - u)
        sine = np.sin(np.pi * v)
        x, y, z = np.cos(phi) * sine, np.cos(np.pi * v), np.sin(phi) * sine
        # ... and drawn where the rotation takes it.
        drawn = [c * x - s * z, y, s * x + c * z]
        np.testing.assert_allclose(drawn, AXES["unity"].to_target(ours), atol=1e-12)


def test_lux_and_the_pi_of_a_white_surface():
    (light,) = el.export.unity(el.Lights([[0, 1, 0]], [[6, 3, 0]]))["lights"]
    assert (light["lux"], light["color"]) == (6, [1, 0.5, 0])
    assert light["intensity_without_pi"] == pytest.approx(6 / np.pi)


@pytest.mark.parametrize(
    ("axes", "sentence"),
    [
        (("+x", "+y", "+x"), "three different axes; got"),
        (("x", "+y", "+z"), "right must be an axis, such as '\\+x' or '-z'; got 'x'"),
        ((1, "+y", "+z"), "right must be an axis"),
    ],
)
def test_axes_that_are_none_are_refused(axes, sentence):
    with pytest.raises(el.EnvLightsError, match=sentence):
        el.export.engine(POINTS, right=axes[0], up=axes[1], forward=axes[2])
