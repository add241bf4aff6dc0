"""Layout text in a saved picture, so that the file opens again without arguments.

It is a line of the description of the file (`decoders.description`) with the arguments of a
`Layout` and the size of the picture, as JSON.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any

import numpy as np

from envlights._common.check import describe
from envlights._native import EnvLightsError
from envlights.environment.decoders.description import LAYOUT
from envlights.environment.files.hints import Hints
from envlights.environment.layouts import picture_layout as layouts
from envlights.environment.layouts.picture_layout import PictureLayout
from envlights.environment.layouts.projections import (
    PROJECTIONS,
    REGISTRATIONS,
    Layout,
    parameters,
)

_VERSION = 1
#: Entries of the layout text besides the arguments.
_OTHERS = {"version", "size"}
#: Arguments that no saved picture needs.
_UNUSED = {"forward", "eye", "distance"}
#: Arguments that name a projection, and therefore override the layout text of the file.
_NAMING = ("projection", "faces", "mapping")
_WAY_OUT = "give layout=, which replaces the attribute"


def line_of(layout: PictureLayout, size: tuple[int, int], faces: str = "") -> tuple[str, ...]:
    """Layout line for the description of a picture; empty for parts of panoramas.

    Parameters
    ----------
    layout : PictureLayout
        Projection of the picture.
    size : tuple of int
        Rows and columns of the picture in the file.
    faces : str
        Order of the faces of a cube.
    """
    import json  # here, so that `import envlights` does not wait for it

    is_panorama = layout.kind == "equirectangular"
    if is_panorama and not layout.is_whole_sphere:
        return ()
    given = _statement(layout, faces).entries()
    return (LAYOUT + json.dumps({"version": _VERSION, **given, "size": list(size)}),)


def _statement(layout: PictureLayout, faces: str) -> Layout:
    """Projection and arguments of a picture."""
    projection = _projection_of(layout)
    is_fisheye = projection == "fisheye"
    has_samples = "registration" in parameters(projection)
    view = 2 * layout.reach if is_fisheye else layout.field_of_view
    return Layout(
        projection,
        faces=faces or None,
        registration=REGISTRATIONS[layout.border_sampled] if has_samples else None,
        mapping=layout.mapping if is_fisheye else None,
        fov=_degrees(view) if view else None,
        horizon=layout.horizon,
        circle=layout.circle,
        axes=None if layout.axes == PROJECTIONS[projection].axes else layout.axes,
    )


def _projection_of(layout: PictureLayout) -> str:
    """Name of the projection of a picture."""
    if layout.kind != "azimuthal":
        return layout.kind
    is_square, is_whole = layout.height == layout.width, layout.reach == math.pi
    if is_whole and is_square and layout.mapping == "equidistant" and layout.circle is None:
        return "angular"
    is_ball = layout.mapping == "equisolid" and layout.axes == layouts.MIRRORED
    if is_whole and is_ball and (is_square or layout.circle is not None):
        return "mirror-ball"
    return "fisheye"


def _degrees(radians: float) -> float:
    """Angle in degrees, rounded if the rounded value gives the same radians."""
    exact = math.degrees(radians)
    short = round(exact, 9)
    return short if math.radians(short) == radians else exact


def with_statement(layout: Layout, hints: Hints, size: tuple[int, int]) -> tuple[Layout, bool]:
    """Layout completed by the layout text of the file, and True if the text was used.

    It does not count if the user names a projection. Single arguments of the user replace its own.

    Parameters
    ----------
    layout : Layout
        Layout of the user.
    hints : Hints
        Statements of the file.
    size : tuple of int
        Rows and columns of the picture.

    Raises
    ------
    EnvLightsError
        If the statement is damaged, or it describes a picture of another shape.
    """
    if not hints.layout or any(getattr(layout, name) is not None for name in _NAMING):
        return layout, False
    given = layout.entries()
    if "forward" in given:
        given["axes"] = None
    return replace(_layout_of_statement(hints.layout, size), **given), True


def _layout_of_statement(text: str, size: tuple[int, int]) -> Layout:
    """Layout from the text of a file, in pixels of a picture of this size."""
    data = _read(text)
    known = {*_OTHERS, *(field.name for field in fields(Layout))} - _UNUSED
    if data.get("version") != _VERSION or (set(data) - known):
        raise _refusal(f"it is of another version or has unknown entries ({describe(text)})")
    try:
        layout = Layout(**{key: data[key] for key in data if key not in _OTHERS})
        return _in_pixels_of(layout, data["size"], size)
    except EnvLightsError as refusal:
        raise _refusal(str(refusal)) from None
    except (KeyError, OverflowError, TypeError, ValueError):
        raise _refusal(f"a value is missing or of another type in {describe(text)}") from None


def _read(text: str) -> Mapping[str, Any]:
    import json

    try:
        data = json.loads(text)
    except (ValueError, RecursionError):
        raise _refusal(f"{describe(text)} is no JSON") from None
    if not isinstance(data, dict) or "projection" not in data:
        raise _refusal(f"{describe(text)} names no projection")
    return data


def _in_pixels_of(layout: Layout, stated: Any, size: tuple[int, int]) -> Layout:
    """Layout for a picture that was resized in proportion; raises an error otherwise."""
    (rows, columns), (height, width) = stated, size
    if not rows > 0 or not columns > 0 or rows * width != columns * height:
        raise EnvLightsError(
            f"it describes a picture of {columns}x{rows} pixels, and this one of {width}x{height}"
            " was cropped or stretched"
        )
    scale = height / rows
    if layout.horizon is not None:
        layout = replace(layout, horizon=layout.horizon * scale)
    if layout.circle is not None:
        layout = replace(layout, circle=scale * np.asarray(layout.circle))
    return layout


def _refusal(reason: str) -> EnvLightsError:
    return EnvLightsError(
        f"the attribute {LAYOUT[:-1]} of the file cannot be used: {reason}; {_WAY_OUT}"
    )
