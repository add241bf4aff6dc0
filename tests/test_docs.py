"""Every block of Python in a page of the documentation runs as pasted, from the top down."""

import os
import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parent.parent / "docs"


@pytest.mark.parametrize(
    "page",
    [
        "batch.md",
        "compare.md",
        "compare_lights.md",
        "layouts.md",
        "overlays.md",
        "sun.md",
        "units.md",
    ],
)
def test_a_page_runs_as_pasted(page, tmp_path):
    text = (DOCS / page).read_text(encoding="utf-8")
    before = Path.cwd()
    os.chdir(tmp_path)
    try:
        names = {}
        for block in re.findall(r"^```python\n(.*?)^```", text, re.M | re.S):
            exec(compile(block, page, "exec"), names)
    finally:
        os.chdir(before)
