r"""Inner products of lights: their spherical harmonics, and the mean distance between discs.

With :math:`A = \sin^2(a/2)` and B of two discs, p = A + B, and :math:`h = \sin^2(\gamma/2)` of the
angle between the centres, the mean distance is :math:`M = Q - p (1 - Q^2/4 - \rho) / (2 Q)` for the
mean square :math:`Q^2 = 4 h + 2 (p - A B) (1 - 2 h)`, as in the kernels of the fit. Here
:math:`\rho` is a polynomial in :math:`p (1 - h) / (h + p)`, :math:`4 A B / p^2` and p.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebvander
from numpy.polynomial.legendre import legvander
from numpy.typing import NDArray

from envlights.kernels import expand_discs, harmonic_radiance, icosphere
from envlights.layers.arrays import Array, constant, scan
from envlights.layers.lights import Lights, nine_coefficients, spread_and_flux


def expand_lights(xp: Any, lights: Lights, degree: int) -> Array:
    """Coefficients of the ambient term and of discs as two arrays, (..., order, degree, 6).

    The recursion is over degrees. A Legendre function over the sine to the power of its order is a
    polynomial of the height, so there are no poles and no angles.
    """
    right, height, back = (lights.direction[..., axis] for axis in range(3))
    spread, flux = spread_and_flux(xp, lights)
    one, zero, x = xp.ones_like(height), xp.zeros_like(height), 1 - 2 * spread
    orders = one[..., None] * constant(np.zeros(degree + 1), height)

    def step(state: Any, row: Any) -> Any:
        last, function, cosine, sine, p_last, p, slope_last, slope = state
        k, over, ratio, first = row
        function = function + first
        # Compute the mean of the Legendre polynomial over the disc from its derivative.
        factor = xp.where(k > 0, (1 + x) * slope / xp.where(k > 0, k * (k + 1), 1.0), 1.0)
        polynomials = p, ((2 * k + 1) * x * p - k * p_last) / (k + 1)
        slopes = slope, slope_last + (2 * k + 1) * p
        waves = -cosine * back - sine * right, cosine * right - sine * back
        functions = function, over * height[..., None] * function - ratio * last
        return (*functions, *waves, *polynomials, *slopes), (function, cosine, sine, factor)

    state = (orders, orders, one, zero, zero, one, zero, zero)
    functions, cosine, sine, factor = scan(step, state, _recurrence(degree), height)
    # Functions and factors are stacked with the degree first, waves with the order first.
    values = xp.moveaxis(functions * factor[..., None], (-1, 0), (-3, -2))
    waves = xp.stack([cosine, sine], axis=-1)[..., None] * flux[..., None, :]
    waves = xp.reshape(xp.moveaxis(waves, 0, -4), (*flux.shape[:-2], degree + 1, flux.shape[-2], 6))
    nine = nine_coefficients(lights)
    sky = xp.matmul(constant(_nine_to_orders(degree)[:, : nine.shape[-2]], nine), nine)
    direct = xp.matmul(values, waves)
    return xp.reshape(sky, (*nine.shape[:-2], *direct.shape[-3:])), direct


@lru_cache
def _recurrence(degree: int) -> tuple[NDArray[np.float64], ...]:
    """Recurrence coefficients by degree, and the functions whose degree equals the order.

    They are those of ``x P_l = a_(l+1) P_(l+1) + a_l P_(l-1)``, as in the kernels.
    """
    k, m = np.arange(degree + 2)[:, None], np.arange(degree + 1)
    a = np.sqrt(np.maximum(k**2 - m**2, 0) / (4.0 * k**2 - 1))
    over = np.where(m < k[1:], 1 / np.where(m < k[1:], a[1:], 1), 0)
    sectoral = np.sqrt(np.cumprod([0.25 / np.pi, *((2 * m[1:] + 1) / (2 * m[1:]))]))
    return m.astype(float), over, a[:-1] * over, np.diag(np.where(m > 0, 2**0.5, 1) * sectoral)


@lru_cache
def _nine_to_orders(degree: int) -> NDArray[np.float64]:
    """Matrix from nine ambient coefficients to coefficients by order, fitted at points."""
    towards, _ = icosphere(20)
    points = [expand_discs([each], np.ones((1, 3)), [0.0], 2)[..., ::3] for each in towards]
    values = np.reshape(points, (len(towards), -1))
    matrix = np.linalg.lstsq(harmonic_radiance(towards), values, rcond=None)[0]
    more = (0, degree - 2)
    return np.pad(matrix.reshape(9, 3, 3, 2), ((0, 0), more, more, (0, 0))).reshape(9, -1).T


def mean_distances(xp: Any, one: Array, spread: Array, other: Array, other_spread: Array) -> Array:
    """Mean distance of each pair of discs, (..., n, m), from unit vectors and extents."""
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
    """Coefficients of rho, accurate to 1e-3 of the series; 630 coefficients would give 3e-3."""
    orders, nodes, inverse = (14, 6, 8), [], []
    for order in orders:
        x = 0.5 + 0.5 * np.cos(np.pi * (np.arange(2 * order + 4) + 0.5) / (2 * order + 4))
        # Limit small p, for which the series needs more terms and rho is linear.
        nodes.append(np.maximum(x, 6e-3) if order == orders[2] else x)
        inverse.append(np.linalg.pinv(chebvander(2 * nodes[-1] - 1, order)))
    table: NDArray[np.float64] = np.einsum("ai,bj,ck,ijk->abc", *inverse, _rho(*nodes))
    return table


def _rho(w: NDArray[Any], r: NDArray[Any], p: NDArray[Any]) -> Any:
    """Values of rho on a grid, from the Legendre series of the distance."""
    k = np.arange(480)
    # Fade out the last fifth of the terms, so that the sum does not oscillate.
    fade = np.minimum(5 * (1 - k / len(k)), 1)
    series = fade**2 * (2 * fade - 3) * 4 / ((2 * k - 1) * (2 * k + 3))
    half = np.sqrt(1 - r)[:, None]
    discs = 0.5 * p * (1 + half), 0.5 * p * (1 - half)
    for spread in discs:
        # Compute the mean of each polynomial over the disc.
        values = legvander(1 - 2 * spread, len(k))
        means = (values[..., :-2] - values[..., 2:]) / ((4 * k[1:] + 2) * spread[..., None])
        series = series * np.concatenate([values[..., :1], means], axis=-1)
    c = np.clip((w[:, None] * (1 + 2 * p) - p) / (p + w[:, None]), -1, 1)
    mean = np.einsum("bck,ack->abc", series, legvander(c, len(k) - 1))
    square = 2 - 2 * (1 - discs[0]) * (1 - discs[1]) * c[:, None, :]
    return (mean - np.sqrt(square)) * 2 / p * np.sqrt(square) + 1 - 0.25 * square
