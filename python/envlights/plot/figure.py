"""A figure, its file, and linear values as colours."""

from __future__ import annotations

import io
import os
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from envlights._native import EnvLightsError
from envlights.io.files import PICTURES, as_path, write_atomically
from envlights.rig import Rig

#: Colour of the ground.
GROUND = "#e4e4e2"


class Picture(Figure):
    """A figure that any notebook shows, with or without the Matplotlib of `%matplotlib inline`.

    Its ground is a light grey, which suits light and dark pages, and on which white shows.
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
    """Refuse what is not one rig or more."""
    others = [type(value).__name__ for value in values if not isinstance(value, Rig)]
    if others or not values:
        seen = others[0] if others else "none"
        raise EnvLightsError(f"rigs must be one rig or more, each an argument; got {seen}")


def hide_frame(axes: Axes) -> None:
    """Leave frame and ticks out; ticks that are only not drawn take their time all the same."""
    axes.set(xticks=[], yticks=[])
    axes.axis("off")


def save(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Write a picture as PNG, PDF or SVG, whole or not at all."""
    check_is("figure", figure, Figure)
    suffix = as_path(path).suffix.lower()
    if suffix not in PICTURES:
        raise EnvLightsError(f"cannot draw {path}; the suffix must be {', '.join(PICTURES)}")
    # Drawn in memory: on a full disk, matplotlib breaks while it closes a PDF.
    drawn = _draw(figure, suffix[1:])
    write_atomically(path, lambda beside: beside.write_bytes(drawn))


def _draw(figure: Figure, form: str) -> bytes:
    drawn = io.BytesIO()
    # Compress fast: files are a twentieth larger, in half the time.
    options: dict[str, Any] = {"pil_kwargs": {"compress_level": 4}} if form == "png" else {}
    figure.savefig(drawn, format=form, dpi=100, bbox_inches="tight", **options)
    return drawn.getvalue()
