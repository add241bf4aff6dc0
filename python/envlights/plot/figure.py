"""Figures for pictures, and their files."""

from __future__ import annotations

import io
import os
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from envlights._common.check import amount, flag
from envlights._common.files import PICTURES, as_path, write_atomically
from envlights._native import EnvLightsError
from envlights.rigs.rig import Rig

#: Options that omit the creation date from a file.
_WITHOUT_DATE: dict[str, dict[str, Any]] = {
    "pdf": {"metadata": {"CreationDate": None}},
    "svg": {"metadata": {"Date": None}},
}
#: TrueType fonts (Type 42) in PDF and PostScript, which publishers require.
_TYPE_42: Any = {"pdf.fonttype": 42, "ps.fonttype": 42}
#: Smallest and largest resolution in dots per inch, and largest number of pixels.
_DOTS, _MOST_PIXELS = (10.0, 2400.0), 2**28


class Picture(Figure):
    """Figure that every notebook displays, with or without `%matplotlib inline`.

    Colours and fonts are those of the style in which it was drawn. PDF and PostScript get fonts of
    Type 42.
    """

    #: True if the caller chose the size, which files keep; otherwise files are cropped.
    has_chosen_size = False

    def __init__(self, **options: Any) -> None:
        super().__init__(layout="constrained", **options)
        FigureCanvasAgg(self)

    def savefig(self, *arguments: Any, **options: Any) -> None:
        """Save the figure like `matplotlib.figure.Figure.savefig`, with fonts of Type 42."""
        with matplotlib.rc_context(_TYPE_42):
            super().savefig(*arguments, **options)

    def _repr_png_(self) -> bytes:
        return _draw(self, "png", None, None)


def dots(dpi: float, size: tuple[float, float]) -> float:
    """Dots per inch; raises an error for bad values, and for too many pixels."""
    dpi = amount("dpi", dpi, *_DOTS)
    pixels = size[0] * size[1] * dpi**2
    if pixels > _MOST_PIXELS:
        raise EnvLightsError(
            f"{size[0]:g} x {size[1]:g} inches at dpi {dpi:g} are {pixels:.2g} pixels,"
            f" more than {_MOST_PIXELS:.2g}; reduce figsize or dpi"
        )
    return dpi


def check_is(name: str, value: object, kind: type) -> None:
    """Raise an error for an argument of the wrong type, such as lights instead of a rig."""
    if not isinstance(value, kind):
        raise EnvLightsError(f"{name} must be {kind.__name__}; got {type(value).__name__}")


def check_are_rigs(values: tuple[object, ...]) -> None:
    """Raise an error unless one or more rigs are given."""
    others = [type(value).__name__ for value in values if not isinstance(value, Rig)]
    if others or not values:
        seen = others[0] if others else "none"
        raise EnvLightsError(f"rigs must be one rig or more, each an argument; got {seen}")


def hide_frame(axes: Axes) -> None:
    """Remove frame and ticks completely, because invisible ticks take time."""
    axes.set(xticks=[], yticks=[])
    axes.axis("off")


def save(
    figure: Figure,
    path: str | os.PathLike[str],
    *,
    dpi: float | None = None,
    transparent: bool | None = None,
) -> None:
    """Write a picture as PNG, PDF or SVG, with fonts of Type 42; a failure leaves no file.

    A picture that was made with `figsize` has exactly that size in the file; others are cropped to
    what is drawn on them.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        A picture, or any figure, such as one on whose axes pictures were drawn.
    path : path-like
        File to write: ``.png``, ``.pdf`` or ``.svg``.
    dpi : float, optional
        Pixels in an inch. By default ``rcParams["savefig.dpi"]``, which is that of the figure.
    transparent : bool, optional
        Leave the ground out. By default ``rcParams["savefig.transparent"]``.

    Raises
    ------
    EnvLightsError
        If `figure` is none, or the suffix, `dpi` or `transparent` is wrong.

    Examples
    --------
    >>> import envlights as el
    >>> figure = el.plot.map_picture(el.synthetic.hall(32).radiance, figsize=(3.3, 2))
    >>> el.plot.save(figure, "hall.pdf")  # doctest: +SKIP
    """
    check_is("figure", figure, Figure)
    suffix = as_path(path).suffix.lower()
    if suffix not in PICTURES:
        raise EnvLightsError(f"cannot draw {path}; the suffix must be {', '.join(PICTURES)}")
    if dpi is not None:
        width, height = figure.get_size_inches()
        dpi = dots(dpi, (width, height))
    if transparent is not None:
        transparent = flag("transparent", transparent)
    # Draw into memory, because Matplotlib cannot close a PDF on a full disk.
    drawn = _draw(figure, suffix[1:], dpi, transparent)
    write_atomically(path, lambda beside: beside.write_bytes(drawn))


def _draw(figure: Figure, form: str, dpi: float | None, transparent: bool | None) -> bytes:
    drawn = io.BytesIO()
    # Use fast compression: files are 5 % larger, in half the time.
    options: dict[str, Any] = {"png": {"pil_kwargs": {"compress_level": 4}}, **_WITHOUT_DATE}[form]
    if isinstance(figure, Picture) and not figure.has_chosen_size:
        options = {**options, "bbox_inches": "tight"}
    if dpi is not None:
        options = {**options, "dpi": dpi}
    # Fix the hash salt of SVG, so that equal drawings give equal files.
    with matplotlib.rc_context({"svg.hashsalt": "envlights", **_TYPE_42}):
        figure.savefig(drawn, format=form, transparent=transparent, **options)
    return drawn.getvalue()
