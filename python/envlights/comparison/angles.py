"""Angles between vectors."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def degrees_between(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angles in degrees between vectors, (..., 3), of any length; accurate near 0 and 180."""
    a, b = np.moveaxis(one, -1, 0), np.moveaxis(other, -1, 0)
    # Do not use `np.cross`, which takes four times as long on the pixels of a map.
    crosses = [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]
    length = np.sqrt(sum(cross * cross for cross in crosses))
    degrees: NDArray[np.float64] = np.rad2deg(np.arctan2(length, (a * b).sum(axis=0)))
    return degrees


#: Ratio to the largest singular value below which others count as 0: if all directions lie within
#: 1e-4 radians of a line, the rotation about the line is undetermined.
_RANK_TOLERANCE = 1e-9


def rotation_degrees(
    before: NDArray[np.float64], after: NDArray[np.float64], weights: NDArray[np.float64]
) -> float | None:
    """Angle in degrees of the rotation that brings `before` closest to `after`, weighted.

    It minimises the weighted sum of squared chords: Wahba's problem (1965), by the singular value
    decomposition of Markley (1988). All directions on one line leave a free rotation about it; the
    result is then the smallest angle. None if all rotations are equally close.

    Parameters
    ----------
    before, after : ndarray, shape (n, 3)
        Unit vectors.
    weights : ndarray, shape (n,)
        Not negative; their sum is 1.
    """
    left, values, right = np.linalg.svd((after * weights[:, None]).T @ before)
    if values[0] <= _RANK_TOLERANCE:
        return None
    handedness = float(np.sign(np.linalg.det(left) * np.linalg.det(right)))
    if values[1] + handedness * values[2] <= _RANK_TOLERANCE * values[0]:
        return float(degrees_between(right[0], left[:, 0]))
    turn = left @ np.diag([1.0, 1.0, handedness]) @ right
    axis = turn[[2, 0, 1], [1, 2, 0]] - turn[[1, 2, 0], [2, 0, 1]]
    return float(np.rad2deg(np.arctan2(np.linalg.norm(axis), np.trace(turn) - 1)))
