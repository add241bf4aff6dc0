"""Our axes in other programs."""

from __future__ import annotations

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes as Panel
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from envlights.export.axes import AXES, Axes
from envlights.export.targets import TARGETS
from envlights.plot.page import Placement, Unpack, open_page, placed_picture

_COLOURS = ("#c0392b", "#1e8449", "#2456a6")
#: Our axes on paper, seen from (1, 1, 1); all three point towards the viewer.
_DRAWN = np.array([[0.85, -0.45], [0.0, 1.0], [-0.85, -0.45]])
_COLUMNS = 6


@placed_picture
def axes_picture(**where: Unpack[Placement]) -> Figure:
    """Draw our axes, with the name of each in the target.

    Arrows are our +x (red), +y (green) and +z (blue, the centre of the map). A dashed
    arrow shows the direction in which the target puts the centre of an unrotated map, if that
    differs.

    Parameters
    ----------
    **where
        `ax`: axes, one for each program; `figsize`, `dpi`, `transparent`: see `envlights.plot`.

    Examples
    --------
    >>> len(axes_picture().axes) == len(AXES)
    True
    """
    titles = {target.name: target.title.partition(",")[0] for target in TARGETS}
    titles["csv"] = "envlights"
    rows = -(-len(AXES) // _COLUMNS)
    cells = np.arange(rows * _COLUMNS)
    cells[len(AXES) :] = -1
    page = open_page(where, cells.reshape(rows, -1), (2.1 * _COLUMNS, 2.5 * rows))
    for panel in page.panels:
        panel.set(xlim=(-1.5, 1.5), ylim=(-0.95, 1.45), aspect="equal")
        panel.set_axis_off()
    for panel, (name, axes) in zip(page.panels, AXES.items(), strict=True):
        _draw(panel, axes)
        hand = "right-handed" if axes.handedness > 0 else "left-handed"
        panel.set_title(f"{titles[name]}\n{hand}", fontsize="small")
    return page.figure


def _draw(panel: Panel, axes: Axes) -> None:
    for column, (drawn, colour) in enumerate(zip(_DRAWN, _COLOURS, strict=True)):
        panel.annotate(
            "", drawn, (0, 0), arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 2}
        )
        label = axis_name(np.array(axes.matrix)[:, column])
        x, y = 1.22 * drawn
        panel.text(x, y, label, color=colour, ha="center", va="center", fontsize="medium")
    if axes.map is not None and axes.map != axes.matrix:
        centre = axes.from_target(np.array(axes.map)[:, 2]) @ _DRAWN
        style = {"arrowstyle": "->", "linestyle": "--", "color": rcParams["text.color"]}
        panel.annotate("", 0.75 * centre, (0, 0), arrowprops=style)
        x, y = 0.9 * centre
        panel.text(x, y, "map", ha="center", va="center", fontsize="small")


def axis_name(direction: ArrayLike) -> str:
    """Name of a direction along an axis, such as "+x"."""
    values = np.asarray(direction)
    axis = int(np.argmax(np.abs(values)))
    return ("+" if values[axis] > 0 else "−") + "xyz"[axis]
