"""Lights as spherical Gaussian lobes of radiance."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights._common.arrays import seal
from envlights.kernels.angles import SUN_RADIUS

#: Newton iterations for the sharpness of a lobe; 4 suffice for any disc.
_NEWTON_STEPS = 6


class SphericalGaussians(NamedTuple):
    """Lobes of radiance ``amplitude * exp(sharpness * (axis . w - 1))`` in each direction w."""

    axis: NDArray[np.float64]
    """Unit vectors, (n, 3)."""

    sharpness: NDArray[np.float64]
    """Sharpness, larger for narrower lobes, (n,)."""

    amplitude: NDArray[np.float64]
    """Radiance along the axis, linear RGB, (n, 3)."""


def lobes(
    direction: NDArray[np.float64],
    irradiance: NDArray[np.float64],
    angular_radius: NDArray[np.float64],
) -> SphericalGaussians:
    """Lobes with the irradiance and extent of discs; see `Lights.spherical_gaussians`."""
    sharpness, _ = sharpness_of(np, np.sin(np.maximum(angular_radius, SUN_RADIUS) / 2) ** 2)
    at_normal = 2 * np.pi * (sharpness - 1 + np.exp(-sharpness)) / sharpness**2
    amplitude = irradiance / at_normal[:, None]
    return SphericalGaussians(direction, seal(sharpness), seal(amplitude))


def sharpness_of(xp: Any, spread: Any) -> tuple[Any, tuple[Any]]:
    """Sharpness k of lobes with the mean 1 - cos `spread`, below 1, and its derivative.

    It is the inverse of 1 + 1/k - coth k, in the array namespace `xp`.
    """
    # Start near the solution (Banerjee et al. 2005, equation 4.4), and iterate by Newton.
    mean = 1 - spread
    k = mean * (3 - mean**2) / (spread * (1 + mean))
    for _ in range(_NEWTON_STEPS):
        # Compute coth k - 1 = 2 / (e^2k - 1) without cancellation and overflow.
        beyond = 2 * xp.exp(-2 * k) / -xp.expm1(-2 * k)
        slope = 1 / k**2 - beyond * (2 + beyond)
        k = k + (1 / k - beyond - spread) / slope
    return k, (-1 / slope,)
