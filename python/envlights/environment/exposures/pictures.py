"""Pictures of a series, checked and read into memory as codes or linear samples."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import describe
from envlights._common.srgb import decode_codes, encode_srgb
from envlights._native import EnvLightsError
from envlights.environment.decoders import raw
from envlights.environment.files.images import read_image

#: Advice at the end of an error message about a series.
_WANTED = "give a list of two files or arrays or more"


@dataclass(eq=False)
class Picture:
    """One exposure of a series."""

    number: int
    """Position in the arguments, from 1."""

    time: float
    """Exposure time."""

    samples: NDArray[np.float32]
    """Codes from 0 to 1, or linear values, (height, width, 3)."""

    is_linear: bool
    """True for linear samples, False for codes of a camera."""

    rings: bool
    """True for 8-bit samples, which may come from a JPEG with ringing."""

    border_sampled: bool
    """True if the outer pixels lie on the seam and the poles."""

    notes: tuple[str, ...]
    """Notes of the reader."""


def series_of(pictures: object) -> list[Any]:
    """Pictures of a series as a list; raises an error for other types."""
    if isinstance(pictures, str | os.PathLike):
        raise EnvLightsError(
            f"exposures must be two pictures or more; got one path; {_WANTED}, or use"
            " `EnvMap.open` for one picture"
        )
    if isinstance(pictures, dict):
        raise EnvLightsError(f"exposures must be in a list; got a dict; {_WANTED}, and their times")
    if pictures is None or not isinstance(pictures, Iterable):
        raise EnvLightsError(
            f"exposures must be two pictures or more; got {describe(pictures)}; {_WANTED}"
        )
    series = list(pictures)
    if len(series) < 2:
        raise EnvLightsError(
            f"exposures must be two pictures or more; got {len(series)}; for one, use `EnvMap`"
        )
    return series


def read(picture: ArrayLike | str | os.PathLike[str], number: int, time: float) -> Picture:
    """Picture of a file or an array."""
    if isinstance(picture, str | os.PathLike):
        found = _of_file(picture, number, time)
    else:
        found = _of_values(picture, number, time)
    if found.is_linear and not np.isfinite(found.samples).all():  # codes are finite
        raise EnvLightsError(
            f"exposure {number} holds samples that are not finite; repair it or leave it out"
        )
    return found


def check_sizes(pictures: list[Picture]) -> None:
    """Raise an error if the pictures differ in size."""
    first = pictures[0]
    for picture in pictures[1:]:
        if picture.samples.shape != first.samples.shape:
            raise EnvLightsError(
                f"exposures must have one size; exposure {first.number} has"
                f" {_size(first)} pixels, exposure {picture.number} has {_size(picture)}; give"
                " pictures of one camera at one size"
            )


def _of_file(path: str | os.PathLike[str], number: int, time: float) -> Picture:
    if raw.is_raw(path):
        return Picture(number, time, raw.read(path), True, False, False, (raw.NOTE,))
    image = read_image(path)
    is_linear = image.clip_level is None
    samples = image.pixels if is_linear else _codes(image.pixels)
    return Picture(
        number, time, samples, is_linear, not is_linear, image.border_sampled, image.notes
    )


def _of_values(values: ArrayLike, number: int, time: float) -> Picture:
    try:
        array = np.asarray(values)
    except ValueError as error:  # lists of several lengths
        raise EnvLightsError(f"exposure {number} must be an array of numbers; {error}") from None
    samples, is_linear = _of_array(array, number)
    return Picture(number, time, samples, is_linear, array.dtype == np.uint8, False, ())


def _of_array(array: NDArray[Any], number: int) -> tuple[NDArray[np.float32], bool]:
    """Samples of an array, and True if they are linear."""
    if array.ndim != 3 or array.shape[2] != 3:
        raise EnvLightsError(
            f"exposure {number} must have the shape (height, width, 3); got {array.shape}"
        )
    if array.dtype.kind == "u" and array.dtype.itemsize <= 2:
        return _codes(decode_codes(array)), False
    if array.dtype.kind != "f":
        raise EnvLightsError(
            f"exposure {number} must be floating point, uint8 or uint16; got {array.dtype}"
        )
    return array.astype(np.float32, copy=False), True


def _codes(linear: NDArray[np.float32]) -> NDArray[np.float32]:
    """Codes of decoded samples, by the sRGB encoding."""
    return encode_srgb(linear).astype(np.float32)


def _size(picture: Picture) -> str:
    height, width, _ = picture.samples.shape
    return f"{width}x{height}"
