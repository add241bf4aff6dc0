"""Pixels of a photograph with any aspect ratio, from a file or an array."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._native import EnvLightsError
from envlights.environment.arrays import image_of_array
from envlights.environment.clean import clean
from envlights.environment.colour.choice import ColourArgument
from envlights.environment.decoders.source import AnySource, Source, is_source, named_source
from envlights.environment.envmap import EnvMap
from envlights.environment.files.focal_length import FocalLength, focal_length
from envlights.environment.files.hints import Hints
from envlights.environment.files.images import Image, OpenImage, open_image, whole_image
from envlights.environment.layouts.attribute import with_statement
from envlights.environment.layouts.projections import Layout

#: Path, bytes or file object of a photograph, or its samples.
AnyPhotograph = AnySource | ArrayLike


class PhotographPixels(NamedTuple):
    """Linear radiance of a photograph, with the metadata of its file."""

    radiance: NDArray[np.float32]
    """Linear Rec.709, (height, width, 3)."""

    clip_level: float | None
    """Clip level; None for floating-point samples."""

    focal: FocalLength | None
    """Focal length in the metadata of the file."""

    notes: tuple[str, ...]
    """Notes on conversions and assumptions."""


def photograph_pixels(
    image: Any, colour: ColourArgument | None, part: str | int | None
) -> PhotographPixels:
    """Pixels of an `AnyPhotograph`; `colour` and `part` apply to files only."""
    if isinstance(image, EnvMap):
        raise EnvLightsError(
            "a photograph must be a file or an array; got EnvMap, whose lights `detect` finds"
        )
    if is_source(image):
        return _of_file(named_source(image), colour, part)
    if given := [name for name, value in (("colour", colour), ("part", part)) if value is not None]:
        raise EnvLightsError(f"{', '.join(given)} describe a file; got an array; leave them out")
    read = image_of_array(image, what="a photograph")
    return _clean(read, None, list(read.notes))


def _of_file(
    source: Source, colour: ColourArgument | None, part: str | int | None
) -> PhotographPixels:
    with open_image(source, colour=colour, part=part, any_projection=True) as file:
        _check_plane(file)
        read = whole_image(file)
    height, width, _ = read.pixels.shape
    notes = list(read.notes)
    focal = _of_layout(read.hints, height, width, notes) or focal_length(source, height, width)
    return _clean(read, focal, notes)


def _check_plane(file: OpenImage) -> None:
    """Raise an error if the metadata names a projection other than a pinhole camera."""
    other = file.hints.names_other_projection
    if file.place.crop or other not in ("", "planar"):
        what = "a part of a panorama" if file.place.crop else f"of the projection {other}"
        raise EnvLightsError(
            f"{file.name} is {what}, by its metadata, and no photograph of a pinhole camera; open"
            " it with `EnvMap.open` and use `detect`"
        )


def _of_layout(hints: Hints, height: int, width: int, notes: list[str]) -> FocalLength | None:
    """Focal length by the layout text that `envlights` wrote into a picture."""
    try:
        stated, _ = with_statement(Layout(), hints, (height, width))
    except EnvLightsError as refusal:
        notes.append(str(refusal))
        return None
    if stated.fov is None or stated.projection != "planar":
        return None
    pixels = width / 2 / math.tan(math.radians(stated.fov) / 2)
    return FocalLength(pixels, "its layout attribute")


def _clean(image: Image, focal: FocalLength | None, notes: list[str]) -> PhotographPixels:
    height, width, _ = image.pixels.shape
    if height < 2 or width < 2:
        raise EnvLightsError(f"a photograph needs at least 2x2 pixels; got {width}x{height}")
    radiance, level = clean(image.pixels, notes, wrap=False)
    level = level if image.clip_level is None else image.clip_level
    return PhotographPixels(radiance, level, focal, tuple(notes))
