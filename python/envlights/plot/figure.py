"""A figure, its file, and linear values as colours."""

from __future__ import annotations

import io
import os
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from envlights._native import EnvLightsError
from envlights.io.files import PICTURES, as_path, write_atomically
from envlights.rig import Rig

#: Options that leave the time of drawing out of a file.
_WITHOUT_DATE: dict[str, dict[str, Any]] = {
    "pdf": {"metadata": {"CreationDate": None}},
    "svg": {"metadata": {"Date": None}},
}

#: Colour of the background.
GROUND = "#e4e4e2"


class Picture(Figure):
    """Figure that any notebook shows, with or without `%matplotlib inline`.

    Its background is light grey, which suits light and dark pages, and on which white is visible.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__(layout="constrained", facecolor=GROUND, **options)
        FigureCanvasAgg(self)

    def _repr_png_(self) -> bytes:
        return _draw(self, "png")


def check_is(name: str, value: object, kind: type) -> None:
    """Refuse an argument of another kind, such as the lights of a rig in place of the rig."""
    if not isinstance(value, kind):
        raise EnvLightsError(f"{name} must be {kind.__name__}; got {type(value).__name__}")


def check_are_rigs(values: tuple[object, ...]) -> None:
    """Refuse anything but one or more rigs."""
    others = [type(value).__name__ for value in values if not isinstance(value, Rig)]
    if others or not values:
        seen = others[0] if others else "none"
        raise EnvLightsError(f"rigs must be one rig or more, each an argument; got {seen}")


def hide_frame(axes: Axes) -> None:
    """Remove frame and ticks; invisible ticks would still take time."""
    axes.set(xticks=[], yticks=[])
    axes.axis("off")


def save(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Write a picture as PNG, PDF or SVG; a failure leaves no file."""
    check_is("figure", figure, Figure)
    suffix = as_path(path).suffix.lower()
    if suffix not in PICTURES:
        raise EnvLightsError(f"cannot draw {path}; the suffix must be {', '.join(PICTURES)}")
    # Draw in memory, because Matplotlib cannot close a PDF on a full disk.
    drawn = _draw(figure, suffix[1:])
    write_atomically(path, lambda beside: beside.write_bytes(drawn))


def _draw(figure: Figure, form: str) -> bytes:
    drawn = io.BytesIO()
    # Compress fast: files are 5 % larger, in half the time.
    options: dict[str, Any] = {"png": {"pil_kwargs": {"compress_level": 4}}, **_WITHOUT_DATE}[form]
    # Identifiers in SVG depend on the drawing alone, so that equal drawings give equal files.
    with matplotlib.rc_context({"svg.hashsalt": "envlights"}):
        figure.savefig(drawn, format=form, dpi=100, bbox_inches="tight", **options)
    return drawn.getvalue()
