"""Checks of words: violations that they report, and text that they accept."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from . import words


def rules_of(folder: Path, name: str, source: str) -> list[str]:
    """The rules that `source`, written to a file called `name`, breaks."""
    path = folder / name
    path.write_text(source, encoding="utf-8")
    return [violation.rule for violation in words.violations_in(path)]


RUST = "/// {}\nfn light_count() {{}}\n"
PYTHON = 'def light_count():\n    """{}\n\n    More.\n    """\n'


@pytest.mark.parametrize(("suffix", "form"), [("rs", RUST), ("py", PYTHON)])
@pytest.mark.parametrize(
    ("doc", "rules"),
    [
        ("Number of lights.", []),
        ("The number of lights that a rig holds.", []),
        ("How many lights it is.", ["opening"]),
        ("`n`, whether none.", []),
        ("Whether there are any.", ["opening"]),
        ("The same without a map.", ["opening"]),
        ("As few lights, e.g. one.", ["opening"]),
        (" ".join(["word"] * 25) + ".", []),
        (" ".join(["word"] * 26) + ".", ["length"]),
        ("Short. " + " ".join(["word"] * 26) + ".", []),
    ],
)
def test_doc_lines_make_sense_alone(tmp_path, suffix, form, doc, rules):
    assert rules_of(tmp_path, f"count.{suffix}", form.format(doc)) == rules


def test_a_comment_may_open_with_any_word(tmp_path):
    assert rules_of(tmp_path, "count.rs", "// What follows.\nfn count() {}\n") == []
    assert rules_of(tmp_path, "count.py", "# What follows.\n") == []


def test_the_help_of_an_option_is_a_doc_line(tmp_path):
    assert rules_of(tmp_path, "cli.py", 'option("-o", help="Where it goes.")\n') == ["opening"]


@pytest.mark.parametrize(
    "name", ["Found", "Kept", "Fitted", "Exchanged", "given", "_taken", "rotated"]
)
def test_a_bare_participle_is_no_name(tmp_path, name):
    for keyword in ("struct", "enum", "fn", "mod", "type", "pub(crate) const fn"):
        assert rules_of(tmp_path, "x.rs", f"{keyword} {name};\n") == ["participle"]
    assert rules_of(tmp_path, "x.py", f"class {name}:\n    pass\n") == ["participle"]
    assert rules_of(tmp_path, "x.py", f"def {name}():\n    pass\n") == ["participle"]
    assert rules_of(tmp_path, f"{name.strip('_').lower()}.rs", "") == ["participle"]


@pytest.mark.parametrize(
    "name", ["seed", "speed", "is_clipped", "FittedRig", "shared", "red", "bed"]
)
def test_other_names_pass(tmp_path, name):
    assert rules_of(tmp_path, "x.rs", f"fn {name}() {{}}\n") == []


def test_a_copy_with_a_change_is_named_as_python_names_it(tmp_path):
    source = "class Rig:\n    def rotated(self):\n        pass\n    def {}(self):\n        pass\n"
    assert rules_of(tmp_path, "rig.py", source.format("save")) == []
    assert rules_of(tmp_path, "rig.py", source.format("taken")) == ["participle"]


@pytest.mark.parametrize(("pattern", "plain"), words.PHRASES)
def test_each_phrase_is_found_in_prose_and_not_in_code(tmp_path, pattern, plain):
    phrase = re.sub(r"\\s\+", " ", re.sub(r"\(\?:(\w+)\|[^)]*\)|\w\?|\|.*", r"\1", pattern))
    assert plain
    assert rules_of(tmp_path, "x.rs", f"// it is {phrase} here\n") == ["phrase"]
    assert rules_of(tmp_path, "x.rs", f'const X: &str = "it is {phrase} here";\n') == ["phrase"]
    assert rules_of(tmp_path, "x.py", f'x = f"{{y}} is {phrase} here"\n') == ["phrase"]
    assert rules_of(tmp_path, "x.md", f"one\n\nit is {phrase} here\n") == ["phrase"]
    assert rules_of(tmp_path, "x.md", f"```sh\n{phrase}\n```\n`{phrase}` here\n") == []


def test_a_phrase_across_two_lines_is_found_with_its_line(tmp_path):
    path = tmp_path / "x.rs"
    path.write_text("\n// one\n// two side\n// by side\n", encoding="utf-8")
    assert [violation.line for violation in words.violations_in(path)] == [3]


@pytest.mark.parametrize("number", [0.83, 0.5])
def test_a_number_has_a_digit_before_its_point(tmp_path, number):
    short = str(number)[1:]
    for text, rules in ((short, ["digit"]), (str(number), []), (f"1{short}", [])):
        assert rules_of(tmp_path, "x.rs", f"// at most {text} %\n") == rules
        assert rules_of(tmp_path, "x.rs", f'const X: &str = "{text} % {{:.3}}";\n') == rules
        assert rules_of(tmp_path, "x.py", f'x = f"{text} % {{y:.3f}}"\n') == rules
        assert rules_of(tmp_path, "x.md", f"| {text} % | `{short}` |\n") == rules


def test_too_many_names_files_and_numbers_are_found(tmp_path):
    numbers = {"tuned": words.TUNED_NUMBERS, "format": words.FORMAT_NUMBERS}
    assert list(words.too_many(tmp_path, words.TOP_NAMES, numbers)) == []
    (tmp_path / "fit").mkdir()
    (tmp_path / "formats").mkdir()
    for number in range(words.FOLDER_FILES + 1):
        (tmp_path / f"fit/file_{number}.py").touch()
        (tmp_path / f"formats/file_{number}.py").touch()
        (tmp_path / f"file_{number}.py").touch()
    more = {kind: number + 1 for kind, number in numbers.items()}
    found = words.too_many(tmp_path, words.TOP_NAMES + 1, more)
    assert [(each.path.name, each.text.split(",")[0]) for each in found] == [
        (tmp_path.name, f"{words.TOP_NAMES + 1} names"),
        (tmp_path.name, f"{words.TUNED_NUMBERS + 1} tuned"),
        (tmp_path.name, f"{words.FORMAT_NUMBERS + 1} of formats"),
        (tmp_path.name, f"{words.FOLDER_FILES + 1} files"),
        ("fit", f"{words.FOLDER_FILES + 1} files"),
    ]


def test_public_names_and_tuned_numbers_are_counted(tmp_path):
    for folder in ("src/formats", "python"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "src/formats/a.rs").write_text("const MARK: u8 = 0xD8;\n")
    (tmp_path / "src/a.rs").write_text(
        'const LEAST: f64 = 2.5;\npub const BOTH: [f64; 2] = [1.0, 2.0];\nconst TEXT: &str = "1";\n'
    )
    (tmp_path / "python/a.py").write_text("_LEAST = 0.5\nNAMES = ('a',)\n#: Text.\nMOST: int = 3\n")
    (tmp_path / "python/__init__.py").write_text('__all__ = ["a", "b"]\n')
    assert words.numbers_in(tmp_path) == {"tuned": 4, "format": 1}
    assert words.public_names(tmp_path / "python") == 2


def test_types_and_files_of_the_kernels_have_one_name_each(tmp_path):
    paths = []
    for folder in ("fit", "split"):
        for name in ("mod.rs", "tests.rs", "rows.rs"):
            path = tmp_path / "kernels" / folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text("struct Rows;\n" if name == "rows.rs" else "fn rows() {}\n")
            paths.append(path)
    assert [violation.rule for violation in words.repeated_names(paths)] == [
        "type twice",
        "file twice",
    ]
    assert list(words.repeated_names(paths[:3])) == []


def test_the_script_names_file_line_and_rule(tmp_path):
    (tmp_path / "x.rs").write_text("fn a() {}\nfn found() {}\n")
    script = [sys.executable, words.__file__, str(tmp_path)]
    result = subprocess.run(script, capture_output=True, text=True, check=False)
    assert result.returncode == 1
    assert result.stdout.split("\n")[0].endswith("x.rs:2: participle: fn found")
