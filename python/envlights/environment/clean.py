"""Linear radiance of an array, without samples that are not radiance.

Infinite samples are light beyond the format, so they lie above all finite ones: at 65504, the
largest half float, if all finite samples are below it, else at twice the largest. A pixel whose
channels are all infinite takes the hue of its finite neighbours. NaN takes the mean of its
neighbours. Negative samples become 0.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._common.blocks import blocks
from envlights._common.check import for_kernels
from envlights._common.srgb import decode_codes
from envlights._native import EnvLightsError

_LARGEST_HALF = 65504.0
#: Largest radiance that the kernels can sum.
_LARGEST = 1e38
#: NaN is in the brightest light if its neighbours reach this fraction of the largest sample.
_BRIGHT = 0.5
#: Largest distance in pixels to finite neighbours from which an infinite pixel takes its hue.
_REACH = 64


def linear(array: NDArray[Any], notes: list[str]) -> NDArray[np.float32]:
    """Linear samples of an array; integers are decoded from sRGB, and `notes` says so."""
    if array.dtype.kind == "f":
        # A float64 sample beyond float32 becomes infinite, and `clean` replaces it.
        with np.errstate(over="ignore"):
            return for_kernels(array, np.float32)
    notes.append(f"{array.dtype.name} samples were decoded from sRGB")
    return decode_codes(array)


def clean(
    radiance: NDArray[np.float32], notes: list[str], *, wrap: bool = True
) -> tuple[NDArray[np.float32], float | None]:
    """Radiance without NaN, negative and infinite samples, and the clip level of infinite ones.

    The outer pixels of a row are neighbours if `wrap` is true, as in a map.
    """
    nan, infinite, negative = _native.unusable(radiance)
    if not (nan or infinite or negative):
        return radiance, None
    largest = _largest_finite(radiance)
    level = _LARGEST_HALF if largest < _LARGEST_HALF else min(2 * largest, _LARGEST)
    level = max(level, largest)
    cleaned = radiance.copy()
    cleaned[cleaned < 0] = 0
    if negative:
        notes.append(note_of_negative(negative))
    if infinite:
        _replace_infinite(cleaned, level, wrap)
        notes.append(f"{_samples(infinite, 'infinite')} set to {level:g} and counted as clipped")
    if nan:
        brightest = _replace_nan(cleaned, wrap)
        where = " in the brightest light" if brightest > _BRIGHT * cleaned.max() else ""
        notes.append(f"{_samples(nan, 'NaN')}{where} set to the mean of the neighbours")
    return cleaned, level if infinite else None


def note_of_negative(count: int) -> str:
    """Note on negative samples."""
    return f"{_samples(count, 'negative')} set to 0"


def _samples(count: int, kind: str) -> str:
    return f"{count} {kind} sample{'s' if count > 1 else ''}"


def _largest_finite(radiance: NDArray[np.float32]) -> float:
    """Largest finite sample, or 0 if all are negative."""
    parts = (radiance[rows] for rows in blocks(radiance.shape))
    largest = max(part.max(where=np.isfinite(part), initial=-np.inf) for part in parts)
    if largest == -np.inf:
        raise EnvLightsError("the image holds no finite sample; is it damaged?")
    return max(float(largest), 0.0)


def _neighbours(
    image: NDArray[Any], rows: NDArray[np.intp], columns: NDArray[np.intp], wrap: bool
) -> NDArray[Any]:
    """The eight pixels around each pixel, (n, 8, ...), across the seam if `wrap` is true."""
    height, width = image.shape[:2]
    steps = [(y, x) for y in (-1, 0, 1) for x in (-1, 0, 1) if (y, x) != (0, 0)]

    def column(x: int) -> NDArray[np.intp]:
        return (columns + x) % width if wrap else np.clip(columns + x, 0, width - 1)

    near = [image[np.clip(rows + y, 0, height - 1), column(x)] for y, x in steps]
    return np.stack(near, axis=1)


def _replace_infinite(radiance: NDArray[np.float32], level: float, wrap: bool) -> None:
    """Put infinite samples at `level`, from the border of an infinite region to its middle."""
    is_open: NDArray[np.bool_] = np.all(np.isposinf(radiance), axis=2)
    for _ in range(_REACH):
        rows, columns = np.nonzero(is_open)
        near = _neighbours(radiance, rows, columns, wrap)
        is_finite = np.isfinite(near).all(axis=2, keepdims=True)
        mean = np.where(is_finite, near, 0).sum(axis=1, dtype=np.float64)
        has_hue = mean.max(axis=1, initial=0) > 0
        if not has_hue.any():
            break
        rows, columns, mean = rows[has_hue], columns[has_hue], mean[has_hue]
        radiance[rows, columns] = level * mean / mean.max(axis=1, keepdims=True)
        is_open[rows, columns] = False
    radiance[np.isposinf(radiance)] = level


def _replace_nan(radiance: NDArray[np.float32], wrap: bool) -> float:
    """Put the mean of the finite neighbours into NaN samples, and return the largest mean.

    Samples without such neighbours become 0.
    """
    rows, columns, channels = np.nonzero(np.isnan(radiance))
    near = _neighbours(radiance, rows, columns, wrap)
    with np.errstate(invalid="ignore"):  # of signalling NaN
        near = np.take_along_axis(near, channels[:, None, None], axis=2)[..., 0].astype(np.float64)
    count = np.isfinite(near).sum(axis=1)
    mean = np.nansum(near, axis=1) / np.maximum(count, 1)
    radiance[rows, columns, channels] = mean
    return float(mean.max())
