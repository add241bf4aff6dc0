"""The pictures of docs/axes.md."""

import struct
from pathlib import Path

import pytest

import envlights as el

DOCS = Path(__file__).parents[2] / "docs"


def names_in(panel):
    return [text.get_text() for text in panel.texts if text.get_text()]


def test_the_picture_names_each_arrow():
    figure = el.plot.axes_picture()
    panels = {panel.get_title().partition("\n")[0]: panel for panel in figure.axes}
    assert names_in(panels["Unity"]) == ["−x", "+y", "+z", "map"]
    assert "left-handed" in panels["Unity"].get_title()
    assert names_in(panels["Blender"]) == ["+y", "+z", "+x"]


@pytest.mark.parametrize("name", ["axes.png", "axes_mitsuba.png"])
def test_the_pictures_of_the_page_are_small(name):
    content = (DOCS / name).read_bytes()
    width, height = struct.unpack(">II", content[16:24])
    assert width * height > 50_000
    assert len(content) < 60_000
