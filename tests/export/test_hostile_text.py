"""Hostile text in each file of lights: nothing of it is run, and the target's parser reads it back.

The content of a file with a hostile note is that of a file with a harmless one, but for the note.
"""

import ast
import io
import json
import re
import tokenize
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import envlights as el
from envlights._common.printable import printable
from envlights.export import TARGETS
from envlights.sequence import formats
from tests.helpers import cases
from tests.reference import pbrt, radiance

pytestmark = pytest.mark.filterwarnings("ignore:.* shows .*:UserWarning")

HARMLESS = "a harmless note"
#: Characters and words that some format takes for its own.
PARTS = [
    *"abc 0.-_~!@#$%&*?'\"`\\:;,|<>()[]{}^+=/\t\n\r\v\f\0\x01\x1b\x7f\x85\xa0",
    *("ü", "光", "👩‍🚀", "\u202e", "\u2028", "\u2029", "\ufeff", "\ufffe", "\ud800", "\udcff"),
    *('"""', "'''", "*/", "/*", "-->", "--", "<!--", "]]>", "</script>", "<script>", "&lt;"),
    *("@LIGHTS@", "@UNITS@", "@MAP@", "@CARDS@", "{{x}}", "{units}", "$name", "${x}", "%s"),
    *("\\n", "\\", "\\x41", "\\u0041", "\\N{BULLET}", '\\"', "@@@", "<UDIM>", "# coding: rot13"),
    *("\nimport os;os.system('touch file')#", "\n!touch file\n", "=cmd|' /C x'!A1", ");x("),
    *("x" * 60, "y" * 2040, "\\" * 600, "光" * 700),
    *("\ndef Xform", "\n[node name="),
]
HOSTILE = st.lists(st.sampled_from(PARTS), min_size=1, max_size=8).map("".join)

SUN = [[0, 1, 0]], [[1, 1, 1]]
CARD = ["rectangle"], [np.array([[-1.0, 0, 0.5], [0, -1, 0.5], [0, 0, 1]])], [[1.0] * 3]


def lights(note):
    return el.Lights(*SUN, notes=[note])


def a_rig(note):
    return el.Rig([1, 2, 3], lights(note), error=0.0, notes=(note,))


def frames(note):
    return [el.sequence.FrameRig([0, 0, 0], lights(note), 0.0, notes=(note,), ids=(1,))]


#: Writers of things that hold a note.
WRITERS = {
    "lights": lambda note, path: lights(note).save(path),
    "rig": lambda note, path: a_rig(note).save(path),
    "cards": lambda note, path: el.export.save(el.Cards(*CARD, notes=[note]), path),
    "frames": lambda note, path: formats.save(frames(note), path),
}


def in_json(path):
    return list(leaves(json.loads(path.read_text(encoding="utf-8"))))


def leaves(data, place=()):
    """Place and value of each leaf of JSON."""
    if isinstance(data, dict | list) and data:
        pairs = data.items() if isinstance(data, dict) else enumerate(data)
        for key, value in pairs:
            yield from leaves(value, (*place, key))
    else:
        yield place, data


def in_json_lines(path):
    lines = path.read_text(encoding="utf-8").split("\n")
    return [leaf for line in lines[:-1] for leaf in leaves(json.loads(line))]


def in_xml(path):
    builder = ElementTree.TreeBuilder(insert_comments=True)
    root = ElementTree.parse(path, ElementTree.XMLParser(target=builder)).getroot()
    return [
        ("comment", each.text)
        if each.tag is ElementTree.Comment
        else (each.tag, sorted(each.attrib.items()))
        for each in root.iter()
    ]


def in_python(path):
    text = path.read_bytes()
    found = tokenize.tokenize(io.BytesIO(text).readline)
    comments = [("comment", each.string) for each in found if each.type == tokenize.COMMENT]
    return [*comments, ("code", ast.dump(ast.parse(text)))]


def in_usd(path):
    from pxr import Sdf

    layer = Sdf.Layer.OpenAsAnonymous(str(path))
    text, layer.documentation = layer.documentation, ""
    return [("documentation", text), ("rest", layer.ExportToString())]


def in_godot(path):
    """Strings, and all else."""
    parts = re.split(r'("(?:[^"\\]|\\.)*")', path.read_text(encoding="utf-8"), flags=re.S)
    return [("code", part) for part in parts[::2]] + [
        ("string", json.loads(part, strict=False)) for part in parts[1::2]
    ]


def in_radiance(path):
    """Words, and the text of all comments."""
    found = list(radiance.tokens(path))
    comments = [text.removeprefix("# ").removesuffix(" ") for kind, text in found if kind[0] == "c"]
    return [("comment", "".join(comments)), *(each for each in found if each[0] == "word")]


def in_pbrt(path):
    return list(pbrt.tokens(path.read_bytes().rstrip()))


def in_csv(path):
    return [("line", line) for line in path.read_text(encoding="utf-8").split("\n")]


#: Parser by the end of the name.
PARSERS = {
    **dict.fromkeys((".json", ".gltf"), in_json),
    **dict.fromkeys((".usd", ".usda", ".usdc"), in_usd),
    ".jsonl": in_json_lines,
    ".xml": in_xml,
    ".py": in_python,
    ".tscn": in_godot,
    ".rad": in_radiance,
    ".pbrt": in_pbrt,
    ".csv": in_csv,
}


def plain(value):
    """Text on one line; the escape of a second hyphen in a comment of XML is undone."""
    return printable(value).replace("\\x2d", "-") if isinstance(value, str) else value


def content(kind, note, path):
    """Content of a file with a note, by the parser of its suffix."""
    if path.suffix.startswith(".usd"):  # OpenUSD writes .usdc, and reads all
        pytest.importorskip("pxr", reason="needs usd-core")
    WRITERS[kind](note, path)
    found = [(place, plain(value)) for place, value in PARSERS[path.suffix](path)]
    for each in path.parent.iterdir():
        each.unlink()
    return found


def check(kind, texts, path):
    """A text is the only difference from a harmless one."""
    harmless = content(kind, HARMLESS, path)
    assert any(HARMLESS in str(value) for _, value in harmless) or kind == "frames"
    for text in texts:
        expected = [
            (place, value.replace(HARMLESS, plain(text)) if isinstance(value, str) else value)
            for place, value in harmless
        ]
        assert content(kind, text, path) == expected


SUFFIXES = [suffix for target in TARGETS for suffix in target.suffixes]
CASES = [
    *((suffix, kind) for suffix in SUFFIXES for kind in ("lights", "rig", "cards")),
    *((suffix, "frames") for suffix in formats.SUFFIXES),
]
#: Files that are written fast.
MANY = [case for case in CASES if case[1] in ("rig", "frames")]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder on a fast disk."""
    monkeypatch.setattr("envlights._common.files._flush", lambda _: None)
    return tmp_path


def any_text(examples):
    """Test with this number of hostile texts."""
    every = settings(max_examples=examples, suppress_health_check=list(HealthCheck))
    return lambda test: every(given(text=HOSTILE)(test))


def any_texts(examples, each):
    """Test with this number of lists of hostile texts."""
    every = settings(max_examples=examples, suppress_health_check=list(HealthCheck))
    lists = st.lists(HOSTILE, min_size=each, max_size=each)
    return lambda test: every(given(texts=lists)(test))


@pytest.mark.parametrize(("suffix", "kind"), CASES)
@any_texts(5, each=4)
def test_a_hostile_note_is_text_alone(folder, suffix, kind, texts):
    check(kind, texts, folder / f"scene{suffix}")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("suffix", "kind"), [case for case in CASES if case[1] in ("rig", "frames")]
)
@any_texts(cases(short=20, long=100), each=20)
def test_many_hostile_notes_are_text_alone(folder, suffix, kind, texts):
    check(kind, texts, folder / f"scene{suffix}")


@any_text(50)
def test_a_hostile_note_comes_back_from_our_own_file(folder, text):
    lights(text).save(folder / "a.json")
    assert el.Lights.load(folder / "a.json").notes == (printable(text),)


@any_text(50)
def test_hostile_units_are_refused_in_one_line(text):
    with pytest.raises(el.EnvLightsError, match="units must be") as refusal:
        el.Lights(*SUN, units=text)
    assert str(refusal.value).isprintable()


class Page(HTMLParser):
    """Tags and text of a page."""

    def __init__(self, text):
        super().__init__()
        self.found = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, str(attrs)))

    def handle_endtag(self, tag):
        self.found.append(("end", tag))

    def handle_data(self, data):
        self.found.append(("text", data))


@any_text(20)
def test_a_hostile_title_of_a_page_is_text_alone(text):
    pages = (Page(el.view(a_rig(HARMLESS), title=title).html) for title in (HARMLESS, text))
    harmless, found = ([each for each in page.found if each[0] != "text"] for page in pages)
    assert found == harmless


def test_radiance_runs_no_command_of_a_long_note(folder, monkeypatch):
    """It parsed a comment beyond 2047 bytes as a part of the scene."""
    pyradiance = pytest.importorskip("pyradiance")
    monkeypatch.chdir(folder)
    for length in range(1940, 2000):
        lights("x" * length + "!touch file").save("a.rad")
        pyradiance.oconv("a.rad")
    assert not (folder / "file").exists()
