"""Spherical harmonics of maps and discs up to degree 100, and their inner products by degree."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights.kernels.harmonics import expand_discs, expand_map

#: Highest degree. Beyond it lie 0.01 % of the light of a point at roughness 0.3271.
DEGREE = 100
#: Most rows of a map whose harmonics are computed; larger ones are reduced.
MOST_ROWS = 256


def of_map(radiance: NDArray[np.floating]) -> NDArray[np.float64]:
    """Coefficients of cell-centred pixels; see `kernels.expand_map`."""
    return expand_map(radiance, DEGREE)


def of_discs(
    direction: NDArray[np.float64],
    irradiance: NDArray[np.float64],
    radius: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Coefficients of discs of uniform radiance."""
    return expand_discs(direction, irradiance, radius, DEGREE)


def products(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.float64]:
    """Inner product of each degree over all orders and channels, (degree,)."""
    by_degree: NDArray[np.float64] = (one * other).sum(axis=(0, 2))
    return by_degree
