"""Angles between vectors."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def degrees_between(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angles in degrees between vectors, (..., 3), of any lengths; exact near 0 and 180."""
    crosses = np.linalg.norm(np.cross(one, other), axis=-1)
    degrees: NDArray[np.float64] = np.rad2deg(np.arctan2(crosses, (one * other).sum(axis=-1)))
    return degrees
