"""Angles between vectors."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def degrees_between(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angles in degrees between vectors, (..., 3), of any lengths; exact near 0 and 180."""
    a, b = np.moveaxis(one, -1, 0), np.moveaxis(other, -1, 0)
    # `np.cross` takes four times as long on the pixels of a map.
    crosses = [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]
    length = np.sqrt(sum(cross * cross for cross in crosses))
    degrees: NDArray[np.float64] = np.rad2deg(np.arctan2(length, (a * b).sum(axis=0)))
    return degrees
