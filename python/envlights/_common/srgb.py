"""Transfer function of sRGB (IEC 61966-2-1), its inverse, and table look-up of codes.

NumPy computes it, because compiled powers differ in the last place, which would change pictures.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native


def encode_srgb(linear: NDArray[np.floating]) -> NDArray[np.floating]:
    """Codes from 0 to 1 by the sRGB curve, for linear values clipped to 0 .. 1."""
    linear = np.clip(linear, 0, 1)
    coded = 1.055 * linear ** (1 / 2.4) - 0.055
    clipped: NDArray[np.floating] = np.where(linear <= 0.0031308, 12.92 * linear, coded).clip(0, 1)
    return clipped


def linear_of(coded: ArrayLike) -> NDArray[np.float64]:
    """Linear values of sRGB codes in 0 .. 1, in double precision."""
    coded = np.asarray(coded, dtype=np.float64)
    return np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)


def decode_srgb(coded: ArrayLike) -> NDArray[np.float32]:
    """Linear values of sRGB codes in 0 .. 1."""
    return linear_of(coded).astype(np.float32)


def code_step(linear: NDArray[np.floating]) -> NDArray[np.float64]:
    """Derivative of linear values with respect to their sRGB codes."""
    power = np.maximum(linear, 0.0031308).astype(np.float64) ** (1 - 1 / 2.4)
    return np.where(linear <= 0.0031308, 1 / 12.92, 2.4 / 1.055 * power)


def decode_codes(codes: NDArray[Any]) -> NDArray[np.float32]:
    """Linear values of 8-bit or 16-bit sRGB codes, (h, w, 3); the largest code is 1."""
    return look_up(codes, _values(8 * codes.dtype.itemsize))


@cache
def _values(bits: int) -> NDArray[np.float32]:
    codes = np.arange(1 << bits)
    return decode_srgb(codes / codes[-1])


def look_up(
    codes: NDArray[Any], table: NDArray[np.float32], values: NDArray[np.float32] | None = None
) -> NDArray[np.float32]:
    """Table values of 8-bit or 16-bit codes, (height, width, channels), in `values` if given.

    `table` holds the value of each code, (n,), or (channels, n) with one row for each channel.
    """
    tables = np.ascontiguousarray(np.atleast_2d(table))
    values = np.empty(codes.shape, np.float32) if values is None else values
    if codes.dtype.itemsize == 1:
        _native.decode_8(np.ascontiguousarray(codes, dtype=np.uint8), tables, values)
    else:
        _native.decode_16(np.ascontiguousarray(codes, dtype=np.uint16), tables, values)
    return values
