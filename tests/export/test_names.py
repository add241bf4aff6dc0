"""Names of files that mean something else to a target.

The target's own reader finds the texture, or there is a refusal that leaves the folder empty.
"""

import os
from pathlib import Path

import numpy as np
import pytest

import envlights as el
from envlights.export import TARGETS, target_of
from tests.export.file_errors import readers_of
from tests.helpers import cases

pytestmark = pytest.mark.filterwarnings("ignore:.* shows .*:UserWarning")

#: Characters and words that some format takes for its own.
PARTS = [
    *"abc 0.-_~!@#$%&*?'\"`\\:;,|<>()[]{}^+=\t\n\r\x01\x1b\x7f\x85\xa0",
    *("ü", "Küche", "光", "é", "👩‍🚀", "\u202e", "\u2028", "\ufeff", "\ufffe", "\ud800", "\udcff"),
    *("<UDIM>", "@@@", '"', "'", "$x", "${HOME}", "%41", "%d", "####", "\\u", "\\n", "]]>", "&lt;"),
    *("-->", "..", "{face}", "@MAP@", "@FILE@", "CON", "*.exr", "`id`", "!id", "x" * 60),
]
#: Names as people give them, which every target must read.
ORDINARY = ["scene", "my scene", "Küche", "光", "50%", "a,b;c", "#1", "-x", "(1)", "[a]", "a+b=c"]
#: Names with a character of some format, and the targets that refuse it.
SPECIAL = {
    "sun@2x": set(),
    "a@@@b@": set(),
    "it's": set(),
    'say "hi"': set(),
    "!id": set(),
    "$x": {"mitsuba"},
    "\ufffe": {"mitsuba"},
    "a\\b": {"blender", "usd", "godot"},
    "~x": {"radiance"},
    "'\"": {"radiance"},
    "<UDIM>": {"usd"},
    "tab\tx": {"usd", "radiance", "godot"},
    "a\nb": {"usd", "radiance", "godot"},
    "\x7f": {"usd", "radiance", "godot"},
    "\x85": {"usd", "radiance", "godot"},
    "\x01": {"usd", "mitsuba", "radiance", "godot"},
    "\x1b[31m": {"usd", "mitsuba", "radiance", "godot"},
    "\udcff": {"usd", "mitsuba", "blender", "radiance", "pbrt", "unity", "unreal", "godot"},
}
SUFFIXES = [suffix for target in TARGETS for suffix in target.suffixes]
#: A sky over a floor, which most targets need a map for; points, so that none needs a larger one.
RIG = el.Rig([1, 2, 3], el.Lights([[0, 1, 0]], [[1, 1, 1]]), error=0.0, floor=True)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The working directory, where Radiance looks for pictures; maps are small, disks are fast."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("envlights._common.files._flush", lambda _: None)
    monkeypatch.setattr("envlights.export.scene.ROWS", 2)
    return tmp_path


def reader_of(path):
    """Function `texture_of_file` in the test of the target; None for a target without a texture."""
    return getattr(readers_of(target_of(path)), "texture_of_file", None)


def refusal_of(path):
    """Sentence of the refusal to save at `path`; None if there is none."""
    try:
        RIG.save(path)
    except el.EnvLightsError as refusal:
        return str(refusal)
    return None


def check_whole(path):
    """Save at `path`: its target reads the name of the texture (True), or nothing is written."""
    if refusal := refusal_of(path):
        assert refusal.isprintable()
        assert list(path.parent.iterdir()) == []
        return False
    if read := reader_of(path):
        name = read(path)
        assert name.startswith(f"{path.stem}.ambient.")
        assert {each.name for each in path.parent.iterdir()} == {path.name, name}
    for each in path.parent.iterdir():
        each.unlink()
    return True


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("name", [*ORDINARY, *SPECIAL])
def test_names_that_a_target_reads_are_written(folder, name, suffix):
    if suffix == ".usdc":
        pytest.importorskip("pxr.Usd", reason="needs usd-core")
    path = folder / f"{name}{suffix}"
    refused = SPECIAL.get(name, set())
    assert check_whole(path) == (target_of(path).name not in refused)


def hostile(rng):
    """A name of a few parts; some are too long for a file."""
    return "".join(rng.choice(PARTS, rng.integers(1, 9))).strip("\0/") or "x"


@pytest.mark.slow
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_hostile_names_are_read_back_or_refused(folder, suffix):
    rng = np.random.default_rng(42)
    names = cases(short=200, long=1300)
    written = sum(check_whole(folder / f"{hostile(rng)}{suffix}") for _ in range(names))
    assert written > names * 200 / 1300


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_some_hostile_names_are_read_back_or_refused(folder, suffix):
    rng = np.random.default_rng(7)
    for _ in range(40):
        check_whole(folder / f"{hostile(rng)}{suffix}")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_name_that_is_too_long_leaves_nothing(folder, suffix):
    """The texture's name is longer than the scene's, and is checked first."""
    path = folder / f"{'x' * (255 - len(suffix))}{suffix}"
    assert check_whole(path) == (reader_of(path) is None)


@pytest.mark.parametrize("name", SPECIAL)
def test_radiance_itself_finds_the_picture(folder, name):
    pyradiance = pytest.importorskip("pyradiance")
    path = folder / f"{name}.rad"
    if refusal_of(path):
        return
    (folder / "scene.oct").write_bytes(pyradiance.oconv(str(path)))
    ray = b"0 0 0 0.05 0 1\n"
    seen = pyradiance.rtrace(ray, folder / "scene.oct", header=False).decode().split()
    np.testing.assert_allclose(np.array(seen, float), RIG.ambient, rtol=0.05)


WRITERS = {
    "usd": el.export.usd,
    "blender": el.export.blender,
    "radiance": el.export.radiance,
    "pbrt": el.export.pbrt,
    "unity": el.export.unity,
    "unreal": el.export.unreal,
}


@pytest.mark.parametrize("target", WRITERS)
def test_the_texture_of_a_text_is_checked_too(target):
    with pytest.raises(
        el.EnvLightsError, match=r"cannot read a texture whose name holds '\\ud800'"
    ):
        WRITERS[target](RIG, texture="a\ud800b.exr")


def test_a_path_of_undecodable_bytes_holds_all_that_needs_no_texture(tmp_path):
    folder = Path(os.fsdecode(os.fsencode(tmp_path) + b"/\xff"))
    folder.mkdir()
    pytest.importorskip("pxr.Usd", reason="needs usd-core")
    for suffix in SUFFIXES:
        RIG.lights.save(folder / f"rig{suffix}")
        assert (folder / f"rig{suffix}").stat().st_size > 0
