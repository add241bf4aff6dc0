"""Text from files and paths cannot control the terminal, nor forge lines of the output."""

import json

import numpy as np
import OpenImageIO as oiio  # noqa: N813, its own name for itself
import pytest
from click.testing import CliRunner

import envlights as el
from envlights._common.printable import printable
from envlights.cli import main

#: A title of the window, a colour, a line of its own, and a change of the direction of writing.
EVIL = "x\x1b]0;title\x07\x1b[31m\nnote: all is well\u202e\x9b"
SHOWN = "x\\x1b]0;title\\x07\\x1b[31m\\nnote: all is well\\u202e\\x9b"


def output(*arguments):
    result = CliRunner().invoke(main, [str(each) for each in arguments])
    assert result.exception is None or isinstance(result.exception, SystemExit)
    assert all(line.isprintable() for line in result.output.split("\n"))
    return result.output


@pytest.fixture
def picture(tmp_path):
    """A map with a channel of this name."""
    spec = oiio.ImageSpec(32, 16, 4, oiio.FLOAT)
    spec.channelnames = ("R", "G", "B", EVIL)
    file = oiio.ImageOutput.create("map.exr")
    file.open(str(tmp_path / "map.exr"), spec)
    file.write_image(np.ones((16, 32, 4), np.float32))
    file.close()
    return tmp_path / "map.exr"


def test_names_of_channels_are_printable(picture):
    note = f"other channels were ignored: {SHOWN}"
    assert note in el.EnvMap.open(picture).notes
    assert note in el.fit(picture, 1).notes
    for command in ("detect", "fit", "split"):
        assert f"note: {note}\n" in output(command, picture)


def test_names_in_refusals_are_printable(picture):
    assert SHOWN in output("detect", picture, "--part", "none") + output("fit", f"{EVIL}.exr")
    with pytest.raises(el.EnvLightsError) as refusal:
        el.EnvMap.open(picture, channels="none")
    assert SHOWN in str(refusal.value)
    with pytest.raises(FileNotFoundError) as missing:
        el.EnvMap.open(f"{EVIL}.exr")
    assert SHOWN in str(missing.value)


def test_text_in_files_of_the_package_is_printable(tmp_path):
    rig = el.Rig([1, 1, 1], el.Lights([[0, 1, 0]], [[1, 1, 1]]), 0.0).to_dict()
    rig |= {"notes": [EVIL], "report": rig["report"] | {"measured_on": EVIL}}
    (tmp_path / "rig.json").write_text(json.dumps(rig))
    loaded = el.Rig.load(tmp_path / "rig.json")
    assert loaded.notes == (SHOWN,)
    assert loaded.report.measured_on == SHOWN
    found = el.detect(el.synthetic.hall(32).radiance).to_dict()
    found["report"] |= {"notes": [EVIL], "reason": EVIL, "method": EVIL}
    (tmp_path / "found.json").write_text(json.dumps(found))
    report = el.detection.DetectedLights.load(tmp_path / "found.json").report
    assert (report.notes, report.reason, report.method) == ((SHOWN,), SHOWN, SHOWN)


def test_names_of_written_files_are_printable(tmp_path):
    el.Lights([[0, 1, 0]], [[1, 1, 1]]).save(tmp_path / "lights.json")
    path = tmp_path / f"{EVIL}.csv"
    assert f"wrote {tmp_path}/{SHOWN}.csv\n" in output("export", tmp_path / "lights.json", path)
    assert path.exists()


def test_ordinary_text_stays_as_it_is():
    for text in ("Küche", "光と影", "it's 'so'", "back\\slash", "", "a  b"):
        assert printable(text) == text
        assert str(el.EnvLightsError(text)) == text
    assert printable(printable(EVIL)) == printable(EVIL) == SHOWN
    assert str(el.EnvLightsError(EVIL)) == SHOWN


def test_names_of_compared_files_are_printable(tmp_path):
    for name, gain in (("truth", 1), ("guess", 2)):
        (tmp_path / name).mkdir()
        for stem in (EVIL, f"alone in {name}{EVIL}"):
            el.EnvMap(np.full((8, 16, 3), gain, np.float32)).save(tmp_path / name / f"{stem}.exr")
    folders = tmp_path / "truth", tmp_path / "guess"
    shown = output("compare", *folders, "-o", tmp_path / "table.csv")
    assert f"\n{SHOWN} " in shown
    assert f"failed: alone in truth{SHOWN}: " in shown
    assert "\x1b" not in (tmp_path / "table.csv").read_text()


def test_losses_refusals_of_click_and_files_of_a_sequence_are_printable(tmp_path, picture):
    assert SHOWN in output("fit", picture, f"--{EVIL}")
    assert SHOWN in output("fit", picture, EVIL)
    assert SHOWN in output("fit", picture, "--lights", EVIL)
    assert SHOWN in output(EVIL)
    assert SHOWN in output("batch", picture, "-o", tmp_path / "out", "--set", f"{EVIL}=1")
    assert SHOWN in output("follow", tmp_path / f"{EVIL}*.exr")
    picture.rename(tmp_path / f"{EVIL}.exr")
    assert SHOWN in output("follow", tmp_path / "*.exr", "-o", tmp_path / f"{EVIL}.jsonl")
    assert SHOWN in output("follow", tmp_path / "*.exr", "-o", tmp_path / f"{EVIL}.none")


def test_a_result_is_printable_whatever_its_texts_hold():
    lights = el.Lights([[0, 1, 0]], [[1, 1, 1]], notes=[EVIL])
    rig = el.Rig([1, 1, 1], lights, 0.0, notes=(EVIL,))
    failed = el.comparison.FolderComparison(
        el.comparison.Protocol(), {EVIL: el.compare(rig, rig)}, {EVIL: EVIL}
    )
    for text in (str(lights), rig.verbose(), str(failed), repr(failed)):
        assert all(line.isprintable() for line in text.split("\n"))
        assert "note: all is well" not in text.split("\n")


def test_the_lines_of_details_stay_lines():
    rig = el.fit(el.synthetic.hall(32).radiance, 2)
    for text in (rig.verbose(), el.compare(rig, rig).lights.verbose()):
        assert "\\n" not in text
