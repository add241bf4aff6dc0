"""`envlights convert`: other layouts, sizes and turns of a map."""

import numpy as np
import pytest
from click.testing import CliRunner

import envlights as el
from envlights.cli import main
from envlights.environment.files.images import read_image
from tests.helpers import NORMALS

SCENE = el.EnvMap(el.synthetic.hall(128).radiance)


@pytest.fixture
def hall(tmp_path):
    path = tmp_path / "hall.exr"
    SCENE.save(path)
    return path


def convert(*arguments):
    return CliRunner().invoke(main, ["convert", *map(str, arguments)])


def test_six_faces_are_written_and_open_again(hall, tmp_path):
    done = convert(hall, tmp_path / "sky_{face}.exr", "--to", "cube", "--width", 32)
    assert done.exit_code == 0, done.output
    assert sorted(path.name for path in tmp_path.glob("sky_*")) == [
        f"sky_{face}.exr" for face in ("nx", "ny", "nz", "px", "py", "pz")
    ]
    env = el.EnvMap.open(tmp_path / "sky_{face}.exr")
    assert env.source.faces == "opengl"
    probe = SCENE.probe(NORMALS)
    # Pixels of 2.8 degrees spread a lamp over the horizon of some normals.
    assert np.linalg.norm(env.probe(NORMALS) - probe) < 0.01 * np.linalg.norm(probe)


def test_a_map_is_turned_and_resized(hall, tmp_path):
    done = convert(hall, tmp_path / "turned.exr", "--rotate", 90, "--width", 64)
    assert done.exit_code == 0, done.output
    turn = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])
    turned = el.EnvMap.open(tmp_path / "turned.exr")
    assert turned.width == 64
    probe, seen = SCENE.probe(NORMALS), turned.probe(NORMALS @ turn.T)
    # Pixels of 5.6 degrees spread a lamp over the horizon of some normals.
    assert np.linalg.norm(seen - probe) < 0.02 * np.linalg.norm(probe)


def test_the_direction_of_a_photograph_is_one_of_the_frame(hall, tmp_path):
    view = ("--to", "planar", "--view", 60, "--width", 32)
    typed = ",".join(map(str, el.frames.frame_named("blender").to_target([0, 0.6, 0.8])))
    names = {"ours.exr": ["0,0.6,0.8"], "theirs.exr": [typed, "--frame", "blender"]}
    for name, forward in names.items():
        done = convert(hall, tmp_path / name, *view, "--to-forward", *forward)
        assert done.exit_code == 0, done.output
    pictures = [read_image(tmp_path / name, any_projection=True).pixels for name in names]
    np.testing.assert_allclose(*pictures, rtol=1e-5)


def test_an_unknown_layout_is_refused_in_a_sentence(hall, tmp_path):
    done = convert(hall, tmp_path / "x.exr", "--to", "torus")
    assert done.exit_code == 2
    assert "octahedral" in done.output
    assert not (tmp_path / "x.exr").exists()


@pytest.fixture
def cross(tmp_path):
    """A horizontal cross of the hall."""
    path = tmp_path / "cross.exr"
    SCENE.to("cube", width=64).save(path, arrangement="horizontal-cross")
    return path


def test_a_cube_comes_back_as_the_cube_it_was(cross, tmp_path):
    done = convert(cross, tmp_path / "limited.exr", "--to", "source", "--limit", 2)
    assert done.exit_code == 0, done.output
    env = el.EnvMap.open(
        tmp_path / "limited.exr", layout=el.io.Layout.cube(faces="horizontal-cross")
    )
    assert (env.source.faces, env.source.size) == ("horizontal-cross", (192, 256))
    assert "limited to 2" in " ".join(el.EnvMap.open(cross).limited(2).notes)
    # Conversion spreads no pixel above its neighbours.
    assert env.radiance.max() < 2.2


def test_the_rest_of_a_split_is_written_in_the_layout_of_its_map(cross, tmp_path):
    faces = str(tmp_path / "rest_{face}.exr")
    outputs = ["-o", tmp_path / "rest.exr", "-o", faces, "-o", tmp_path / "lights.json"]
    command = ["split", cross, "-n", 1, "--to", "source", *outputs]
    done = CliRunner().invoke(main, [*map(str, command)])
    assert done.exit_code == 0, done.output
    _, rest = el.split(el.EnvMap.open(cross), 1)
    np.testing.assert_array_equal(
        el.EnvMap.open(tmp_path / "rest.exr").radiance,
        el.EnvMap(rest.to("source").array).radiance,
    )
    assert len(list(tmp_path.glob("rest_*.exr"))) == 6
    assert el.EnvMap.open(faces).source.faces == "opengl"
    assert "rest_px.exr" in done.stderr
    assert len(el.Lights.load(tmp_path / "lights.json")) == 1


def test_radiance_above_a_limit_is_split_off(hall, tmp_path):
    rest, lights = tmp_path / "rest.exr", tmp_path / "lights.csv"
    split = ["split", str(hall), "--limit", "3", "-o", str(rest), "-o", str(lights)]
    done = CliRunner().invoke(main, split)
    assert done.exit_code == 0, done.output
    parts = el.limit(SCENE, 3)
    assert el.EnvMap.open(rest).radiance.max() == 3
    np.testing.assert_allclose(el.Lights.load(lights).irradiance, parts.lights.irradiance)
    for wrong in (["-n", "1"], ["--fraction", "0.5"], ["-o", str(tmp_path / "parts.png")]):
        refused = CliRunner().invoke(main, [*split, *wrong])
        assert refused.exit_code == 2
        assert "--limit" in refused.output
