"""Arrays of maps as RGB."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._native import EnvLightsError


def map_array(radiance: ArrayLike, notes: list[str]) -> NDArray[Any]:
    """`radiance` as an array (height, 2 * height, 3), or a refusal of other shapes.

    Grey arrays and arrays with alpha are converted like files; `notes` says so.
    """
    try:
        array = np.asarray(radiance)
    except ValueError as error:
        raise EnvLightsError(f"a map must be an array of numbers; {error}") from None
    if array.dtype.kind == "O":
        raise EnvLightsError(f"a map must be an array of numbers; got {type(radiance).__name__}")
    is_coded = array.dtype.kind == "u" and array.dtype.itemsize <= 2  # in either byte order
    if array.dtype.kind != "f" and not is_coded:
        raise EnvLightsError(
            f"a map must be floating point, uint8 or uint16; got the dtype {array.dtype}"
        )
    array = _rgb(array, notes)
    height, width, _ = array.shape
    if width != 2 * height:
        raise EnvLightsError(
            f"an equirectangular map is twice as wide as high; got {width}x{height} pixels"
        )
    if height < 2:
        raise EnvLightsError(f"a map needs at least 4x2 pixels; got {width}x{height}")
    return array


def _rgb(array: NDArray[Any], notes: list[str]) -> NDArray[Any]:
    """Three channels: grey ones repeated, alpha left out."""
    channels = 1 if array.ndim == 2 else array.shape[2] if array.ndim == 3 else 0
    if channels == 3:
        return array
    if channels == 4:
        notes.append("alpha was ignored")
        return array[..., :3]
    if channels == 1:
        notes.append("the only channel was read as grey")
        return np.repeat(array.reshape(*array.shape[:2], 1), 3, axis=2)
    raise EnvLightsError(
        "a map must have the shape (height, width, 3), or (height, width) for grey;"
        f" got {array.shape}"
    )
