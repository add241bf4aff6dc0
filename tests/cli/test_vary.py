"""`envlights vary`: numbered files, and a table of what was changed."""

import json
import re

import pytest
from click.testing import CliRunner

import envlights as el
from envlights.cli import main
from tests.export.rigs import POINTS, rigs
from tests.helpers import NORMALS


def run(*arguments):
    return CliRunner().invoke(main, ["vary", *map(str, arguments)])


@pytest.fixture
def folder(tmp_path):
    for name in ("constant", "harmonics"):
        rigs(POINTS)[name].save(tmp_path / f"{name}.json")
    return tmp_path


def test_each_file_is_the_rig_of_python(folder):
    inputs = folder / "constant.json", folder / "harmonics.json"
    options = "-n", 3, "--seed", 5, "--mix", "0.1,0.4", "--drop", 0.5, "--exposure", 1
    result = run(*inputs, *options, "-o", folder / "rig.json")
    assert result.exit_code == 0, result.output
    both = list(map(el.Rig.load, inputs))
    wanted = list(el.vary(both, 3, seed=5, mix=(0.1, 0.4), drop=0.5, exposure=1))
    lines = (folder / "rig.jsonl").read_text().splitlines()
    for each, line in zip(wanted, lines, strict=True):
        file = f"rig.000{each.number}.json"
        assert el.Rig.load(folder / file) == each.rig
        assert json.loads(line) == {"file": file, **each.changes()}


def test_files_for_programs_have_their_whole_suffix_and_the_up_axis(folder):
    assert run(folder / "constant.json", "-n", 1, "-o", folder / "a.three.json").exit_code == 0
    assert json.loads((folder / "a.0000.three.json").read_text())["object"]["type"] == "Scene"
    result = run(folder / "constant.json", "-n", 1, "-o", folder / "a.usda", "--up", "z")
    assert result.exit_code == 0, result.output
    assert 'upAxis = "Z"' in (folder / "a.0000.usda").read_text()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--exposure", "2,1"), "exposure must have its lowest value first"),
        (("--azimuth", "a"), "'a' is neither a number nor LOW,HIGH"),
        (("--mix", "1"), "needs two rigs or more"),
        (("--up", "z"), "--up changes nothing for envlights itself"),
    ],
)
def test_wrong_options_are_refused_before_a_file_is_written(options, words, folder):
    result = run(folder / "constant.json", "-o", folder / "rig.json", *options)
    assert result.exit_code == 2
    assert words in result.stderr
    assert len(list(folder.iterdir())) == 2


def test_a_rig_is_not_overwritten(folder):
    (folder / "constant.json").rename(folder / "rig.0001.json")
    result = run(folder / "rig.0001.json", "-o", folder / "rig.json")
    assert result.exit_code == 2
    assert "rig.0001.json: it is rig 1; give another name" in result.stderr


@pytest.mark.parametrize("suffix", ["mujoco.xml", "sapien.py", "genesis.py"])
def test_exposed_files_have_one_scale(suffix, folder):
    """Exposed each for itself, they would all be equally bright."""
    options = "-n", 4, "--exposure", "-2,2", "--azimuth", 0, "--jitter", 0, "--temperature", 6504
    result = run(folder / "constant.json", *options, "-o", folder / f"rig.{suffix}")
    assert result.exit_code == 0, result.output
    rig = el.Rig.load(folder / "constant.json")
    variations = list(el.vary(rig, 4, exposure=(-2, 2), azimuth=0, jitter=0, temperature=6504))
    texts = [(folder / f"rig.000{number}.{suffix}").read_text() for number in range(4)]
    pattern = r'envlights_scale" data="([^"]+)|SCALE = (\S+)'
    scales = {"".join(re.search(pattern, text).groups("")) for text in texts}
    (scale,) = map(float, scales)
    brightest = max(each.rig.probe(NORMALS).max() for each in variations)
    assert scale * brightest == pytest.approx(1, abs=0.03)
