"""Spherical harmonics of lights up to a degree, as in `kernels.expand_discs`."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights.kernels import expand_discs, harmonic_radiance, icosphere
from envlights.layers.arrays import Array, constant, scan
from envlights.layers.lights import Lights, nine_coefficients, spread_and_flux


def expand_lights(xp: Any, lights: Lights, degree: int) -> Array:
    """Coefficients of the ambient term and of discs: two arrays, (..., order, degree, 6).

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
        # Mean of the Legendre polynomial p over the disc, by its slope.
        factor = xp.where(k > 0, (1 + x) * slope / xp.where(k > 0, k * (k + 1), 1.0), 1.0)
        polynomials = p, ((2 * k + 1) * x * p - k * p_last) / (k + 1)
        slopes = slope, slope_last + (2 * k + 1) * p
        waves = -cosine * back - sine * right, cosine * right - sine * back
        functions = function, over * height[..., None] * function - ratio * last
        return (*functions, *waves, *polynomials, *slopes), (function, cosine, sine, factor)

    state = (orders, orders, one, zero, zero, one, zero, zero)
    functions, cosine, sine, factor = scan(step, state, _recurrence(degree), height)
    # Functions and factors are stacked by degree first, waves by order.
    values = xp.moveaxis(functions * factor[..., None], (-1, 0), (-3, -2))
    waves = xp.stack([cosine, sine], axis=-1)[..., None] * flux[..., None, :]
    waves = xp.reshape(xp.moveaxis(waves, 0, -4), (*flux.shape[:-2], degree + 1, flux.shape[-2], 6))
    nine = nine_coefficients(lights)
    sky = xp.matmul(constant(_nine_to_orders(degree)[:, : nine.shape[-2]], nine), nine)
    direct = xp.matmul(values, waves)
    return xp.reshape(sky, (*nine.shape[:-2], *direct.shape[-3:])), direct


@lru_cache
def _recurrence(degree: int) -> tuple[NDArray[np.float64], ...]:
    """Rows l, 1 / a_(l+1), a_l / a_(l+1), and the functions of order l, by order.

    They are those of ``x P_l = a_(l+1) P_(l+1) + a_l P_(l-1)``, as in the kernels.
    """
    k, m = np.arange(degree + 2)[:, None], np.arange(degree + 1)
    a = np.sqrt(np.maximum(k**2 - m**2, 0) / (4.0 * k**2 - 1))
    over = np.where(m < k[1:], 1 / np.where(m < k[1:], a[1:], 1), 0)
    sectoral = np.sqrt(np.cumprod([0.25 / np.pi, *((2 * m[1:] + 1) / (2 * m[1:]))]))
    return m.astype(float), over, a[:-1] * over, np.diag(np.where(m > 0, 2**0.5, 1) * sectoral)


@lru_cache
def _nine_to_orders(degree: int) -> NDArray[np.float64]:
    """Matrix from nine coefficients of an ambient term to those of each order, from points."""
    towards, _ = icosphere(20)
    points = [expand_discs([each], np.ones((1, 3)), [0.0], 2)[..., ::3] for each in towards]
    values = np.reshape(points, (len(towards), -1))
    matrix = np.linalg.lstsq(harmonic_radiance(towards), values, rcond=None)[0]
    more = (0, degree - 2)
    return np.pad(matrix.reshape(9, 3, 3, 2), ((0, 0), more, more, (0, 0))).reshape(9, -1).T
