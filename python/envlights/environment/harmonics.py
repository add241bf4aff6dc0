"""Spherical harmonics of a map up to order 2, in the conventions of other programs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights.kernels.ambient import turned_ambient

#: Factors of the polynomials 1, y, z, x, xy, yz, 3zz - 1, xz, xx - yy in irradiance.
FACTORS = np.array(_native.HARMONIC_FACTORS)

#: Rows: each axis of the program in our frame.
_AXES = {
    "envlights": None,
    "ramamoorthi": None,
    "three": ((0, 0, 1), (0, 1, 0), (-1, 0, 0)),
    "unity": ((-1, 0, 0), (0, 1, 0), (0, 0, 1)),
}
CONVENTIONS = tuple(_AXES)


def map_harmonics(radiance: NDArray[np.float32], border_sampled: bool) -> NDArray[np.float64]:
    """Integrals of radiance times each of nine real harmonics, (9, 3), for square pixels."""
    return _native.nine_harmonics(radiance, border_sampled)


def in_convention(harmonics: NDArray[np.float64], convention: str) -> NDArray[np.float64]:
    """Coefficients, (9, 3), of our axes as a program has them."""
    axes = _AXES[convention]
    turned = harmonics if axes is None else turned_ambient(harmonics, axes)
    if convention != "unity":
        return turned
    # Unity holds the factors of the polynomials in irradiance over pi.
    scaled: NDArray[np.float64] = FACTORS[:, None] / np.pi * turned
    return scaled
