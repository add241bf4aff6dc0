"""Projection of a picture from its shape, or the sentence that lists the candidates."""

from __future__ import annotations

import math
from pathlib import PurePath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._native import EnvLightsError
from envlights.environment.layouts.evidence import has_black_corners, has_equal_halves, is_constant
from envlights.environment.layouts.face_names import face_of_name
from envlights.environment.layouts.faces import crosses_of, is_strip, outside_of_cross
from envlights.environment.layouts.projections import DISCS, SQUARES, candidates

#: Columns by which a panorama may miss twice its height.
_OFF = 2
#: Columns for each column that a panorama may miss.
_COLUMNS_PER_MISS = 100


def samples_of(samples: NDArray[Any]) -> NDArray[Any]:
    """Samples as (height, width, channels) or (6, n, n, channels), or a refusal of other shapes."""
    shape = samples.shape
    if samples.ndim == 3 and shape[0] == 6 and shape[1] == shape[2] > 4:
        return samples[..., None]
    if samples.ndim == 2 and shape[1] <= 4 and _healpix_side(shape[0]):
        raise _healpix(shape[0])
    if samples.ndim == 2:
        return samples[..., None]
    if samples.ndim == 3 or (samples.ndim == 4 and shape[0] == 6 and shape[1] == shape[2]):
        return samples
    if samples.ndim == 1 and _healpix_side(len(samples)):
        raise _healpix(len(samples))
    raise EnvLightsError(
        "a map must have the shape (height, width, 3), (height, width) for grey, or (6, n, n, 3)"
        f" for the faces of a cube; got {shape}"
    )


def _healpix_side(pixels: int) -> int:
    """Parameter n_side of a HEALPix map with a number of pixels; 0 if there is none."""
    side = math.isqrt(pixels // 12)
    return side if side and 12 * side * side == pixels else 0


def _healpix(pixels: int) -> EnvLightsError:
    return EnvLightsError(
        f"{pixels} pixels in one row are a HEALPix map of n_side {_healpix_side(pixels)}, which is"
        " not read; `healpy.cartview(..., return_projected_map=True)` makes a panorama of it"
    )


def is_panorama(height: int, width: int) -> bool:
    """True for a size of 2:1, up to two columns in large pictures."""
    off = abs(width - 2 * height)
    return off == 0 or (off <= _OFF and off * _COLUMNS_PER_MISS <= width)


def projection_of_shape(picture: NDArray[Any], name: str = "") -> str:
    """Value of `projection=`, or a refusal with the candidates.

    Parameters
    ----------
    picture : ndarray, shape (height, width, channels) or (6, n, n, channels)
    name : str
        Name of the file.
    """
    if picture.ndim == 4:
        return "cube"
    height, width = picture.shape[:2]
    if is_panorama(height, width):
        return "equirectangular"
    if is_strip(height, width):
        return "cube"
    crosses = crosses_of(height, width)
    if crosses and is_constant(outside_of_cross(picture, crosses[0])):
        return "cube"
    if height == width and (face := face_of_name(PurePath(name).stem)):
        raise EnvLightsError(
            f"a square picture with the name {face!r} seems to be one face of a cube map; give its"
            " folder or all six files, or projection= if it is a whole map"
        )
    raise EnvLightsError(
        f"an equirectangular map is twice as wide as high; got {width}x{height} pixels, which may"
        f" be {_candidates(picture)}; give the arguments of one of them, or find the lights of a"
        " photograph with `detect_photograph` or `envlights photograph`"
    )


def _candidates(picture: NDArray[Any]) -> str:
    """Projections that the shape and the corners admit, likely ones first."""
    height, width = picture.shape[:2]
    if height != width:
        eyes = " or two panoramas beside each other (eye='left')" if width == 4 * height else ""
        crosses = crosses_of(height, width)
        cube = [f"a cube map (faces={crosses[0]!r})"] if crosses else []
        return ", ".join([*cube, candidates(("planar", "cylinder", "equirectangular")) + eyes])
    if has_black_corners(picture):
        return candidates((*DISCS, "planar"))
    squares = candidates((*SQUARES, "planar"))
    stereo = "two panoramas, one above the other (eye='left')"
    return f"{stereo}, {squares}" if has_equal_halves(picture) else f"{squares}, or {stereo}"


def halves(array: NDArray[Any], *, above: bool) -> tuple[NDArray[Any], NDArray[Any]]:
    """First and second half of a picture, views: upper and lower, or left and right."""
    half = array.shape[0 if above else 1] // 2
    if above:
        return array[:half], array[half : 2 * half]
    return np.asarray(array)[:, :half], np.asarray(array)[:, half : 2 * half]
