"""Lights as pixels and as spherical Gaussians."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from envlights._common.check import count
from envlights.kernels import harmonic_radiance, pixel_directions, pixel_solid_angles
from envlights.kernels.angles import SUN_RADIUS
from envlights.layers.arrays import Array, constant, with_derivatives
from envlights.layers.lights import Lights, check_lights, nine_coefficients, spread_and_flux
from envlights.rigs.lobes import sharpness_of


def to_map(lights: Lights, height: int) -> Array:
    r"""Pixels of lights, (..., height, 2 * height, 3), differentiable by directions and radii.

    Discs have a soft rim, about a pixel wide. The flux of each light is exact.

    Notes
    -----
    The rim is a logistic function of :math:`\sin^2 (\gamma / 2)` at the angle :math:`\gamma` to the
    light, divided by its sum (Gardner et al. 2019, "Deep Parametric Indoor Lighting Estimation").

    Examples
    --------
    >>> arrays = [[0.6, 0.8, 0.0]], [[3.0, 2.0, 1.0]], [0.0], [0.0, 0.0, 0.0]
    >>> to_map(Lights(*map(np.array, arrays)), 16).shape
    (16, 32, 3)
    """
    xp, lights = check_lights(lights)
    size = count("height", height, least=2), 2 * height
    towards = pixel_directions(*size).reshape(-1, 3)
    solid_angles = constant(pixel_solid_angles(*size).ravel(), lights.direction)
    away = constant(towards, lights.direction) - lights.direction[..., None, :]
    spread, flux = spread_and_flux(xp, lights)
    pixel = np.pi / height
    width = xp.sqrt(lights.angular_radius**2 + pixel**2)
    rim = xp.sin(xp.clip(width, None, np.pi / 2)) * (pixel / 4)
    x = (spread[..., None] - xp.sum(away * away, axis=-1) / 4) / rim[..., None]
    decay = xp.exp(-abs(x))
    inside = xp.where(x > 0, 1.0, decay) / (1 + decay)
    weight = inside / xp.sum(inside * solid_angles, axis=-1, keepdims=True)
    sky = nine_coefficients(lights)
    harmonics = constant(harmonic_radiance(towards)[:, : sky.shape[-2]], sky)
    radiance = xp.matmul(xp.matrix_transpose(weight), flux) + xp.matmul(harmonics, sky)
    return xp.reshape(radiance, (*radiance.shape[:-2], *size, 3))


class Gaussians(NamedTuple):
    """Gaussians ``amplitude * exp(sharpness * (cosine - 1))``, with the fields of kaolin."""

    amplitude: Array
    """Radiance along the axis, linear RGB, (..., n, 3)."""
    direction: Array
    """Unit vectors, (..., n, 3)."""
    sharpness: Array
    """Sharpness, larger for narrower lobes, (..., n)."""


def to_gaussians(lights: Lights) -> Gaussians:
    """Lights as spherical Gaussians, without the ambient term; see `Lights.spherical_gaussians`.

    They are the arguments of kaolin's `SgLightingParameters`. PhySG takes one array,
    ``concat([direction, sharpness[..., None], amplitude], axis=-1)``.

    Examples
    --------
    >>> arrays = [[0.0, 1.0, 0.0]], [[3.0, 3.0, 3.0]], [0.5], [0.0, 0.0, 0.0]
    >>> to_gaussians(Lights(*map(np.array, arrays))).sharpness.round(2)
    array([16.34])
    """
    xp, lights = check_lights(lights)
    radius = xp.clip(lights.angular_radius, SUN_RADIUS, None)
    k = with_derivatives(sharpness_of, xp.sin(radius / 2) ** 2)
    at_normal = 2 * np.pi * (k - 1 + xp.exp(-k)) / (k * k)
    return Gaussians(lights.irradiance / at_normal[..., None], lights.direction, k)
