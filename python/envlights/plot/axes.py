"""Picture of our axes in other programs."""

from __future__ import annotations

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes as Panel
from matplotlib.figure import Figure

from envlights.export.targets import TARGETS
from envlights.frames import Axes
from envlights.plot.page import Placement, Unpack, open_page, placed_picture

_COLOURS = ("#c0392b", "#1e8449", "#2456a6")
#: Directions of our axes on paper, seen from (1, 1, 1); all three point towards the viewer.
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
    >>> [panel.get_title().partition(chr(10))[0] for panel in axes_picture().axes][:3]
    ['envlights itself', 'glTF 2.0', 'three.js']
    """
    targets = [target for target in TARGETS if target.name != "csv"]  # csv has the axes of JSON
    rows = -(-len(targets) // _COLUMNS)
    cells = np.arange(rows * _COLUMNS)
    cells[len(targets) :] = -1
    page = open_page(where, cells.reshape(rows, -1), (2.1 * _COLUMNS, 2.5 * rows))
    for panel in page.panels:
        panel.set(xlim=(-1.5, 1.5), ylim=(-0.95, 1.45), aspect="equal")
        panel.set_axis_off()
    for panel, target in zip(page.panels, targets, strict=True):
        _draw(panel, target.axes)
        title = target.title.partition(",")[0]
        panel.set_title(f"{title}\n{target.axes.hand}-handed", fontsize="small")
    return page.figure


def _draw(panel: Panel, axes: Axes) -> None:
    for drawn, colour, name in zip(_DRAWN, _COLOURS, axes.names, strict=True):
        panel.annotate(
            "", drawn, (0, 0), arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 2}
        )
        label = name.replace("-", "−")
        x, y = 1.22 * drawn
        panel.text(x, y, label, color=colour, ha="center", va="center", fontsize="medium")
    if axes.map is not None and axes.map != axes.matrix:
        centre = axes.from_target(np.array(axes.map)[:, 2]) @ _DRAWN
        style = {"arrowstyle": "->", "linestyle": "--", "color": rcParams["text.color"]}
        panel.annotate("", 0.75 * centre, (0, 0), arrowprops=style)
        x, y = 0.9 * centre
        panel.text(x, y, "map", ha="center", va="center", fontsize="small")
