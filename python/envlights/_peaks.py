"""Radiance above a maximum, spread over the pixels around it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from envlights._native import EnvLightsError
from envlights.kernels.sphere import pixel_directions, pixel_solid_angles

#: Growth of the radius of a cap that is too small for the excess of its pixels.
_GROWTH = 1.25


def spread_peaks(
    radiance: NDArray[np.float32], maximum: float, border_sampled: bool
) -> tuple[NDArray[np.float32], list[str]]:
    """Radiance of at most a maximum, with the flux of each light around it, and a note.

    The excess of all pixels in a cap is distributed over the same cap in proportion to the room
    below the maximum. The cap around a light grows until it has room.

    Parameters
    ----------
    radiance : ndarray of float32, shape (height, width, 3)
    maximum : float
        Largest value of a sample.
    border_sampled : bool
        Registration of the map.
    """
    if not (radiance > maximum).any():
        return radiance, []
    height, width = radiance.shape[:2]
    sphere = _Sphere(height, width, border_sampled)
    new = radiance.astype(np.float64)
    _check_mean(new, sphere, maximum)
    moved, farthest = 0.0, 0.0
    while (over := new.max(axis=2)).max() > maximum * (1 + 1e-9):
        centre = sphere.directions.reshape(-1, 3)[int(over.argmax())]
        flux, radius = _spread(new, sphere, centre, maximum)
        moved, farthest = moved + flux, max(farthest, radius)
    total = float((radiance * sphere.angles[..., None]).sum(dtype=np.float64))
    limit = np.float32(maximum)
    limit = np.nextafter(limit, np.float32(0)) if float(limit) > maximum else limit
    note = (
        f"limited to {maximum:g}: {100 * moved / total:.2g} % of the flux was moved by up to"
        f" {math.degrees(farthest):.2g} degrees"
    )
    return np.minimum(new.astype(np.float32), limit), [note]


class _Sphere:
    """Directions and solid angles of all pixels."""

    def __init__(self, height: int, width: int, border_sampled: bool) -> None:
        self.directions = pixel_directions(height, width, border_sampled=border_sampled)
        self.angles = pixel_solid_angles(height, width, border_sampled=border_sampled)
        self.pixel = math.pi / height

    def rows(self, centre: NDArray[np.float64], radius: float) -> slice:
        """Rows that a cap touches."""
        height = len(self.angles)
        theta = math.acos(float(np.clip(centre[1], -1, 1)))
        first = int((theta - radius) / self.pixel) - 1
        return slice(max(first, 0), min(int((theta + radius) / self.pixel) + 2, height))


def _check_mean(radiance: NDArray[np.float64], sphere: _Sphere, maximum: float) -> None:
    mean = (radiance * sphere.angles[..., None]).sum(axis=(0, 1)) / sphere.angles.sum()
    if mean.max() > maximum:
        raise EnvLightsError(
            f"maximum must be at least the mean radiance of the map, {mean.max():g}; got"
            f" {maximum:g}; scale the map first"
        )


def _spread(
    radiance: NDArray[np.float64], sphere: _Sphere, centre: NDArray[np.float64], maximum: float
) -> tuple[float, float]:
    """Spread the excess around a pixel, and return the moved flux and the radius of its cap."""
    radius = 1.5 * sphere.pixel
    while True:
        rows = sphere.rows(centre, radius)
        part, angles = radiance[rows], sphere.angles[rows]
        inside = sphere.directions[rows] @ centre >= math.cos(min(radius, math.pi))
        light, angle = part[inside], angles[inside][:, None]
        excess = (np.maximum(light - maximum, 0) * angle).sum(axis=0)
        room = (np.maximum(maximum - light, 0) * angle).sum(axis=0)
        # A channel without excess needs no room.
        if radius >= math.pi or (excess <= room).all():
            share = np.divide(excess, room, out=np.zeros(3), where=room > 0).clip(0, 1)
            part[inside] = np.minimum(light, maximum) + share * np.maximum(maximum - light, 0)
            return float(excess.sum()), radius
        centre = _centroid(sphere.directions[rows][inside], light, angle, maximum, centre)
        radius *= _GROWTH


def _centroid(
    directions: NDArray[np.float64],
    light: NDArray[np.float64],
    angle: NDArray[np.float64],
    maximum: float,
    centre: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Centroid of the excess in a cap; its centre if there is none."""
    weights = (np.maximum(light - maximum, 0) * angle).sum(axis=1)
    vector = weights @ directions
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0 else centre
