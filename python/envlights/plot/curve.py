"""Picture of the errors of a map's rigs by number of lights."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter
from numpy.typing import NDArray

from envlights._common.check import check_choice, texts
from envlights._native import EnvLightsError
from envlights.fitting.error_curve import ErrorCurve
from envlights.plot.figure import check_is
from envlights.plot.page import Placement, Unpack, open_page, placed_picture

#: Size of markers relative to that of the style.
_MARK = 0.67
#: Line style, marker and label of each error.
_LINES = {
    "probe": ("-", "o", "shading"),
    "shadows": ("--", "s", "shadows"),
    "gloss": (":", "^", "metal"),
    "objective": ("-.", "d", "objective"),
}


@placed_picture
def error_curve(
    curve: ErrorCurve,
    *,
    errors: str | Sequence[str] = ("probe", "shadows"),
    **where: Unpack[Placement],
) -> Figure:
    """Draw errors against the number of lights, with a line style and marker per error.

    Lines and marks differ also without colours. Errors of 0 are left out, because the axis is
    logarithmic.

    Parameters
    ----------
    curve : ErrorCurve
        The result of `envlights.error_curve`.
    errors : str or sequence of str
        One or more of "probe" (shading), "shadows", "gloss" (metal) and "objective" (the error that
        the fits minimise).
    **where
        `ax`, `figsize`, `dpi` and `transparent`; see `envlights.plot`.

    Raises
    ------
    EnvLightsError
        If `curve` is no curve, or an error has another name.

    Examples
    --------
    >>> import envlights as el
    >>> curve = el.error_curve(el.synthetic.hall(32).radiance, lights=[1, 2, 4])
    >>> figure = error_curve(curve, figsize=(3.3, 2))
    >>> [line.get_label() for line in figure.axes[0].lines]
    ['shading', 'shadows']
    """
    check_is("curve", curve, ErrorCurve)
    names = texts("errors", errors)
    for name in names:
        check_choice("errors", name, tuple(_LINES))
    if not names:
        raise EnvLightsError(f"errors must hold at least one of {', '.join(_LINES)}; got none")
    page = open_page(where, [[0]], (5, 3.2))
    (axes,) = page.panels
    order = np.argsort(curve.lights, kind="stable")
    for name in names:
        _draw_line(axes, np.array(curve.lights)[order], np.array(getattr(curve, name))[order], name)
    axes.set(xlabel="lights", ylabel="relative RMS error (%)", yscale="log")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    mark_percents(axes)
    axes.legend()
    return page.figure


def _draw_line(
    axes: Axes, lights: NDArray[np.int64], values: NDArray[np.float64], name: str
) -> None:
    line, mark, label = _LINES[name]
    drawn = np.where(values > 0, 100 * values, np.nan)
    size = _MARK * rcParams["lines.markersize"]
    axes.plot(lights, drawn, ls=line, marker=mark, markersize=size, label=label)


def mark_percents(axes: Axes) -> None:
    """Put percent ticks at 1, 2 and 5 times powers of ten, in plain digits."""
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.grid(which="major", alpha=0.25)
