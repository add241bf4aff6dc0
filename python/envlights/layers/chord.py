r"""Mean distance between the points of two discs on the unit sphere, as in the kernels of the fit.

With :math:`A = \sin^2(a/2)` and B of the discs, p = A + B, and :math:`h = \sin^2(\gamma/2)` of the
angle between the centres, the mean distance is :math:`M = Q - p (1 - Q^2/4 - \rho) / (2 Q)` for the
mean square :math:`Q^2 = 4 h + 2 (p - A B) (1 - 2 h)`. Here :math:`\rho` is a polynomial in
:math:`p (1 - h) / (h + p)`, :math:`4 A B / p^2` and p, through values of the distance's series.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebvander
from numpy.polynomial.legendre import legvander
from numpy.typing import NDArray

from envlights.layers.arrays import Array, constant


def mean_distances(xp: Any, one: Array, spread: Array, other: Array, other_spread: Array) -> Array:
    """Mean distance of each pair of discs, (..., n, m), from unit vectors and A of both sets."""
    away = one[..., :, None, :] - other[..., None, :, :]
    h = xp.sum(away * away, axis=-1) / 4
    a, b = spread[..., :, None], other_spread[..., None, :]
    p, product = a + b, a * b
    square = 4 * h + 2 * (p - product) * (1 - 2 * h)
    distance = xp.sqrt(square)
    coordinates, table = (p * (1 - h) / (h + p), 4 * product / (p * p), p), _coefficients()
    w, r, scale = map(_chebyshev, (xp,) * 3, coordinates, table.shape)
    pairs = xp.reshape(w[..., :, None] * r[..., None, :], (*h.shape, w.shape[-1] * r.shape[-1]))
    rho = xp.sum(xp.matmul(pairs, constant(table.reshape(-1, table.shape[2]), h)) * scale, axis=-1)
    return distance - 0.5 * p * (1 - 0.25 * square - rho) / distance


def _chebyshev(xp: Any, x: Array, count: int) -> Array:
    """Chebyshev polynomials of x from 0 to 1, (..., count)."""
    values = [xp.ones_like(x), 2 * x - 1]
    while len(values) < count:
        values.append((4 * x - 2) * values[-1] - values[-2])
    return xp.stack(values, axis=-1)


@lru_cache
def _coefficients() -> NDArray[np.float64]:
    """Coefficients of rho, within 1e-3 of the series; with 630 of them it would be 3e-3."""
    orders, nodes, inverse = (14, 6, 8), [], []
    for order in orders:
        x = 0.5 + 0.5 * np.cos(np.pi * (np.arange(2 * order + 4) + 0.5) / (2 * order + 4))
        # At smaller p the series needs more terms, and rho is linear.
        nodes.append(np.maximum(x, 6e-3) if order == orders[2] else x)
        inverse.append(np.linalg.pinv(chebvander(2 * nodes[-1] - 1, order)))
    table: NDArray[np.float64] = np.einsum("ai,bj,ck,ijk->abc", *inverse, _rho(*nodes))
    return table


def _rho(w: NDArray[Any], r: NDArray[Any], p: NDArray[Any]) -> Any:
    """Values of rho on a grid, from the series of the distance in Legendre polynomials."""
    k = np.arange(480)
    # Fade out the last fifth, so that the sum does not oscillate.
    fade = np.minimum(5 * (1 - k / len(k)), 1)
    series = fade**2 * (2 * fade - 3) * 4 / ((2 * k - 1) * (2 * k + 3))
    half = np.sqrt(1 - r)[:, None]
    discs = 0.5 * p * (1 + half), 0.5 * p * (1 - half)
    for spread in discs:
        # Mean of each polynomial over the disc.
        values = legvander(1 - 2 * spread, len(k))
        means = (values[..., :-2] - values[..., 2:]) / ((4 * k[1:] + 2) * spread[..., None])
        series = series * np.concatenate([values[..., :1], means], axis=-1)
    c = np.clip((w[:, None] * (1 + 2 * p) - p) / (p + w[:, None]), -1, 1)
    mean = np.einsum("bck,ack->abc", series, legvander(c, len(k) - 1))
    square = 2 - 2 * (1 - discs[0]) * (1 - discs[1]) * c[:, None, :]
    return (mean - np.sqrt(square)) * 2 / p * np.sqrt(square) + 1 - 0.25 * square
