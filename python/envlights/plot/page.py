"""The page of a picture: panels on a new figure, or on axes of the caller."""

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
    Unpack = None  # part of annotations, which are not evaluated

_Function = TypeVar("_Function", bound=Callable[..., Figure])

#: Axes of the caller: one for each panel, in reading order.
AnyAxes = Axes | Sequence[Axes] | NDArray[np.object_]
#: Width and height of a figure in inches.
Size = tuple[float, float]

#: Least and largest side of a figure in inches.
_SIDES = 0.5, 100.0


class Placement(TypedDict, total=False):
    """Arguments of every picture: where it is drawn, or the size and ground of its figure."""

    ax: AnyAxes | None
    figsize: Size | None
    dpi: float | None
    transparent: bool | None


def placed_picture(function: _Function) -> _Function:
    """Picture whose signature shows the arguments of its `Placement` by their names."""
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
    """Panels of a picture in reading order, and their figure."""

    figure: Figure
    panels: list[Axes]
    is_own: bool
    """The figure was made for the picture."""

    def entitle(self, text: str) -> None:
        """Write a title above the panels; a figure of the caller keeps its own."""
        if self.is_own:
            entitle_figure(self.figure, text)


def open_page(
    where: Placement,
    mosaic: ArrayLike,
    size: Size,
    **ratios: Any,
) -> Page:
    """Make a figure of `size` with panels like `mosaic`, or take the axes of the caller.

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
    """Mosaic of rows and columns of panels."""
    return np.arange(rows * columns).reshape(rows, columns)


def _new_figure(where: Placement, size: Size) -> Picture:
    """Figure of the size, the resolution and the ground that the caller chose."""
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
    """Axes of the caller, or a refusal."""
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
    """Elements of a sequence or an array in reading order; anything else as one element."""
    if isinstance(given, np.ndarray):
        return list(given.ravel())
    return list(given) if isinstance(given, list | tuple) else [given]


def _root(axes: Axes) -> Figure:
    """Figure of axes, also of those in a subfigure."""
    figure: Any = axes.figure
    while figure is not getattr(figure, "figure", figure):
        figure = figure.figure
    found: Figure = figure
    return found


def _checked_size(size: Any) -> Size | None:
    """Width and height in inches, or a refusal."""
    if size is None:
        return None
    if not isinstance(size, list | tuple | np.ndarray) or len(size) != 2:
        raise EnvLightsError(f"figsize must be (width, height) in inches; got {describe(size)}")
    width, height = (amount("a side of figsize", side, *_SIDES) for side in size)
    return width, height
