"""`envlights follow` on the frames of a sequence."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import envlights as el
from envlights.cli import main
from tests.sequence import shows


@pytest.fixture
def frames(tmp_path):
    folder = tmp_path / "frames"
    folder.mkdir()
    # Unpadded numbers: alphabetical order would shuffle the frames.
    for k, env in enumerate(shows.crossing(12, height=32)):
        env.save(folder / f"lamps.{k}.exr")
    return folder


def run(*arguments):
    return CliRunner().invoke(main, ["follow", *map(str, arguments)])


def test_the_files_hold_the_sequence_of_follow(frames, tmp_path):
    outputs = [tmp_path / f"rigs{suffix}" for suffix in (".jsonl", ".usda")]
    options = ["-n", 2, "--steadiness", "0.1s", "--fps", 20]
    done = run(f"{frames}/*.exr", *options, "-o", outputs[0], "-o", outputs[1])
    assert done.exit_code == 0, done.output
    assert "12 frames, steadiness 2 frames at 20 frames in a second" in done.output
    rigs = el.sequence.RigSequence.load(outputs[0])
    assert rigs == el.follow(str(frames), 2, steadiness=2, fps=20).sequence()
    assert np.nanmax(rigs.motion_deg) < 2
    assert outputs[1].read_text().startswith("#usda 1.0")


def test_json_is_that_of_the_sequence(frames):
    done = run(frames, "-n", 2, "--json")
    assert json.loads(done.stdout) == el.follow(str(frames), 2).sequence().to_dict()


def test_an_error_may_have_any_number_of_lights(frames):
    done = run(frames, "--error", 0.02, "--json")
    errors = [rig["fit_error"] for rig in json.loads(done.stdout)["rigs"]]
    assert max(errors) <= 0.02


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["-o", "rigs.xml"], "the suffix must be one of .jsonl"),
        (["--steadiness", "soon"], "a number of frames, or seconds"),
        (["--steadiness", "1 s"], "needs fps"),
    ],
)
def test_refusals_are_one_sentence(arguments, sentence, frames, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = run(frames, *arguments)
    assert done.exit_code == 2
    assert sentence in done.stderr
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "rigs.xml").exists()


def test_a_pattern_without_files_is_refused():
    done = run("nothing/*.exr")
    assert done.exit_code == 1
    assert "no map matches nothing" in done.stderr
