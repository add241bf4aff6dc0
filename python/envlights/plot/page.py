"""Panels of a picture, on a new figure or on axes of the caller."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypedDict, TypeVar

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import amount, describe, flag
from envlights._native import EnvLightsError
from envlights.plot.figure import Picture, dots
from envlights.plot.wording import entitle_figure

if TYPE_CHECKING:
    from typing_extensions import Unpack as Unpack
else:
    Unpack = None  # used only in annotations, which are not evaluated

_Function = TypeVar("_Function", bound=Callable[..., Figure])

#: Axes from the caller: one per panel, in reading order.
AnyAxes = Axes | Sequence[Axes] | NDArray[np.object_]
#: Width and height of a figure in inches.
Size = tuple[float, float]

#: Smallest and largest side length of a figure in inches.
_SIDES = 0.5, 100.0


class Placement(TypedDict, total=False):
    """Arguments of all pictures: target axes, or size and background of a new figure."""

    ax: AnyAxes | None
    figsize: Size | None
    dpi: float | None
    transparent: bool | None


def placed_picture(function: _Function) -> _Function:
    """Decorator that shows the arguments of `Placement` in the signature of a picture function."""
    own = inspect.signature(function)
    shared = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=annotation)
        for name, annotation in Placement.__annotations__.items()
    ]
    parameters = [each for each in own.parameters.values() if each.kind is not each.VAR_KEYWORD]
    shown: Any = function
    shown.__signature__ = own.replace(parameters=[*parameters, *shared])
    return function


class Page(NamedTuple):
    """Panels of a picture in reading order, and the figure that contains them."""

    figure: Figure
    panels: list[Axes]
    is_own: bool
    """True if the figure was created for the picture."""

    def entitle(self, text: str) -> None:
        """Write a title above the panels, unless the figure belongs to the caller."""
        if self.is_own:
            entitle_figure(self.figure, text)


def open_page(
    where: Placement,
    mosaic: ArrayLike,
    size: Size,
    **ratios: Any,
) -> Page:
    """Create a figure of `size` with panels arranged as in `mosaic`, or use the caller's axes.

    Equal numbers of the mosaic are one panel; -1 stays empty.
    """
    for name in where.keys() - Placement.__annotations__.keys():
        raise TypeError(f"a picture has no argument {name!r}")
    cells = np.asarray(mosaic)
    count = len(np.unique(cells[cells >= 0]))
    if where.get("ax") is not None:
        panels = _checked_axes(where, count)
        return Page(_root(panels[0]), panels, False)
    figure = _new_figure(where, size)
    drawn: dict[int, Axes] = figure.subplot_mosaic(cells.tolist(), empty_sentinel=-1, **ratios)
    if where.get("transparent"):
        for axes in drawn.values():
            axes.patch.set_alpha(0)
    return Page(figure, [drawn[number] for number in range(count)], True)


def grid(rows: int, columns: int) -> NDArray[np.int64]:
    """Mosaic with this number of rows and columns."""
    return np.arange(rows * columns).reshape(rows, columns)


def _new_figure(where: Placement, size: Size) -> Picture:
    """Figure with the size, resolution and background that the caller chose."""
    sides, dpi, transparent = (
        _checked_size(where.get("figsize")),
        where.get("dpi"),
        where.get("transparent"),
    )
    dpi = dots(matplotlib.rcParams["figure.dpi"] if dpi is None else dpi, sides or size)
    clear: dict[str, Any] = {}
    if transparent is not None and flag("transparent", transparent):
        clear = {"facecolor": "none", "edgecolor": "none"}
    figure = Picture(figsize=sides or size, dpi=dpi, **clear)
    figure.has_chosen_size = sides is not None
    return figure


def _checked_axes(where: Placement, count: int) -> list[Axes]:
    """Axes from the caller; raises an error for other values or another number."""
    for name in ("figsize", "dpi", "transparent"):
        if where.get(name) is not None:
            raise EnvLightsError(f"{name} is for a new figure; with ax, set it on your figure")
    given: Any = where["ax"]
    panels = [given] if isinstance(given, Axes) else _elements(given)
    wrong = [type(each).__name__ for each in panels if not isinstance(each, Axes)]
    if wrong:
        raise EnvLightsError(f"ax must hold axes of Matplotlib; got {wrong[0]}")
    if len(panels) != count:
        needed = "1 axes" if count == 1 else f"{count} axes, one for each panel"
        raise EnvLightsError(f"ax must hold {needed}; got {len(panels)}")
    if len({id(_root(panel)) for panel in panels}) > 1:
        raise EnvLightsError("ax must hold axes of one figure; got those of several")
    return panels


def _elements(given: Any) -> list[Any]:
    """Elements of a sequence or array in reading order; a single element for anything else."""
    if isinstance(given, np.ndarray):
        return list(given.ravel())
    return list(given) if isinstance(given, list | tuple) else [given]


def _root(axes: Axes) -> Figure:
    """Figure that contains the axes, also for axes in a subfigure."""
    figure: Any = axes.figure
    while figure is not getattr(figure, "figure", figure):
        figure = figure.figure
    found: Figure = figure
    return found


def _checked_size(size: Any) -> Size | None:
    """Width and height in inches; raises an error for other values."""
    if size is None:
        return None
    if not isinstance(size, list | tuple | np.ndarray) or len(size) != 2:
        raise EnvLightsError(f"figsize must be (width, height) in inches; got {describe(size)}")
    width, height = (amount("a side of figsize", side, *_SIDES) for side in size)
    return width, height
