"""An output of ``-`` is the standard output, with nothing else in it."""

import io
import json
import subprocess
import sys

import pytest

import envlights as el


def run(*arguments, given=None, code=0):
    command = [sys.executable, "-m", "envlights", *map(str, arguments)]
    done = subprocess.run(command, input=given, capture_output=True, check=False, timeout=120)
    assert done.returncode == code, done.stderr.decode()
    return done


@pytest.fixture(scope="module")
def hall(tmp_path_factory):
    path = tmp_path_factory.mktemp("maps") / "hall.hdr"
    lamp = el.synthetic.Disc((1, 1, 0), 6.0, (90, 80, 70))
    el.EnvMap(el.synthetic.scene(64, background=[0.2] * 3, shapes=[lamp]).radiance).save(path)
    return path


def test_a_rig_goes_from_pipe_to_pipe(hall):
    done = run("fit", "-", "-o", "-", "--format", "json", given=hall.read_bytes())
    rig = json.loads(done.stdout)
    assert len(rig["lights"]) >= 1
    assert b"wrote" not in done.stderr
    assert b"error" in done.stderr


def test_a_map_goes_from_pipe_to_pipe(hall):
    done = run("convert", "-", "-", "--format", "hdr", "--width", 32, given=hall.read_bytes())
    assert el.EnvMap.open(io.BytesIO(done.stdout)).width == 32


def test_other_outputs_are_written_beside_the_standard_output(hall, tmp_path):
    done = run("fit", hall, "-o", tmp_path / "rig.json", "-o", "-", "--format", ".csv")
    assert done.stdout.startswith(b"#") or b"," in done.stdout.splitlines()[0]
    assert (tmp_path / "rig.json").exists()


def test_a_refusal_leaves_the_standard_output_empty(hall):
    assert not run("fit", hall, "-o", "-", code=2).stdout
    assert not run("fit", hall, "-o", "-", "--format", "nothing", code=2).stdout
    assert not run("fit", hall, "--format", "json", code=2).stdout


def test_several_files_do_not_fit_into_the_standard_output(hall):
    done = run("split", hall, "--shapes", "-o", "-", "--format", "usda", code=2)
    assert b"the standard output holds one" in done.stderr
    assert not done.stdout
