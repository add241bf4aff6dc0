"""Paths of ``-`` are the standard input and output, with nothing else in them."""

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


def test_a_rig_comes_from_a_pipe(hall, tmp_path):
    rig = run("fit", hall, "-n", 1, "-o", "-", "--format", "json").stdout
    (tmp_path / "rig.json").write_bytes(rig)
    script = run("export", "-", "-", "--format", "blender", given=rig)
    assert script.stdout.decode() == el.export.blender(el.Rig.load(tmp_path / "rig.json"))
    known = run("compare", hall, tmp_path / "rig.json", "--json").stdout
    assert run("compare", hall, "-", "--json", given=rig).stdout == known
    table = run("export", tmp_path / "rig.json", "-", "--format", "csv").stdout
    again = run(
        "fit", hall, "-n", 1, "--start", "-", "-q", "-o", "-", "--format", "csv", given=table
    )
    assert again.stdout.splitlines()[0] == table.splitlines()[0]
    assert not again.stderr


def test_a_page_and_a_curve_go_to_the_standard_output(hall):
    assert (
        run("view", hall, "-o", "-", "--format", "html")
        .stdout.lower()
        .startswith(b"<!doctype html>")
    )
    curve = run("error-curve", hall, "-n", "0,1", "-o", "-", "--format", "csv").stdout.decode()
    assert curve.splitlines()[0].startswith("lights,used,objective")


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("fit {} -o -", b"needs a format, such as --format json"),
        ("fit {} -o - --format nothing", b"cannot write the standard output: the suffix must be"),
        ("fit {} --format json", b"leave it out, or write to -"),
        ("fit {} -o - --format json --json", b"both print; leave out one"),
        ("compare - - --json", b"only one input can be the standard input"),
        ("export - usd", b"has no name for usd; give a file"),
    ],
)
def test_refusals_print_one_sentence(hall, words, sentence):
    done = run(*words.format(hall).split(), given=b"{}", code=2)
    assert sentence in done.stderr
    assert (done.stdout, len(done.stderr.splitlines())) == (b"", 1)


def test_several_files_do_not_fit_into_the_standard_output(hall):
    done = run("split", hall, "--shapes", "-o", "-", "--format", "usda", code=2)
    assert b"the standard output holds one" in done.stderr
    assert not done.stdout
