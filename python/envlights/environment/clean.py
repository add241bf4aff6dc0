"""Linear radiance without invalid samples.

Infinite samples are light beyond the format, so they lie above all finite ones: at 65504, the
largest half float, if all finite samples are below it, else at twice the largest. A pixel whose
channels are all infinite takes the hue of its finite neighbours. NaN takes the mean of its
neighbours. Negative samples become 0.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights import _native

#: Numbers of NaN, infinite and negative samples, the replacement for infinite samples, and True if
#: a NaN lay in the brightest light.
Cleaned = tuple[int, int, int, float | None, bool]


def clean(
    radiance: NDArray[np.float32], notes: list[str], *, wrap: bool = True
) -> tuple[NDArray[np.float32], float | None]:
    """Radiance without NaN, negative and infinite samples, and the clip level of the infinite ones.

    The outer pixels of a row are neighbours if `wrap` is true, as in a map.
    """
    done = _native.clean(radiance, wrap)
    if done is None:
        return radiance, None
    samples, cleaned = done
    notes += notes_of_cleaning(cleaned)
    return samples, cleaned[3]


def notes_of_cleaning(cleaned: Cleaned) -> list[str]:
    """Notes on samples that were replaced."""
    nan, infinite, negative, level, is_nan_bright = cleaned
    notes = [f"{_samples(negative, 'negative')} set to 0"] if negative else []
    if infinite:
        notes.append(f"{_samples(infinite, 'infinite')} set to {level:g} and counted as clipped")
    if nan:
        where = " in the brightest light" if is_nan_bright else ""
        notes.append(f"{_samples(nan, 'NaN')}{where} set to the mean of the neighbours")
    return notes


def _samples(count: int, kind: str) -> str:
    return f"{count} {kind} sample{'s' if count > 1 else ''}"
