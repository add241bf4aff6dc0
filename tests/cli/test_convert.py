"""`envlights convert`: other layouts, sizes and turns of a map."""

import numpy as np
import pytest
from click.testing import CliRunner

import envlights as el
from envlights.cli import main
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


def test_an_unknown_layout_is_refused_in_a_sentence(hall, tmp_path):
    done = convert(hall, tmp_path / "x.exr", "--to", "torus")
    assert done.exit_code == 2
    assert "octahedral" in done.output
    assert not (tmp_path / "x.exr").exists()
