r"""Spherical harmonics of maps and discs, and their inner products by degree.

Coefficients are those of :math:`Y_{lm} = \bar P_{lm}(\cos\theta)\, e^{i m \phi}`, orthonormal, for
orders m from 0 on: those of negative orders are their conjugates.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

#: Highest degree. Beyond it lie 0.01 % of the light of a point at roughness 0.3271.
DEGREE = 100
#: Least number of nodes in theta, so that pixels of small maps are integrated and not sampled.
_LEAST_NODES = 256
#: Most rows of a map whose harmonics are computed; larger ones are reduced.
MOST_ROWS = 256


def legendre(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Orthonormal associated Legendre functions, (order, degree, n), at heights `x`, (n,).

    The recurrence is ``x P_l = a_(l+1) P_(l+1) + a_l P_(l-1)`` with
    ``a_l^2 = (l^2 - m^2) / (4 l^2 - 1)``.
    """
    orders = np.arange(DEGREE + 1)
    steps = np.sqrt((2 * orders[1:] + 1) / (2 * orders[1:]))
    sectoral = np.cumprod(np.concatenate([[np.sqrt(0.25 / np.pi)], steps]))
    sine = np.sqrt(np.maximum(0, 1 - x * x))
    out = np.zeros((DEGREE + 1, DEGREE + 1, len(x)))
    factor = np.sqrt(
        np.maximum(orders[None] ** 2 - orders[:, None] ** 2, 0) / (4.0 * orders[None] ** 2 - 1)
    )
    for l in range(DEGREE + 1):  # noqa: E741, the degree
        if l > 0:
            below = out[:l, l - 2] * factor[:l, l - 1, None] if l > 1 else 0
            out[:l, l] = (x * out[:l, l - 1] - below) / factor[:l, l, None]
        out[l, l] = sectoral[l] * sine**l
    return out


@lru_cache(maxsize=2)
def _row_integrals(height: int) -> NDArray[np.float64]:
    """Integrals of the Legendre functions over each row, (order, degree, row)."""
    nodes, weights = np.polynomial.legendre.leggauss(max(2, -(-_LEAST_NODES // height)))
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    middle, half = (edges[:-1] + edges[1:]) / 2, (edges[:-1] - edges[1:]) / 2
    out = np.zeros((DEGREE + 1, DEGREE + 1, height))
    for node, weight in zip(nodes, weights, strict=True):
        out += weight * half * legendre(middle + node * half)
    return out


def of_map(radiance: NDArray[np.floating]) -> NDArray[np.complex128]:
    """Coefficients, (order, degree, channel), of cell-centred pixels of constant radiance."""
    height, width, channels = radiance.shape
    orders = np.arange(DEGREE + 1)
    waves = np.fft.rfft(radiance, axis=1)
    # Orders beyond the columns are aliases of lower ones.
    alias = orders % width
    is_mirrored = alias > width // 2
    rows = waves[:, np.where(is_mirrored, width - alias, alias)]
    rows[:, is_mirrored] = rows[:, is_mirrored].conj()
    step = 2 * np.pi / width
    of_cell = step * np.sinc(orders / width) * np.exp(-0.5j * orders * step)
    rows = np.ascontiguousarray((rows * of_cell[:, None]).transpose(1, 0, 2))
    products = _row_integrals(height) @ rows.view(np.float64)
    out: NDArray[np.complex128] = products.view(np.complex128)
    return out.reshape(DEGREE + 1, DEGREE + 1, channels)


def of_discs(
    direction: NDArray[np.float64],
    irradiance: NDArray[np.float64],
    radius: NDArray[np.float64],
) -> NDArray[np.complex128]:
    """Coefficients, (order, degree, 3), of discs of uniform radiance, in closed form."""
    cosine = np.cos(radius)
    flux = 2 * irradiance / (1 + cosine)[:, None]
    functions = legendre(direction[:, 1]) * disc_factors(cosine)
    azimuth = np.arctan2(direction[:, 0], -direction[:, 2])
    turns = np.exp(-1j * np.arange(DEGREE + 1)[:, None] * azimuth)
    out: NDArray[np.complex128] = np.einsum("mln,mn,nc->mlc", functions, turns, flux, optimize=True)
    return out


def disc_factors(cosine: NDArray[np.float64]) -> NDArray[np.float64]:
    """Factor of each degree for discs of unit flux, (degree, n): (1 + x) P_l'(x) / (l (l + 1))."""
    value, last = cosine.copy(), np.ones_like(cosine)
    slope, last_slope = np.ones_like(cosine), np.zeros_like(cosine)
    out = np.ones((DEGREE + 1, len(cosine)))
    for l in range(1, DEGREE + 1):  # noqa: E741, the degree
        out[l] = (1 + cosine) * slope / (l * (l + 1))
        slope, last_slope = last_slope + (2 * l + 1) * value, slope
        value, last = ((2 * l + 1) * cosine * value - l * last) / (l + 1), value
    return out


def products(one: NDArray[np.complex128], other: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Inner product of each degree over all orders and channels, (degree,)."""
    by_order = (one.real * other.real + one.imag * other.imag).sum(axis=2)
    by_degree: NDArray[np.float64] = by_order[0] + 2 * by_order[1:].sum(axis=0)
    return by_degree
