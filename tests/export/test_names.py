"""Names of files that mean something else to a target.

The target's own reader finds the texture, or there is a refusal that leaves the folder empty.
"""

import ast
import json
import os
import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import envlights as el
from envlights.export import TARGETS, target_of
from tests.reference import pbrt

pytestmark = pytest.mark.filterwarnings("ignore:MuJoCo shows:UserWarning")

#: Characters and words that some format takes for its own.
PARTS = [
    *"abc 0.-_~!@#$%&*?'\"`\\:;,|<>()[]{}^+=\t\n\r\x01\x1b\x7f\x85\xa0",
    *("ü", "Küche", "光", "é", "👩‍🚀", "\u202e", "\u2028", "\ufeff", "\ufffe", "\ud800", "\udcff"),
    *("<UDIM>", "@@@", '"', "'", "$x", "${HOME}", "%41", "%d", "####", "\\u", "\\n", "]]>", "&lt;"),
    *("-->", "..", "{face}", "CON", "*.exr", "`id`", "!id", "x" * 60),
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


def in_usd(path):
    usd = pytest.importorskip("pxr.Usd", reason="needs usd-core")
    stage = usd.Stage.Open(str(path))
    file = stage.GetPrimAtPath("/rig/ambient").GetAttribute("inputs:texture:file").Get()
    assert file.resolvedPath == str(path.parent / file.path)
    return file.path.removeprefix("./")


def in_mitsuba(path):
    mitsuba = pytest.importorskip("mitsuba")
    mitsuba.set_variant("scalar_rgb")
    mitsuba.load_file(str(path))
    return ElementTree.parse(path).find(".//string[@name='filename']").get("value")


def in_blender(path):
    for node in compile(path.read_bytes(), "script", "exec", ast.PyCF_ONLY_AST).body:
        if isinstance(node, ast.Assign) and node.targets[0].id == "MAP":
            return ast.literal_eval(node.value)
    return None


def words_of_radiance(path):
    """Words as `fgetword` reads them, after the comments at the start."""
    text = re.sub(rb"\A(#[^\n]*\n)*", b"", path.read_bytes())
    while text := text.lstrip(b" \t\n\v\f\r"):
        if text[:1] in (b'"', b"'"):
            word, _, text = text[1:].partition(text[:1])
        else:
            word = text.split(None, 1)[0]
            text = text[len(word) :]
        yield os.fsdecode(word)


def in_radiance(path):
    words = list(words_of_radiance(path))
    place = words.index("blue") + 1
    assert words[place + 1] == "."
    return words[place]


def in_json(path):
    return json.loads(path.read_text(encoding="utf-8"))["map"]


def in_godot(path):
    """Path of the external resource, whose only escapes here are of quotes."""
    text = path.read_text(encoding="utf-8")
    return json.loads(re.search(r'path=("(?:[^"\\]|\\.)*") id="map"', text).group(1))


READERS = {
    "godot": in_godot,
    "usd": in_usd,
    "mitsuba": in_mitsuba,
    "blender": in_blender,
    "radiance": in_radiance,
    "pbrt": lambda path: pbrt.light_sources(path)[-1][1]["filename"],
    "unity": in_json,
    "unreal": in_json,
}


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
    if read := READERS.get(target_of(path).name):
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
    written = sum(check_whole(folder / f"{hostile(rng)}{suffix}") for _ in range(1300))
    assert written > 200


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_some_hostile_names_are_read_back_or_refused(folder, suffix):
    rng = np.random.default_rng(7)
    for _ in range(40):
        check_whole(folder / f"{hostile(rng)}{suffix}")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_name_that_is_too_long_leaves_nothing(folder, suffix):
    """The texture's name is longer than the scene's, and is checked first."""
    assert check_whole(folder / f"{'x' * (255 - len(suffix))}{suffix}") == (
        target_of(f"x{suffix}").name not in READERS
    )


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
