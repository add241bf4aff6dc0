r"""Irradiance of lights in closed form, with derivatives that are finite everywhere.

A disc of angular radius a, at the cosine c to the normal, has the irradiance F relative to that at
normal incidence. With :math:`q = c / \sin a` limited to -1 to 1, :math:`s = \sqrt{1 - q^2}`,
:math:`\phi = \mathrm{atan2}(s, -q \cos a)`, :math:`h = \arctan(s \tan a)` and
:math:`g = (s - h \cot a) / \sin^2 a`,

.. math:: \pi F = c \phi + \tan a \, (s - g), \quad
   \pi \, \partial F / \partial c = \phi - \sin \phi \cos \phi, \quad
   \pi \, \partial F / \partial a = 2 g .

The derivatives are Lambert's integral over the rim of the disc; the horizon adds nothing to them.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from envlights import _native
from envlights.layers.arrays import Array, constant, with_derivatives
from envlights.layers.lights import Lights, check_lights, nine_coefficients, unit

#: Arc tangent from 0 to 1 within 2e-8 (Abramowitz and Stegun 1964, 4.4.49), for single precision.
_ARC = (
    *(1.0, -0.3333314528, 0.1999355085, -0.1420889944, 0.1065626393),
    *(-0.0752896400, 0.0429096138, -0.0161657367, 0.0028662257),
)
#: Coefficients of ``(u - atan u) / u^3`` in u^2, exact to rounding for u below 0.2.
_SERIES = tuple((-1) ** k / (2 * k + 3) for k in range(11))


def probe(lights: Lights, normals: Array) -> Array:
    """Exact irradiance of lights, as in `Rig.probe`; derivatives are finite everywhere.

    Normals, (..., k, 3) or (k, 3), are vectors of any length above 0, and the result is linear RGB,
    (..., k, 3). The derivative of a point on the horizon is the mean of both sides.

    Examples
    --------
    >>> import envlights as el
    >>> rig = el.Rig([0.1] * 3, el.Lights([[0, 1, 0]], [[2, 2, 2]], [0.5]), error=0.0)
    >>> probe(el.layers.Lights.of(rig), np.array([[0.0, 1, 0], [1, 0, 0]])).round(3)
    array([[2.314, 2.314, 2.314],
           [0.534, 0.534, 0.534]])
    """
    xp, lights = check_lights(lights)
    normals = unit(xp, normals)
    cosine = xp.matmul(lights.direction, xp.matrix_transpose(normals))
    fraction = with_derivatives(_disc, cosine, lights.angular_radius[..., None])
    x, y, z = normals[..., 0], normals[..., 1], normals[..., 2]
    nine = [xp.ones_like(x), y, z, x, x * y, y * z, 3 * z * z - 1, x * z, x * x - y * y]
    sky = nine_coefficients(lights)
    harmonics = xp.stack(nine, axis=-1) * constant(_native.HARMONIC_FACTORS, normals)
    direct = xp.matmul(xp.matrix_transpose(fraction), lights.irradiance)
    return direct + xp.matmul(harmonics[..., : sky.shape[-2]], sky)


def _disc(xp: Any, c: Array, a: Array) -> tuple[Array, tuple[Array, Array]]:
    """Form factor F of a disc, with derivatives by the cosine and by the radius."""
    eps = float(xp.finfo(c.dtype).eps)
    # Keep sine and cosine of the radius above 0 at both ends of its range.
    sine, cosine = xp.clip(xp.sin(a), eps**2, None), xp.clip(xp.cos(a), eps, None)
    tangent, over = sine / cosine, 1 / (sine * sine)
    q = xp.clip(c / sine, -1.0, 1.0)
    s = xp.sqrt((1 - q) * (1 + q))
    across = q * cosine
    phi, h = _angle(xp, s, -across), _angle(xp, s * sine, cosine)
    by_c = phi + s * across / xp.where(s + abs(across) > 0, s * s + across * across, 1.0)
    # Use a series where g suffers from cancellation.
    u = s * tangent
    series = s * s * s / (cosine * cosine) * _polynomial(_SERIES, xp.where(u < 0.2, u * u, 0.0))
    g = xp.where(u < 0.2, series, (s - h / tangent) * over)
    rim = xp.where(u < 0.2, tangent * (s - g), h * over - s / tangent)
    value = xp.where(abs(c) < sine, (c * phi + rim) / np.pi, xp.clip(c, 0.0, None))
    return value, (by_c / np.pi, 2 / np.pi * g)


def _angle(xp: Any, y: Array, x: Array) -> Array:
    """Angle of (x, y) for y >= 0, avoiding the slow ``atan2`` in single precision."""
    if xp.finfo(x.dtype).bits > 32:
        return xp.atan2(y, x)
    size = abs(x)
    small, large = xp.minimum(size, y), xp.maximum(size, y)
    t = small / xp.where(large > 0, large, 1.0)
    angle = t * _polynomial(_ARC, t * t)
    angle = xp.where(y > size, np.pi / 2 - angle, angle)
    return xp.where(x < 0, np.pi - angle, angle)


def _polynomial(coefficients: tuple[float, ...], x: Array) -> Array:
    out = coefficients[-1]
    for coefficient in coefficients[-2::-1]:
        out = coefficient + x * out
    return out
