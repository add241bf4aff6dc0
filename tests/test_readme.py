"""Every block of Python in the README runs as pasted, from the top down, after its demo."""

import os
import re
from pathlib import Path

import pytest

from envlights.cli.demonstration import demo

README = Path(__file__).parent.parent / "README.md"
TEXT = README.read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```python\n(.*?)^```", TEXT, re.M | re.S)


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    """A folder with the files of the demo, and the names that blocks leave behind."""
    folder, before = tmp_path_factory.mktemp("newcomer"), Path.cwd()
    demo(folder)
    os.chdir(folder)
    yield {}
    os.chdir(before)


@pytest.mark.parametrize("number", range(len(BLOCKS)))
def test_a_block_runs_as_pasted(number, session):
    exec(compile(BLOCKS[number], f"README, block {number}", "exec"), session)


def test_the_shortest_path_comes_first():
    """The first block runs alone, in at most eight lines."""
    assert BLOCKS[0].startswith("import envlights as el\n")
    assert len(BLOCKS[0].splitlines()) <= 8


def test_the_figures_are_those_of_the_benchmarks():
    """Number of maps, milliseconds, and errors of four lights in percent."""
    page = (README.parent / "docs/lab/benchmarks.md").read_text(encoding="utf-8")
    part = page.split("## Few lights for a map\n")[1]
    maps = re.search(r"^(\d+) cases\.$", part, re.M)[1]
    seconds, _, shading, shadows = re.search(r"^\| fit \| 4 \| (.*) \|$", part, re.M)[1].split(
        " | "
    )
    measured = (
        int(maps),
        round(float(seconds.split()[0])),
        100 * float(shading),
        100 * float(shadows),
    )
    words = {"nine": 9}
    stated = re.search(
        r"On (\w+) maps, four lights take (\S+) ms, with errors of (\S+) % of the shading"
        r" and (\S+) % of the shadows",
        TEXT,
    )
    number, *figures = stated.groups()
    assert (words[number], *map(float, figures)) == pytest.approx(measured)
