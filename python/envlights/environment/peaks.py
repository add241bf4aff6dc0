"""Spread of radiance above a maximum over the surrounding pixels."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from envlights._common.blocks import blocks
from envlights._common.words import percent
from envlights._native import EnvLightsError
from envlights.kernels.image import LUMINANCE
from envlights.kernels.sphere import pixel_directions, pixel_solid_angles

#: Growth factor for the radius of a cap that is too small for its excess.
_GROWTH = 1.25


class PixelIntegrals:
    """Integrals of the direction vector, and of 1, over each pixel."""

    def __init__(self, height: int, width: int, border_sampled: bool) -> None:
        theta = np.pi * _edges(height, border_sampled)
        phi = 2 * np.pi * _edges(width, border_sampled)
        across, up = np.diff(theta / 2 - np.sin(2 * theta) / 4), np.diff(np.sin(theta) ** 2 / 2)
        self._rows = np.stack([across, up, across, -np.diff(np.cos(theta))], axis=1)
        sines, cosines, widths = np.diff(np.sin(phi)), np.diff(np.cos(phi)), np.diff(phi)
        self._columns = np.stack([-cosines, widths, -sines, widths], axis=1)

    def of(self, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> NDArray[np.float64]:
        """Integrals of x, y, z and 1 over the given pixels, (..., 4)."""
        integrals: NDArray[np.float64] = self._rows[rows] * self._columns[columns]
        return integrals

    def of_luminance(self, radiance: NDArray[np.float32]) -> NDArray[np.float64]:
        """Integrals of x, y, z and 1 times the luminance, over the whole map, (4,)."""
        sums = np.zeros(4)
        for rows in blocks(radiance.shape):
            sums += (self._rows[rows] * (radiance[rows] @ LUMINANCE @ self._columns)).sum(axis=0)
        return sums


def float32_at_most(maximum: float) -> np.float32:
    """Largest float32 that does not exceed a maximum."""
    limit = np.float32(maximum)
    return np.nextafter(limit, np.float32(0)) if float(limit) > maximum else limit


def spread_peaks(
    radiance: NDArray[np.float32],
    maximum: float,
    border_sampled: bool,
    coverage: NDArray[np.float32] | None = None,
) -> tuple[NDArray[np.float32], list[str]]:
    """Radiance limited to a maximum, with the flux of each light spread around it, and a note.

    The excess of all pixels in a cap is distributed over the same cap in proportion to the room
    below the maximum, tilted so that its direction stays. The cap grows until that is possible.

    Parameters
    ----------
    radiance : ndarray of float32, shape (height, width, 3)
    maximum : float
        Largest value of a sample.
    border_sampled : bool
        Registration of the map.
    coverage : ndarray of float32, shape (height, width), optional
        Fraction of each pixel; nothing is spread to unseen pixels.
    """
    if not (radiance > maximum).any():
        return radiance, []
    height, width = radiance.shape[:2]
    sphere = _Sphere(height, width, border_sampled, maximum, coverage)
    new = radiance.astype(np.float64)
    _check_mean(new, sphere, maximum)
    moved, farthest = 0.0, 0.0
    largest = new.max(axis=2)
    while largest.max() > maximum * (1 + 1e-9):
        centre = sphere.directions.reshape(-1, 3)[int(largest.argmax())]
        flux, radius, rows = _spread(new, sphere, centre, maximum)
        largest[rows] = new[rows].max(axis=2)
        moved, farthest = moved + flux, max(farthest, radius)
    total = float((radiance * sphere.angles[..., None]).sum(dtype=np.float64))
    note = (
        f"limited to {maximum:g}: {percent(moved / total, 2)} of the flux was moved by up to"
        f" {math.degrees(farthest):.2g} degrees"
    )
    return np.minimum(new.astype(np.float32), float32_at_most(maximum)), [note]


class _Sphere:
    """Directions, solid angles and largest allowed radiance of all pixels."""

    def __init__(
        self,
        height: int,
        width: int,
        border_sampled: bool,
        maximum: float,
        coverage: NDArray[np.float32] | None,
    ) -> None:
        self.directions = pixel_directions(height, width, border_sampled=border_sampled)
        self.angles = pixel_solid_angles(height, width, border_sampled=border_sampled)
        integrals = PixelIntegrals(height, width, border_sampled)
        rows, columns = np.ogrid[:height, :width]
        self.means = integrals.of(rows, columns)[..., :3] / self.angles[..., None]
        share = np.ones(1) if coverage is None else coverage.astype(np.float64)
        self.ceiling = np.broadcast_to(maximum * share, (height, width))
        self.pixel = math.pi / height

    def rows(self, centre: NDArray[np.float64], radius: float) -> slice:
        """Rows that overlap a cap."""
        height = len(self.angles)
        theta = math.acos(float(np.clip(centre[1], -1, 1)))
        first = int((theta - radius) / self.pixel) - 1
        return slice(max(first, 0), min(int((theta + radius) / self.pixel) + 2, height))


def _edges(samples: int, border_sampled: bool) -> NDArray[np.float64]:
    """Edges of the pixels along an axis, from 0 to 1."""
    inner = (np.arange(samples - 1) + (0.5 if border_sampled else 1)) / (
        samples - 1 if border_sampled else samples
    )
    return np.concatenate([[0.0], inner, [1.0]])


def _check_mean(radiance: NDArray[np.float64], sphere: _Sphere, maximum: float) -> None:
    angle = (sphere.ceiling / maximum * sphere.angles).sum() if maximum else sphere.angles.sum()
    mean = (radiance * sphere.angles[..., None]).sum(axis=(0, 1)) / angle
    if mean.max() > maximum:
        raise EnvLightsError(
            f"maximum must be at least the mean radiance of the map, {mean.max():g}; got"
            f" {maximum:g}; scale the map first"
        )


def _spread(
    radiance: NDArray[np.float64], sphere: _Sphere, centre: NDArray[np.float64], maximum: float
) -> tuple[float, float, slice]:
    """Spread the excess around a pixel; return its flux, and the radius and rows of the cap."""
    radius = 1.5 * sphere.pixel
    while True:
        rows = sphere.rows(centre, radius)
        part, angles = radiance[rows], sphere.angles[rows]
        inside = sphere.directions[rows] @ centre >= math.cos(min(radius, math.pi))
        light, angle = part[inside], angles[inside][:, None]
        excess = (np.maximum(light - maximum, 0) * angle).sum(axis=0)
        room = np.maximum(sphere.ceiling[rows][inside][:, None] - light, 0)
        # Channels without excess need no room.
        directions, is_last = sphere.means[rows][inside], radius >= math.pi
        if is_last or (excess <= (room * angle).sum(axis=0)).all():
            levels = [
                _level(
                    light[:, channel], room[:, channel], angle[:, 0], directions, maximum, is_last
                )
                for channel in range(3)
            ]
            if all(level is not None for level in levels):
                part[inside] = np.stack(levels, axis=1)  # type: ignore[arg-type]
                return float(excess.sum()), radius, rows
        centre = _centroid(directions, light, angle, maximum, centre)
        radius *= _GROWTH


def _level(
    light: NDArray[np.float64],
    room: NDArray[np.float64],
    angle: NDArray[np.float64],
    directions: NDArray[np.float64],
    maximum: float,
    is_last: bool,
) -> NDArray[np.float64] | None:
    """Channel without samples above the maximum, whose flux and direction are preserved.

    Each pixel gets a fraction of its room, which is linear in the tangent plane of the excess. None
    if that leaves 0 to 1; in the last cap all pixels get the same fraction instead.
    """
    excess = np.maximum(light - maximum, 0) * angle
    if not excess.any():
        return light
    moment = excess @ directions
    tangents = np.linalg.svd(moment[None])[2][1:]
    basis = np.column_stack([np.ones(len(light)), directions @ tangents.T])
    matrix = (basis * (room * angle)[:, None]).T @ basis
    fraction = basis @ np.linalg.lstsq(matrix, [excess.sum(), 0, 0], rcond=1e-12)[0]
    if fraction.min() < 0 or fraction.max() > 1:
        if not is_last:
            return None
        fraction = np.full(len(light), min(excess.sum() / max((room * angle).sum(), 1e-300), 1.0))
    levelled: NDArray[np.float64] = np.minimum(light, maximum) + fraction * room
    return levelled


def _centroid(
    directions: NDArray[np.float64],
    light: NDArray[np.float64],
    angle: NDArray[np.float64],
    maximum: float,
    centre: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Centroid of the excess in a cap; the cap's centre if there is no excess."""
    weights = (np.maximum(light - maximum, 0) * angle).sum(axis=1)
    vector = weights @ directions
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0 else centre
