"""Pixels of a photograph from a file or an array, of any aspect."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _cleaning, _visibility
from envlights._map_array import image_array
from envlights._native import EnvLightsError
from envlights._white import white_of_codes
from envlights.envmap import EnvMap
from envlights.io.focal_length import FocalLength, focal_length
from envlights.io.images import open_image, read_image
from envlights.io.source import AnySource, Source, is_source, named_source

#: Path, bytes or file object of a photograph, or its samples.
AnyPhotograph = AnySource | ArrayLike


class PhotographPixels(NamedTuple):
    """Linear radiance of a photograph, and what its file says."""

    radiance: NDArray[np.float32]
    """Linear Rec.709, (height, width, 3)."""

    white: float | None
    """Clip level; None for floating point."""

    focal: FocalLength | None
    """Focal length of the EXIF."""

    notes: tuple[str, ...]
    """Remarks on conversions and assumptions."""


def photograph_pixels(image: Any) -> PhotographPixels:
    """Pixels of an `AnyPhotograph`, or a refusal."""
    if isinstance(image, EnvMap):
        raise EnvLightsError(
            "a photograph must be a file or an array; got EnvMap, whose lights `detect` finds"
        )
    return _of_file(named_source(image)) if is_source(image) else _of_array(image)


def _of_file(source: Source) -> PhotographPixels:
    with open_image(source) as file:
        if file.place.crop:
            raise EnvLightsError(
                f"{source.name} is a part of a panorama, by its GPano metadata, and no photograph"
                " of a pinhole camera; open it with `EnvMap.open` and use `detect`"
            )
    read = read_image(source)
    height, width, _ = read.pixels.shape
    focal = focal_length(source, height, width)
    return _clean(read.pixels, read.white, focal, list(read.notes))


def _of_array(image: ArrayLike) -> PhotographPixels:
    notes: list[str] = []
    array = image_array(image, notes, "a photograph")
    is_float = array.samples.dtype.kind == "f"
    white = None if is_float else white_of_codes(array.samples, array.seen, notes)
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
