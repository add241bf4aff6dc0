"""Arrows between Rust files and folders point down: no cycle, no import from a later step."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[1] / "src"

Tree = dict[str, str]


def tree_of(source: Path) -> Tree:
    """The code of each module without comments and tests, by its path in the crate."""
    code = {}
    for file in source.rglob("*.rs"):
        name = "::".join(file.relative_to(source).with_suffix("").parts)
        text = re.sub(r"//.*", "", file.read_text())
        test_only = r"#\[cfg\(test\)\]\s*(#\[[^\n]*\]\s*)*(pub )?mod \w+"
        code[name.removesuffix("::mod")] = re.sub(test_only + r"(;|\s*\{.*)", "", text, flags=re.S)
    declared = {
        f"{module}::{child}".removeprefix("lib::")
        for module, text in code.items()
        for child in re.findall(r"\bmod (\w+);", text)
    }
    return {module: text for module, text in code.items() if module in declared}


def spelt_out(use: str) -> Iterator[str]:
    """The paths of a `use` line, without its braces."""
    start, brace, rest = use.partition("{")
    if not brace:
        yield re.sub(r"\s+as\s+\w+|\s", "", use)
        return
    depth, part = 0, ""
    for letter in rest:
        if depth == 0 and letter in ",}":
            if part.strip():
                yield from spelt_out(start + part)
            part = ""
        else:
            part += letter
        depth += (letter == "{") - (letter == "}")


def absolute(path: str, module: str, tree: Tree) -> str:
    """`path`, as written in `module`, from the root of the crate; empty for another crate."""
    first, _, rest = path.partition("::")
    if first == "crate":
        return rest
    if first in ("super", "self"):
        at = module.rpartition("::")[0] if first == "super" else module
        return absolute(rest, at, tree) if rest.startswith("super") else f"{at}::{rest}".strip(":")
    return f"{module}::{path}" if f"{module}::{first}" in tree else ""


def paths_in(module: str, tree: Tree, public: bool = False) -> list[str]:
    """Imports of a module, or its re-exports if `public`."""
    start = r"\bpub(?:\(crate\))? use " if public else r"\buse "
    lines = re.findall(start + r"([^;]+);", tree[module])
    return [absolute(path, module, tree) for line in lines for path in spelt_out(line)]


def home_of(path: str, tree: Tree) -> str:
    """The module in which the item at `path` is written, however often it is handed on."""
    module, _, item = path.removesuffix("::self").rpartition("::")
    if path.removesuffix("::self") in tree:
        return path.removesuffix("::self")
    if module not in tree:
        return home_of(module, tree) if module else ""
    for handed_on in paths_in(module, tree, public=True):
        if handed_on.rpartition("::")[2] == item:
            return home_of(handed_on, tree)
    return module


def arrows_of(tree: Tree) -> dict[str, set[str]]:
    """The modules that each module needs: its own below it, and those of its imports and paths."""
    arrows = {}
    for module, text in tree.items():
        inline = re.findall(r"\b(?:crate|super|self)(?:::\w+)+", re.sub(r"\buse [^;]+;", "", text))
        paths = [*paths_in(module, tree), *(absolute(path, module, tree) for path in inline)]
        below = {each for each in tree if each.rpartition("::")[0] == module}
        arrows[module] = (below | {home_of(path, tree) for path in paths if path}) - {module, ""}
    return arrows


def in_cycles(arrows: dict[str, set[str]]) -> set[str]:
    """The modules from which a way of arrows leads back."""

    def reached_from(start: str) -> set[str]:
        found, left = set(), [start]
        while left:
            left += (new := arrows.get(left.pop(), set()) - found)
            found |= new
        return found

    return {module for module in arrows if module in reached_from(module)}


def between_rooms(folder: str, arrows: dict[str, set[str]]) -> dict[str, set[str]]:
    """The arrows among the files and folders directly in `folder`; a folder is one room."""
    room = re.compile(rf"{folder}::\w+" if folder else r"\w+")
    rooms: dict[str, set[str]] = {}
    for module, needed in arrows.items():
        if (own := room.match(module)) and module != folder:
            others = {other[0] for each in needed if (other := room.match(each)) and each != folder}
            rooms.setdefault(own[0], set()).update(others - {own[0]})
    return rooms


def cycles_of_rooms(arrows: dict[str, set[str]]) -> set[str]:
    """The files and folders that need each other through any of their files."""
    folders = {module.rpartition("::")[0] for module in arrows}
    return {room for folder in folders for room in in_cycles(between_rooms(folder, arrows))}


def steps_of(tree_page: str) -> list[str]:
    """The rows of the table in `kernels/mod.rs`."""
    return re.findall(r"^//! \|.*\| `(\w+)(?:\.rs|/)` +\|$", tree_page, flags=re.M)


TREE = tree_of(SOURCE)
ARROWS = arrows_of(TREE)


def test_no_two_files_import_each_other():
    assert in_cycles(ARROWS) == set()


def test_no_two_folders_need_each_other():
    assert cycles_of_rooms(ARROWS) == set()


def test_a_step_uses_only_the_steps_before_it():
    steps = steps_of((SOURCE / "kernels" / "mod.rs").read_text())
    assert set(steps) == {each.split("::")[1] for each in TREE if each.startswith("kernels::")}
    for module, needed in ARROWS.items():
        if not module.startswith("kernels::"):
            continue
        step = steps.index(module.split("::")[1])
        for other in needed:
            if other in ("error", "interrupt"):
                continue
            assert other.startswith("kernels::"), f"{module} needs {other}"
            assert steps.index(other.split("::")[1]) <= step, (
                f"{module} needs {other}, which comes after it"
            )


@pytest.mark.parametrize(
    ("files", "cycle"),
    [
        ({"a.rs": "use crate::b::B;", "b.rs": "use crate::c::C;", "c.rs": ""}, set()),
        ({"a.rs": "use crate::b::B;", "b.rs": "use super::{a::A, c};", "c.rs": ""}, {"a", "b"}),
        ({"a.rs": "fn f() { crate::b::g() }", "b.rs": "use crate::a::{self};"}, {"a", "b"}),
        ({"a.rs": "// use crate::b;", "b.rs": "use crate::a;"}, set()),
        ({"a.rs": "#[cfg(test)]\nmod tests { use crate::b; }", "b.rs": "use crate::a;"}, set()),
        ({"a/mod.rs": "mod b;\npub struct A;", "a/b.rs": "use super::A;"}, {"a", "a::b"}),
        (
            {"a/mod.rs": "mod b;\nmod c;\npub use c::C;", "a/b.rs": "use super::C;", "a/c.rs": ""},
            set(),
        ),
    ],
)
def test_cycles_are_found(tmp_path, files, cycle):
    names = sorted({name.split("/")[0].removesuffix(".rs") for name in files})
    for name, text in {**files, "lib.rs": "\n".join(f"mod {name};" for name in names)}.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    assert in_cycles(arrows_of(tree_of(tmp_path))) == cycle


def test_cycles_of_folders_are_found():
    arrows = {
        "lib": {"a"},
        "a": {"a::file", "a::folder"},
        "a::file": {"a::folder::one"},
        "a::folder": {"a::folder::one", "a::folder::two"},
        "a::folder::one": set(),
        "a::folder::two": {"a::file"},
    }
    assert in_cycles(arrows) == set()
    assert cycles_of_rooms(arrows) == {"a::file", "a::folder"}


def test_tables_of_folders_name_files_that_exist():
    rows = {
        (file, name)
        for pattern in ("src/**/mod.rs", "python/envlights/**/__init__.py")
        for file in SOURCE.parent.glob(pattern)
        for row in re.findall(r"^(?://! )?\| .*$", file.read_text(), re.MULTILINE)
        for name in re.findall(r"`([\w/]+(?:\.(?:rs|py|js|glsl|css)|/))`", row)
    }
    assert len(rows) > 200
    missing = [(file, name) for file, name in rows if not (file.parent / name).exists()]
    assert missing == []
