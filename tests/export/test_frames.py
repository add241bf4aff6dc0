"""Frames by name: one lamp in each, by the words of its program or by the file that it reads."""

import json
import re

import numpy as np
import pytest
from click.testing import CliRunner

import envlights as el
from envlights.cli import main
from envlights.frames import FRAMES

#: Amounts of a lamp straight ahead, to the left and up, seen from the centre of the map.
F, L, U = 0.36, 0.48, 0.8
LAMP = el.Lights([[L, U, F]], [[3, 2, 1]])
#: Right, up and forward of a camera, by the documentation of each program.
CAMERAS = {
    "opengl": ("+x", "+y", "-z"),
    "opencv": ("+x", "-y", "+z"),
    "colmap": ("+x", "-y", "+z"),
    "nerfstudio": ("+x", "+y", "-z"),
    "blender": ("+x", "+y", "-z"),
    "usd-z": ("+x", "+y", "-z"),
    "three": ("+x", "+y", "-z"),
    "unity": ("+x", "+y", "+z"),
    "unreal": ("+y", "+z", "+x"),
    "mitsuba": ("-x", "+y", "+z"),
    "ros": ("-y", "+z", "+x"),
}


def axis(name):
    return np.eye(3)["xyz".index(name[1])] * (1 if name[0] == "+" else -1)


def of_mitsuba():
    return -np.array(el.export.mitsuba(LAMP)["light_0"]["direction"])


def of_blender():
    return np.array(json.loads(re.search(r"\(\[(.*?)\]", el.export.blender(LAMP))[0][1:]))


def of_three():
    (light,) = el.export.three(LAMP)["object"]["children"]
    place = np.array(light["matrix"][12:15])
    return place / np.linalg.norm(place)


def of_usd():
    matrix = re.search(r"xformOp:transform = (.*)", el.export.usd(LAMP, up="z"))[1]
    rows = np.array(re.findall(r"-?[\d.]+(?:e-?\d+)?", matrix), float).reshape(4, 4)
    return rows[2, :3]  # a light shines along its own -z


#: The lamp in each frame: of a file of it, or by where a camera of the program looks.
TABLE = {
    "opengl": [-L, U, -F],
    "opencv": [-L, -U, F],
    "colmap": [-L, -U, F],
    "nerfstudio": of_blender(),
    "blender": of_blender(),
    "usd-z": of_usd(),
    "three": of_three(),
    "mitsuba": of_mitsuba(),
    "unity": el.export.unity(LAMP)["lights"][0]["to_light"],
    "unreal": el.export.unreal(LAMP)["lights"][0]["to_light"],
    "ros": [F, L, U],
}


@pytest.mark.parametrize("frame", TABLE)
def test_a_lamp_is_where_its_program_has_it(frame):
    np.testing.assert_allclose(LAMP.in_frame(frame)[0], TABLE[frame], atol=1e-6)


@pytest.mark.parametrize("frame", FRAMES)
def test_directions_come_back_from_a_frame(frame):
    rng = np.random.default_rng(3)
    direction = el.kernels.uniform_sphere(rng.random((40, 2)))
    lights = el.Lights(direction, rng.random((40, 3)))
    there = FRAMES[frame].from_target(lights.in_frame(frame))
    np.testing.assert_array_equal(there, lights.direction)


def test_unity_unreal_and_pbrt_are_left_handed():
    left = {name for name, frame in FRAMES.items() if frame.handedness < 0}
    assert left == {"unity", "unreal", "pbrt"}


@pytest.mark.parametrize("frame", CAMERAS)
@pytest.mark.parametrize("seed", range(4))
def test_a_camera_sees_what_it_looks_at_in_the_centre(frame, seed):
    """A level camera is built from its own right, up and forward in the program's world."""
    rng = np.random.default_rng(seed)
    to_world = FRAMES[frame].to_target
    forward = el.kernels.uniform_sphere(rng.random((1, 2)))[0]
    left = np.cross([0, 1, 0], forward)
    left /= np.linalg.norm(left)
    up = np.cross(forward, left)
    ours = np.stack([-left, up, forward])
    right_up_forward = np.stack([axis(name) for name in CAMERAS[frame]])
    pose = to_world(ours).T @ right_up_forward  # from the camera to the world
    stored = pose.T if frame in ("opencv", "colmap") else pose
    turn = FRAMES[frame].view(np.c_[stored, [1, 2, 3]])
    np.testing.assert_allclose(ours @ turn.T, [[-1, 0, 0], [0, 1, 0], [0, 0, 1]], atol=1e-12)
    np.testing.assert_allclose(FRAMES[frame].view(stored), turn)


@pytest.mark.parametrize(
    ("frame", "pose"),
    [
        # Rotation of COLMAP's images.txt, qw qx qy qz = (cos 45, 0, sin 45, 0): a turn about y.
        ("colmap", [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]),
        # transform_matrix of nerfstudio: -z of the camera along +y of the world, +y along +z.
        ("nerfstudio", [[1, 0, 0, 7], [0, 0, -1, 7], [0, 1, 0, 7], [0, 0, 0, 1]]),
    ],
)
def test_a_map_becomes_the_view_of_a_camera(frame, pose):
    # COLMAP: x_camera = R x_world, so the camera looks along -x of the world, our +x.
    env = el.Lights([[1, 0, 0]], [[3, 2, 1]], [0.1]).to_map(64)
    seen = el.detect(env.rotated(camera=pose, frame=frame))
    np.testing.assert_allclose(seen.direction, [[0, 0, 1]], atol=1e-3)


def test_a_rotation_may_be_written_in_another_frame():
    env = el.EnvMap(el.synthetic.hall(32).radiance)
    about_up = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]  # +x to +y, about +z
    expected = env.rotated(el.frames.rotation(yaw=np.pi / 2))
    assert env.rotated(about_up, frame="blender") == expected


@pytest.mark.parametrize("up", [[0, 3, 0], [0.1, 0.9, -0.3], [0, -1, 0], [1e-9, -1, 0], [1, 0, 0]])
def test_a_levelled_map_has_its_zenith_up(up):
    turn = el.frames.turn_upright(up)
    np.testing.assert_allclose(turn @ up, [0, np.linalg.norm(up), 0], atol=1e-9)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
    angle = np.arccos(np.clip((np.trace(turn) - 1) / 2, -1, 1))
    assert angle == pytest.approx(np.arccos(up[1] / np.linalg.norm(up)), abs=1e-6)


def test_yaw_pitch_and_roll_turn_the_picture():
    left, up, forward = np.eye(3)
    turn = el.frames.rotation
    np.testing.assert_allclose(turn(yaw=0.5) @ forward, np.cos(0.5) * forward + np.sin(0.5) * left)
    np.testing.assert_allclose(turn(pitch=0.5) @ forward, np.cos(0.5) * forward + np.sin(0.5) * up)
    np.testing.assert_allclose(turn(roll=0.5) @ up, np.cos(0.5) * up + np.sin(0.5) * left)
    together = turn(0.1, 0.2, 0.3)
    np.testing.assert_allclose(together, turn(yaw=0.1) @ turn(pitch=0.2) @ turn(roll=0.3))


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda env: env.rotated(), "give a matrix"),
        (lambda env: env.rotated(camera=np.eye(3)), "its frame"),
        (lambda env: env.rotated(np.eye(3), camera=np.eye(3), frame="ros"), "give a matrix"),
        (lambda env: env.rotated(camera=np.ones((3, 3)), frame="ros"), "camera must be a rotation"),
        (lambda env: env.rotated(camera=np.eye(2), frame="ros"), "camera must have the shape"),
        (lambda env: env.rotated(np.eye(3), frame="maya"), "frame must be 'envlights' or"),
        (lambda env: env.levelled([0, 0, 0]), "up must be three finite numbers"),
        (lambda env: env.levelled([0, np.inf, 0]), "up must be three finite numbers"),
        (lambda env: el.frames.rotation(np.nan), "yaw must be a finite number"),
        (lambda env: LAMP.in_frame("maya"), "frame must be 'envlights' or"),
    ],
)
def test_impossible_turns_are_refused(call, words):
    with pytest.raises(el.EnvLightsError, match=words):
        call(el.EnvMap(np.ones((8, 16, 3))))


@pytest.mark.parametrize("direction", [[0, 1], [], 3, "abc", [[0, 1, 0], [1]]])
def test_what_is_no_direction_has_none_in_another_frame(direction):
    for turn in (FRAMES["blender"].to_target, FRAMES["blender"].from_target):
        with pytest.raises(el.EnvLightsError, match="direction must"):
            turn(direction)


def run(*arguments):
    done = CliRunner().invoke(main, [*map(str, arguments)])
    assert done.exit_code == 0, done.output
    return done.stdout


def test_the_command_line_turns_the_map_and_speaks_in_a_frame(tmp_path):
    hall, out = tmp_path / "hall.exr", tmp_path / "out.exr"
    env = el.EnvMap(el.synthetic.hall(64).radiance)
    env.save(hall)
    run("convert", hall, out, "--rotate", "20,10,5")
    turn = el.frames.rotation(*np.deg2rad([20, 10, 5]))
    assert el.EnvMap.open(out).radiance == pytest.approx(env.rotated(turn).radiance)
    run("convert", hall, out, "--level", "0.1,-0.9,0.2", "--frame", "opencv")
    assert el.EnvMap.open(out).radiance == pytest.approx(env.levelled([-0.1, 0.9, 0.2]).radiance)
    pose = [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]
    words = ["--camera", "0,0,1,0,1,0,-1,0,0", "--frame", "colmap"]
    found = json.loads(run("detect", hall, *words, "--json"))
    expected = el.detect(env.rotated(camera=pose, frame="colmap"))
    assert found["in_frame"]["name"] == "colmap"
    np.testing.assert_allclose(
        found["in_frame"]["direction"], expected.in_frame("colmap"), atol=1e-6
    )
    printed = run("fit", hall, "-n", 2, "--fixed", "0,0,1", "--frame", "unreal")
    assert "directions (x, y, z) in the frame unreal" in printed
    assert "0.000000   0.000000   1.000000" in printed
