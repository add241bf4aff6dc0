"""Every block of Python in the README runs as pasted, from the top down, after its demo."""

import os
import re
from pathlib import Path

import pytest

from envlights.demo import demo

README = Path(__file__).parent.parent / "README.md"
BLOCKS = re.findall(r"^```python\n(.*?)^```", README.read_text(encoding="utf-8"), re.M | re.S)


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
