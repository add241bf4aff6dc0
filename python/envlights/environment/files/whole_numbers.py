"""Floats that are whole numbers of 8 or 16 bits: codes of a picture, kept as floats."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Smallest median of codes: maps made by hand often contain only 0 and 1, and a lamp.
_MEDIAN = 4
#: As a float of 32 bits, because halves end at 65504.
_LARGEST = np.float32(65535)


class WholeNumbers:
    """Search for whole numbers in the rows of a picture, until some are none."""

    def __init__(self) -> None:
        self._is_whole = True
        self._largest = self._count = self._large = 0

    def add(self, samples: NDArray[Any]) -> WholeNumbers:
        """Add rows of samples."""
        step = max(samples.shape[-2] // 64, 1)
        if self._is_whole:
            self._is_whole = _are_whole(samples[..., ::step, ::step, :]) and _are_whole(samples)
        if self._is_whole:
            self._largest = max(self._largest, int(samples.max(initial=0)))
            self._count += samples.size
            self._large += int(np.count_nonzero(samples >= _MEDIAN))
        return self

    def notes(self) -> tuple[str, ...]:
        """Note on codes, if all samples may be codes and more than half of them are not small."""
        if not self._is_whole or 2 * self._large <= self._count:
            return ()
        bits = 8 if self._largest <= 255 else 16
        return (
            f"the samples are whole numbers from 0 to {2**bits - 1}, as of codes, but were taken"
            f" for linear radiance, because they are floats; give uint{bits}, or a file of {bits}"
            " bits, to decode them from sRGB",
        )


def _are_whole(samples: NDArray[Any]) -> bool:
    with np.errstate(invalid="ignore"):
        whole = (samples >= 0) & (samples <= _LARGEST) & (np.round(samples) == samples)
    return bool(whole.all())
