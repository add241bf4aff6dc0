"""Rendering of a sun disc into the pixels of a map."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from envlights.environment.envmap import EnvMap
from envlights.environment.peaks import PixelIntegrals
from envlights.rigs.lights import Lights


def add_disc(env: EnvMap, lights: Lights) -> NDArray[np.float32]:
    r"""Radiance of a map with one light drawn into the pixels that its disc covers.

    The disc is at least one pixel in radius. Pixels on its rim count by their covered part. A small
    linear term in the direction makes :math:`\int L\, \omega\, d\omega` that of the light, so that
    a surface that faces it receives its irradiance exactly, up to single precision. Only these
    pixels are computed, which `Lights.to_map` does not do: a map may have 8192 rows.
    """
    (towards,), (irradiance,) = lights.direction, lights.irradiance
    rows, columns, weight = _weights(env, towards, float(lights.angular_radius[0]))
    radiance = env.radiance.copy()
    radiance[rows, columns] += (weight[:, None] * irradiance).astype(np.float32)
    return radiance


def _weights(
    env: EnvMap, towards: NDArray[np.float64], radius: float
) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.float64]]:
    """Rows and columns of covered pixels, and their radiance for an irradiance of 1."""
    pixel = math.pi / env.height
    radius = max(radius, pixel)
    polar = math.acos(min(max(float(towards[1]), -1.0), 1.0))
    first = max(int((polar - radius) / pixel) - 2, 0)
    last = min(int((polar + radius) / pixel) + 3, env.height)
    rows, columns = map(np.ravel, np.mgrid[first:last, 0 : env.width])
    integrals = PixelIntegrals(env.height, env.width, env.is_border_sampled).of(rows, columns)
    vectors = integrals[:, :3]
    middles = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    # Compute angles from chords, which is exact for small angles.
    angle = 2 * np.arcsin(np.minimum(np.linalg.norm(middles - towards, axis=1) / 2, 1))
    cover = np.clip((radius + pixel / 2 - angle) / pixel, 0, 1)
    used = np.flatnonzero(cover)
    middles, cover = middles[used], cover[used]
    moments = (cover[:, None] * vectors[used]).T @ middles
    tilt = np.linalg.lstsq(moments, towards, rcond=None)[0]
    return rows[used], columns[used], cover * np.maximum(middles @ tilt, 0)
