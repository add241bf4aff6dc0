"""Linear radiance without samples that are not radiance.

Infinite samples are light beyond the format, so they lie above all finite ones: at 65504, the
largest half float, if all finite samples are below it, else at twice the largest. A pixel whose
channels are all infinite takes the hue of its finite neighbours. NaN takes the mean of its
neighbours. Negative samples become 0.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._native import EnvLightsError

_LARGEST_HALF = 65504.0
#: Largest radiance that the kernels can sum.
_LARGEST = 1e38
#: NaN is in the brightest light if its neighbours reach this fraction of the largest sample.
_BRIGHT = 0.5


def clean(
    radiance: NDArray[np.float32], notes: list[str], *, wrap: bool = True
) -> tuple[NDArray[np.float32], float | None]:
    """Radiance without NaN, negative and infinite samples, and the clip level of infinite ones.

    The outer pixels of a row are neighbours if `wrap` is true, as in a map.
    """
    nan, infinite, negative, finite = _native.unusable(radiance)
    if not (nan or infinite or negative):
        return radiance, None
    if finite is None:
        raise EnvLightsError("the image holds no finite sample; is it damaged?")
    largest = max(finite, 0.0)
    level = _LARGEST_HALF if largest < _LARGEST_HALF else min(2 * largest, _LARGEST)
    level = max(level, largest)
    cleaned, of_nan = _native.clean(radiance, level, wrap)
    if negative:
        notes.append(note_of_negative(negative))
    if infinite:
        notes.append(f"{_samples(infinite, 'infinite')} set to {level:g} and counted as clipped")
    if nan:
        is_bright = of_nan > _BRIGHT * (level if infinite else largest)
        where = " in the brightest light" if is_bright else ""
        notes.append(f"{_samples(nan, 'NaN')}{where} set to the mean of the neighbours")
    return cleaned, level if infinite else None


def note_of_negative(count: int) -> str:
    """Note on negative samples."""
    return f"{_samples(count, 'negative')} set to 0"


def _samples(count: int, kind: str) -> str:
    return f"{count} {kind} sample{'s' if count > 1 else ''}"
