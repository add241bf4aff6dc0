"""Spherical harmonics of a map up to order 2, in the conventions of other programs."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights.frames import FRAMES
from envlights.kernels.ambient import turned_ambient

#: Factors of the polynomials 1, y, z, x, xy, yz, 3zz - 1, xz, xx - yy in irradiance.
FACTORS = np.array(_native.HARMONIC_FACTORS)

_SAME = None
#: Frame with mirrored x, as in glTF importers of left-handed programs.
_MIRRORED = FRAMES["unity"].matrix
#: Signs of the basis of Babylon.js, which is negative for odd degrees.
_ODD = np.array([1, -1, 1, -1, 1, -1, 1, -1, 1.0])
#: Ratio of irradiance to radiance in each degree, divided by pi.
_LAMBERT = np.array([1, *[2 / 3] * 3, *[1 / 4] * 5])

#: Axes of each program as rows in our frame, and a factor for each coefficient.
_PROGRAMS: dict[str, tuple[Any, Any]] = {
    "envlights": (_SAME, 1.0),
    "ramamoorthi": (_SAME, 1.0),
    "three": (FRAMES["three"].matrix, 1.0),
    # Coefficients include the polynomial factors of irradiance, divided by pi.
    "unity": (_MIRRORED, FACTORS / np.pi),
    "filament": (_SAME, FACTORS / np.pi),
    # Babylon.js multiplies by its basis first, in `SphericalHarmonics.preScaleForRendering`.
    "babylon": (_MIRRORED, _LAMBERT * _ODD),
}
CONVENTIONS = tuple(_PROGRAMS)


def map_harmonics(radiance: NDArray[np.float32], border_sampled: bool) -> NDArray[np.float64]:
    """Integrals of radiance times each of nine real harmonics, (9, 3), for square pixels."""
    return _native.nine_harmonics(radiance, border_sampled)


def in_convention(harmonics: NDArray[np.float64], convention: str) -> NDArray[np.float64]:
    """Coefficients, (9, 3), converted from our axes to the convention of a program."""
    axes, factors = _PROGRAMS[convention]
    turned = harmonics if axes is None else turned_ambient(harmonics, axes)
    scaled: NDArray[np.float64] = np.broadcast_to(factors, 9)[:, None] * turned
    return scaled
