"""Pixels of a photograph from a file or an array, of any aspect."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _cleaning, _visibility
from envlights._map_array import image_array
from envlights._native import EnvLightsError
from envlights._white import clip_level_of_codes
from envlights.envmap import EnvMap
from envlights.io.colour import ColourArgument
from envlights.io.focal_length import FocalLength, focal_length
from envlights.io.hints import Hints
from envlights.io.images import OpenImage, open_image, read_image
from envlights.io.source import AnySource, Source, is_source, named_source
from envlights.layouts.attribute import with_statement
from envlights.layouts.records import NO_ARGUMENTS

#: Path, bytes or file object of a photograph, or its samples.
AnyPhotograph = AnySource | ArrayLike


class PhotographPixels(NamedTuple):
    """Linear radiance of a photograph, and what its file says."""

    radiance: NDArray[np.float32]
    """Linear Rec.709, (height, width, 3)."""

    white: float | None
    """Clip level; None for floating point."""

    focal: FocalLength | None
    """Focal length that the file states."""

    notes: tuple[str, ...]
    """Remarks on conversions and assumptions."""


def photograph_pixels(
    image: Any, colour: ColourArgument | None, part: str | int | None
) -> PhotographPixels:
    """Pixels of an `AnyPhotograph`, or a refusal; `colour` and `part` describe a file."""
    if isinstance(image, EnvMap):
        raise EnvLightsError(
            "a photograph must be a file or an array; got EnvMap, whose lights `detect` finds"
        )
    if is_source(image):
        return _of_file(named_source(image), colour, part)
    if given := [name for name, value in (("colour", colour), ("part", part)) if value is not None]:
        raise EnvLightsError(f"{', '.join(given)} describe a file; got an array; leave them out")
    return _of_array(image)


def _of_file(
    source: Source, colour: ColourArgument | None, part: str | int | None
) -> PhotographPixels:
    options: dict[str, Any] = {"colour": colour, "part": part, "any_projection": True}
    with open_image(source, **options) as file:
        _check_plane(file)
    read = read_image(source, **options)
    height, width, _ = read.pixels.shape
    notes = list(read.notes)
    focal = _of_layout(read.hints, height, width, notes) or focal_length(source, height, width)
    return _clean(read.pixels, read.white, focal, notes)


def _check_plane(file: OpenImage) -> None:
    """Refuse a picture whose metadata name a projection other than that of a pinhole camera."""
    other = file.hints.names_other_projection
    if file.place.crop or other not in ("", "planar"):
        what = "a part of a panorama" if file.place.crop else f"of the projection {other}"
        raise EnvLightsError(
            f"{file.name} is {what}, by its metadata, and no photograph of a pinhole camera; open"
            " it with `EnvMap.open` and use `detect`"
        )


def _of_layout(hints: Hints, height: int, width: int, notes: list[str]) -> FocalLength | None:
    """Focal length of a picture of our own, by its statement on the layout."""
    try:
        stated, _ = with_statement(NO_ARGUMENTS, hints, (height, width))
    except EnvLightsError as refusal:
        notes.append(str(refusal))
        return None
    if stated.fov is None or stated.projection != "planar":
        return None
    pixels = width / 2 / math.tan(math.radians(stated.fov) / 2)
    return FocalLength(pixels, "its layout attribute")


def _of_array(image: ArrayLike) -> PhotographPixels:
    notes: list[str] = []
    array = image_array(image, notes, "a photograph")
    is_float = array.samples.dtype.kind == "f"
    white = None if is_float else clip_level_of_codes(array.samples, array.seen, notes)
    linear = _cleaning.linear(array.samples, notes)
    if array.seen is not None:
        linear = _visibility.multiply_by_share(linear, array.seen)
    return _clean(linear, white, None, notes)


def _clean(
    linear: NDArray[np.float32], white: float | None, focal: FocalLength | None, notes: list[str]
) -> PhotographPixels:
    height, width, _ = linear.shape
    if height < 2 or width < 2:
        raise EnvLightsError(f"a photograph needs at least 2x2 pixels; got {width}x{height}")
    radiance, level = _cleaning.clean(linear, notes, wrap=False)
    return PhotographPixels(radiance, level if white is None else white, focal, tuple(notes))
