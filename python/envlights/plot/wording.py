"""Titles and numbers fitted to the available width, in the fonts of the user's style."""

from __future__ import annotations

from textwrap import fill
from typing import Any

from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties

#: Mean width of a letter relative to the font size.
LETTER = 0.54
#: Points per inch.
_INCH = 72.0
#: Width of axes relative to the font size, below which labels and legend are omitted.
_NARROW = 20.0
#: Largest width of a title relative to its panel.
_OVERHANG = 1.12


def font_size(key: str) -> float:
    """Size in points of a font, by its key in `rcParams`, such as "axes.titlesize"."""
    size: Any = rcParams.get(key)  # type: ignore[call-overload]
    return float(FontProperties(size=size).get_size_in_points())


def entitle_figure(figure: Figure, text: str) -> None:
    """Write a title above all panels, in lines that fit the width of the figure."""
    figure.suptitle(_fit(text, _INCH * figure.get_figwidth(), font_size("figure.titlesize")))


def entitle(axes: Axes, text: str, size: str | None = None) -> None:
    """Write a title above a panel, in lines that fit its width; `size` is relative, as "small"."""
    title = axes.set_title("", fontsize=size)
    title.set_text(_fit(text, _OVERHANG * width_of(axes), float(title.get_fontsize())))


def width_of(axes: Axes) -> float:
    """Width of axes in points, before their figure is laid out."""
    return _INCH * float(axes.get_window_extent().width) / float(axes.figure.dpi)


def is_narrow(axes: Axes) -> bool:
    """True if axes have no room for text beside a picture, in the font of the style."""
    return width_of(axes) < _NARROW * font_size("font.size")


def fits_upright(axes: Axes, text: str) -> bool:
    """True if the label of a colour bar is not longer than the axes are high."""
    height = _INCH * float(axes.get_window_extent().height) / float(axes.figure.dpi)
    return LETTER * font_size("axes.labelsize") * len(text) < height


def _fit(text: str, width: float, size: float) -> str:
    letters = max(int(width / (LETTER * size)), 8)
    return "\n".join(fill(line, letters, break_long_words=False) for line in text.splitlines())


def points_per_unit(axes: Axes, extent: tuple[float, float, float, float]) -> float:
    """Points per unit of axes that will show `extent`, before layout."""
    left, right, bottom, top = extent
    box = axes.get_window_extent()
    pixels = min(box.width / abs(right - left), box.height / abs(top - bottom))
    return _INCH * float(pixels) / float(axes.figure.dpi)
