"""Notes with codes, and the channel of `logging`."""

import copy
import json
import logging
import pickle
import re
from pathlib import Path

import numpy as np
import pytest

import envlights as el
from envlights._common.notes import CODES, OTHER

SOURCES = Path(el.__file__).parent
TEXT = "\n".join(path.read_text() for path in SOURCES.rglob("*.py") if path.name != "_notes.py")


@pytest.mark.parametrize("code", CODES)
def test_every_code_is_of_a_sentence_that_the_package_writes(code):
    """A note that gets other words needs other phrases."""
    joined = re.sub(r'"\s*\n\s*f?"', "", TEXT)
    assert [phrase for phrase in CODES[code].phrases if phrase not in joined] == []


def test_the_documentation_lists_every_code_with_its_level_and_meaning():
    page = (Path(__file__).parent.parent / "docs/reference/notes.md").read_text()
    rows = re.findall(r"^\| `([a-z0-9-]+)` \| (\w+) \| (.*) \|$", page, re.M)
    levels = {True: "warning", False: "info"}
    assert rows == [(code, levels[k.is_warning], k.meaning) for code, k in CODES.items()]


def some_maps():
    sky = np.full((32, 64, 3), 0.5, np.float32)
    sky[4, 5] = (np.nan, np.inf, -1)
    codes = np.full((32, 64, 3), 90, np.uint8)
    codes[8:12, 20:24] = 255
    alpha = np.ones((32, 64, 4))
    alpha[28:, :, 3] = 0
    clipped = el.EnvMap(codes)
    yield {"infinite", "nan", "negative"}, el.EnvMap(sky)
    yield {"grey"}, el.EnvMap(np.ones((16, 32)))
    yield {"decoded"}, clipped
    yield {"decoded", "repaired"}, clipped.repaired()
    yield {"unseen"}, el.EnvMap(alpha)
    yield {"filled"}, el.EnvMap(alpha).filled()
    yield {"layout"}, el.EnvMap(np.full((32, 32, 3), 0.5), layout="octahedral")
    yield {"calibrated"}, el.EnvMap(np.ones((16, 32, 3))).calibrated(lux=1000)
    yield {"removed"}, el.split(el.synthetic.hall(64).radiance, 1)[1]
    yield {"limited"}, el.limit(el.synthetic.hall(64).radiance, 1.0)[1]


@pytest.mark.parametrize(
    ("codes", "env"), [pytest.param(*case, id="-".join(sorted(case[0]))) for case in some_maps()]
)
def test_the_notes_of_maps_have_codes(codes, env):
    assert {note.code for note in env.notes} == codes
    assert OTHER not in {note.code for note in el.fit(env, 1).notes}


def test_a_note_is_text_and_keeps_its_code_in_copies_and_files(tmp_path):
    env = el.EnvMap(np.ones((16, 32)))
    rig = el.fit(env, 0)
    assert rig.notes == ("the only channel was read as grey",)
    assert json.loads(json.dumps(rig.notes)) == [str(rig.notes[0])]
    rig.save(tmp_path / "rig.json")
    for again in (pickle.loads(pickle.dumps(rig)), copy.deepcopy(rig)):
        assert again.notes[0].code == "grey"
    assert el.Rig.load(tmp_path / "rig.json").notes[0].code == "grey"
    assert el.Note("a remark of mine").code == OTHER
    assert el.Lights([[0, 1, 0]], [[1, 1, 1]], notes="mine").notes[0].code == OTHER


def test_the_channel_of_logging_carries_notes_and_fits(tmp_path, caplog):
    el.EnvMap(np.ones((16, 32, 3))).save(tmp_path / "map.exr")
    radiance = np.ones((16, 32, 3), np.float32)
    radiance[0, 0] = -1
    el.io.write_exr(tmp_path / "dark.exr", radiance)
    with caplog.at_level(logging.INFO, "envlights"):
        env = el.EnvMap.open(tmp_path / "dark.exr")
        el.fit(env, 1)
    found = [(record.levelname, record.message) for record in caplog.records]
    assert ("WARNING", "3 negative samples set to 0") in found
    assert any(level == "INFO" and text.startswith("fit: ambient") for level, text in found)


@pytest.mark.parametrize(
    "work",
    [
        lambda black: el.fit(black, 2),
        lambda black: el.fit(black, 2, ambient="sh2"),
        lambda black: el.fit(black, 2, floor=True),
        lambda black: el.fit(black, error=0.1),
        lambda black: el.detect(black).report,
        lambda black: el.split(black).lights.report,
        lambda black: next(el.follow([black], 1)),
        lambda black: el.detect_photograph(black.radiance, fov=60).report,
        lambda black: el.fit_probe(np.eye(3)[[0, 1, 2] * 4], np.zeros((12, 3)), 1),
    ],
)
def test_a_result_of_a_black_map_says_so(work):
    """Errors of 0 % and no light would look like a perfect result."""
    result = work(el.EnvMap(np.zeros((16, 32, 3), np.float32)))
    assert [el.Note(note).code for note in result.notes] == ["black"]
    assert "is black everywhere" in str(result)


def test_a_curve_of_errors_of_a_black_map_says_so():
    curve = el.error_curve(np.zeros((16, 32, 3)), [0, 1])
    assert str(curve).endswith("note: the map is black everywhere, so there is no light to find")


def test_a_dim_map_is_not_black():
    dim = np.full((16, 32, 3), np.finfo(np.float32).tiny)
    assert el.fit(dim, 1).notes == ()
    (row,) = el.batch([np.zeros((16, 32, 3))], lights=1, jobs=1).rows()
    assert row["notes"] == ["black"]
