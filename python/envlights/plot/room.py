"""Picture of a lightmap of the synthetic room, and of its parts placed in the room."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from numpy.typing import ArrayLike, NDArray

from envlights._common.srgb import encode_srgb
from envlights._native import EnvLightsError
from envlights.plot.ball import axes_of
from envlights.plot.figure import hide_frame
from envlights.plot.page import Placement, Unpack, grid, open_page, placed_picture
from envlights.plot.wording import entitle
from envlights.synthetic.room import Chart, room_charts

#: View direction; faces that point away from it are not drawn.
_EYE = np.array([0.62, 0.5, 0.6])
#: Number of walls, whose charts come before those of the boxes.
_WALLS = 6
#: Position of a wall's letter, as a fraction of both sides.
_BEFORE_BOXES = 0.88
#: Percentile of the texels that is displayed as white.
_WHITE = 99.0


@placed_picture
def room_picture(direct: ArrayLike, indirect: ArrayLike, **where: Unpack[Placement]) -> Figure:
    """Draw a pair of images of the synthetic room, and the lightmap on its walls.

    Letters name the 16 parts of the lightmap: A to F are the walls, floor and ceiling of the room,
    G to P the sides of its two boxes. The room is seen from above, without the walls in front.

    Parameters
    ----------
    direct : array_like, shape (h, h, 3)
        Direct light, as `synthetic.room` makes it.
    indirect : array_like, shape (H, H, 3)
        Indirect light of the same frame: true, or predicted by a model.
    **where
        `ax`: three axes; `figsize`, `dpi`, `transparent`: see `envlights.plot`.

    Examples
    --------
    >>> import envlights as el
    >>> room = el.synthetic.room(1, width=16)
    >>> figure = room_picture(room.direct[0], room.indirect[0])
    >>> [axes.get_title() for axes in figure.axes]
    ['direct light', 'indirect light', 'the lightmap in the room']
    """
    charts = room_charts()
    side = int(np.sqrt(len(charts)))
    exposed = [_expose("direct", direct, side), _expose("indirect", indirect, side)]
    page = open_page(where, grid(1, 3), (12.5, 4.5))
    on_direct, on_map, on_room = page.panels
    for axes, image, title in (
        (on_direct, exposed[0], "direct light"),
        (on_map, exposed[1], "indirect light"),
    ):
        axes.imshow(image, extent=(0, side, side, 0))
        axes.set(xticks=range(side + 1), yticks=range(side + 1))
        entitle(axes, title)
        axes.grid(color="0.5", lw=0.6)
        axes.tick_params(length=0, labelleft=False, labelbottom=False)
        for number in range(len(charts)):
            row, column = divmod(number, side)
            _draw_letter(axes, number, np.array([column + 0.14, row + 0.18]))
    _draw_room(on_room, exposed[1], charts)
    entitle(on_room, "the lightmap in the room")
    return page.figure


def _expose(name: str, image: ArrayLike, side: int) -> NDArray[np.floating]:
    """8-bit colours of an image of the room; raises an error for another shape."""
    array = np.asarray(image, np.float64)
    if array.ndim != 3 or array.shape[0] != array.shape[1] or array.shape[2] != 3:
        raise EnvLightsError(f"{name} must have the shape (n, n, 3); got {array.shape}")
    if array.shape[0] % side or not array.size:
        raise EnvLightsError(f"{name} must have a multiple of {side} rows; got {array.shape[0]}")
    white = max(float(np.percentile(array, _WHITE)), np.finfo(float).tiny)
    return encode_srgb(array / white)


def _draw_room(axes: Axes, image: NDArray[np.floating], charts: list[Chart]) -> None:
    """Draw the faces that point to the viewer, farthest first."""
    eye = _EYE / np.linalg.norm(_EYE)
    right, up = axes_of(eye)
    side = int(np.sqrt(len(charts)))
    texels = len(image) // side
    steps = np.linspace(0, 1, texels + 1)
    shown = [number for number, chart in enumerate(charts) if chart.normal @ eye > 0]
    middles = [chart.origin + (chart.rows + chart.columns) / 2 for chart in charts]
    # Draw boxes after walls.
    shown.sort(key=lambda number: (number >= _WALLS, middles[number] @ eye))
    for number in shown:
        chart = charts[number]
        row, column = (texels * each for each in divmod(number, side))
        corners = (
            chart.origin + steps[:, None, None] * chart.rows + steps[None, :, None] * chart.columns
        )
        axes.pcolormesh(
            corners @ right,
            corners @ up,
            image[row : row + texels, column : column + texels],
            rasterized=True,
        )
        # Move letters away from the middle of walls, which the boxes cover.
        place = _BEFORE_BOXES if number < _WALLS else 0.5
        at = chart.origin + place * (chart.rows + chart.columns)
        _draw_letter(axes, number, np.array([at @ right, at @ up]))
    axes.set_aspect("equal")
    hide_frame(axes)


def _draw_letter(axes: Axes, number: int, at: NDArray[np.float64]) -> None:
    axes.text(
        at[0],
        at[1],
        chr(ord("A") + number),
        ha="center",
        va="center",
        color="white",
        fontsize="small",
        path_effects=[withStroke(linewidth=2, foreground="black")],
    )
