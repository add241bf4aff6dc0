"""Floats that are whole numbers from 0 to 255: codes of a picture, kept as floats."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Smallest median of codes: maps made by hand often contain only 0 and 1, and a lamp.
MEDIAN = 4
NOTE = (
    "the samples are whole numbers from 0 to 255, as of codes, but were taken for linear radiance,"
    " because they are floats; give uint8, or a file of 8 bits, to decode them from sRGB"
)


class WholeNumbers:
    """Search for whole numbers in the rows of a file, until some are none."""

    def __init__(self) -> None:
        self._counts: NDArray[np.int64] | None = np.zeros(256, np.int64)

    def add(self, samples: NDArray[Any]) -> WholeNumbers:
        """Add rows of samples."""
        if self._counts is None:
            return self
        step = max(samples.size // 512, 1)
        if _are_whole(samples.reshape(-1)[::step]) and _are_whole(samples):
            codes = samples.astype(np.uint8).ravel()
            self._counts += np.bincount(codes, minlength=256)
        else:
            self._counts = None
        return self

    def notes(self) -> tuple[str, ...]:
        """Note on codes, if all samples may be codes and more than half of them are not small."""
        counts = self._counts
        if counts is None or 2 * counts[MEDIAN:].sum() <= counts.sum():
            return ()
        return (NOTE,)


def _are_whole(samples: NDArray[Any]) -> bool:
    with np.errstate(invalid="ignore"):
        whole = (samples >= 0) & (samples <= 255) & (np.round(samples) == samples)
    return bool(whole.all())
