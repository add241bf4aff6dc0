"""Spherical harmonics of a map up to order 2, in the conventions of other programs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights.kernels.ambient import turned_ambient

#: Factors of the polynomials 1, y, z, x, xy, yz, 3zz - 1, xz, xx - yy (Ramamoorthi and Hanrahan
#: 2001, equation 3).
FACTORS = np.sqrt(np.array([1 / 4, *[3 / 4] * 3, 15 / 4, 15 / 4, 5 / 16, 15 / 4, 15 / 16]) / np.pi)

#: Irradiance over pi of each harmonic (equation 8).
_LAMBERT = np.array([1.0, *[2 / 3] * 3, *[1 / 4] * 5])

#: Rows: each axis of the program in our frame.
_AXES = {
    "envlights": None,
    "ramamoorthi": None,
    "three": ((0, 0, 1), (0, 1, 0), (-1, 0, 0)),
    "unity": ((-1, 0, 0), (0, 1, 0), (0, 0, 1)),
}
CONVENTIONS = tuple(_AXES)

#: Rows of a map that are summed at once.
_ROWS = 256


def map_harmonics(radiance: NDArray[np.float32], border_sampled: bool) -> NDArray[np.float64]:
    """Integrals of radiance times each of nine real harmonics, (9, 3), exact for square pixels.

    Each harmonic is a sum of products of a function of the polar angle and one of the azimuth,
    whose integrals over a pixel have closed forms.
    """
    height, width, _ = radiance.shape
    columns = np.diff(_along_a_row(_edges(width, 2 * np.pi, border_sampled)), axis=0)
    rows = np.diff(_along_a_column(_edges(height, np.pi, border_sampled)), axis=0)
    sums = np.zeros((6, 5, 3))
    for top in range(0, height, _ROWS):
        block = radiance[top : top + _ROWS]
        by_row = np.einsum("hwc,wk->hkc", block, columns, dtype=np.float64)
        sums += np.einsum("hkc,hj->kjc", by_row, rows[top : top + _ROWS])
    one, cosine, sine, cosine_2, sine_2, both = sums
    sin, sin_cos, sin_2, sin_2_cos, sin_3 = range(5)
    # cos² sin = sin - sin³ of the polar angle.
    z_2, x_2, y_2 = cosine_2[sin_3], sine_2[sin_3], one[sin] - one[sin_3]
    polynomials = [
        one[sin],
        one[sin_cos],
        -cosine[sin_2],
        sine[sin_2],
        sine[sin_2_cos],
        -cosine[sin_2_cos],
        3 * z_2 - one[sin],
        -both[sin_3],
        x_2 - y_2,
    ]
    coefficients: NDArray[np.float64] = FACTORS[:, None] * np.stack(polynomials)
    return coefficients


def in_convention(harmonics: NDArray[np.float64], convention: str) -> NDArray[np.float64]:
    """Coefficients, (9, 3), of our axes as a program has them."""
    axes = _AXES[convention]
    turned = harmonics if axes is None else turned_ambient(harmonics, axes)
    if convention != "unity":
        return turned
    # Unity holds the factors of the polynomials in irradiance over pi.
    factors: NDArray[np.float64] = FACTORS * _LAMBERT
    return factors[:, None] * turned


def _edges(count: int, length: float, border_sampled: bool) -> NDArray[np.float64]:
    """Borders of pixels along an axis, (count + 1,)."""
    if not border_sampled:
        return np.linspace(0, length, count + 1)
    return ((np.arange(count + 1) - 0.5) * length / (count - 1)).clip(0, length)


def _along_a_row(angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Antiderivatives of 1, cos, sin, cos², sin² and sin cos of the azimuth from -z over +x."""
    wave = np.sin(2 * angle) / 4
    columns = (
        *(angle, np.sin(angle), -np.cos(angle)),
        *(angle / 2 + wave, angle / 2 - wave, np.sin(angle) ** 2 / 2),
    )
    return np.stack(columns, axis=1)


def _along_a_column(angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Antiderivatives of sin, sin cos, sin², sin² cos and sin³ of the polar angle."""
    sine, cosine = np.sin(angle), np.cos(angle)
    columns = (
        *(-cosine, sine**2 / 2, angle / 2 - np.sin(2 * angle) / 4),
        *(sine**3 / 3, cosine**3 / 3 - cosine),
    )
    return np.stack(columns, axis=1)
