"""Linear radiance of an array, without samples that are not radiance."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._blocks import blocks, in_blocks
from envlights._check import for_kernels
from envlights._native import EnvLightsError
from envlights._srgb import decode_codes


def linear(array: NDArray[Any], notes: list[str]) -> NDArray[np.float32]:
    """Linear samples of an array; integers are decoded from sRGB, and `notes` says so."""
    if array.dtype.kind == "f":
        # A float64 sample beyond float32 becomes infinite, and `cleaned` replaces it.
        with np.errstate(over="ignore"):
            return for_kernels(array, np.float32)
    notes.append(f"{array.dtype.name} samples were decoded from sRGB")
    return decode_codes(array)


def clean(radiance: NDArray[np.float32], notes: list[str]) -> NDArray[np.float32]:
    """Radiance with NaN, negative and infinite samples replaced, and counted in `notes`."""
    nan, infinite, negative = _native.unusable(radiance)
    if not (nan or infinite or negative):
        return radiance
    largest = _largest_finite(radiance)
    changes = [
        (nan, "NaN", "0"),
        (negative, "negative", "0"),
        (infinite, "infinite", f"{largest:g}"),
    ]
    for count, kind, value in changes:
        if count:
            notes.append(f"{count} {kind} sample{'s' if count > 1 else ''} set to {value}")
    return in_blocks(radiance.shape, lambda rows: _replace(radiance[rows], largest))


def _largest_finite(radiance: NDArray[np.float32]) -> float:
    """Largest finite sample, or 0 if all are negative."""
    parts = (radiance[rows] for rows in blocks(radiance.shape))
    largest = max(part.max(where=np.isfinite(part), initial=-np.inf) for part in parts)
    if largest == -np.inf:
        raise EnvLightsError("the map holds no finite sample; is it damaged?")
    return max(float(largest), 0.0)


def _replace(radiance: NDArray[np.float32], largest: float) -> NDArray[np.float32]:
    """NaN and negative samples as 0, infinite ones as `largest`."""
    finite = np.nan_to_num(radiance, nan=0.0, posinf=largest, neginf=0.0)
    return np.maximum(finite, np.float32(0))
