"""Surfaces at and around a light, in the pixels of a depth map."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights.cards import geometry
from envlights.kernels.sphere import pixel_solid_angles, row_directions
from envlights.placing.reading import Reals


class Pixels(NamedTuple):
    """Some pixels of a depth map."""

    ray: Reals
    """Unit directions, (n, 3)."""

    distance: Reals
    """Distance of the surface, (n,); infinite if unknown."""

    weight: Reals
    """Solid angle, or light, (n,)."""

    @property
    def has_surface(self) -> bool:
        """True if at least half of the weight has a distance."""
        known = np.isfinite(self.distance)
        return bool(self.weight[known].sum() >= 0.5 * max(self.weight.sum(), 1e-300))

    def known(self) -> Pixels:
        """Pixels with a distance."""
        return Pixels(*(each[np.isfinite(self.distance)] for each in self))


class CardPixels(NamedTuple):
    """Pixels of a card in a depth map, and those around it."""

    own: Pixels
    """Bright pixels of the card, weighted by their light."""

    ring: Pixels
    """Surface around the card, weighted by solid angle."""

    rows: slice
    """Rows of the map that hold both."""

    is_covered: NDArray[np.bool_]
    """True for pixels of these rows that the card may touch."""

    def behind(self, distance: Reals, wall: Reals) -> None:
        """Replace the distance of the card by that of the plane around it."""
        ray = row_directions(len(distance), self.rows)[self.is_covered]
        distance[self.rows][self.is_covered] = 1 / np.maximum(ray @ wall, 1e-12)


def pixels_of_card(
    distance: Reals, light: NDArray[np.float32], matrix: Reals, *, is_ellipse: bool
) -> CardPixels:
    """Pixels of a card and around it."""
    size, pixel = geometry.sizes(matrix[None])[0], np.pi / len(distance)
    near = _rows_near(len(distance), matrix, size, pixel)
    ray = row_directions(len(distance), near)
    place = ray @ np.linalg.inv(matrix).T
    with np.errstate(divide="ignore", invalid="ignore"):
        off = 2 * np.abs(place[..., :2] / place[..., 2:] - 0.5)
    is_ahead = place[..., 2] > 0

    def within(extent: Reals) -> NDArray[np.bool_]:
        parts = off / extent
        length = np.hypot(*np.moveaxis(parts, -1, 0)) if is_ellipse else parts.max(axis=-1)
        inside: NDArray[np.bool_] = is_ahead & (length <= 1)
        return inside

    step = pixel / size
    own, covered = within(np.maximum(1, 2.5 * step)), within(1.15 + 1.5 * step)
    ring = within(1.7 + 4 * step) & ~covered
    angle = np.broadcast_to(pixel_solid_angles(*distance.shape)[near], own.shape)
    weight = _bright(light[near][own] * angle[own])
    bright = Pixels(ray[own], distance[near][own], weight)
    return CardPixels(bright, Pixels(ray[ring], distance[near][ring], angle[ring]), near, covered)


def _rows_near(height: int, matrix: Reals, size: Reals, pixel: float) -> slice:
    """Rows of a map that hold the surroundings of a card."""
    theta = np.arccos(np.clip(geometry.unit(geometry.centres(matrix[None]))[0, 1], -1, 1))
    reach = 1.3 * np.hypot(*size) + 6 * pixel
    first, last = (theta + side * reach for side in (-1, 1))
    return slice(max(int(first / pixel), 0), min(int(last / pixel) + 1, height))


def _bright(weight: Reals) -> Reals:
    """Weights without the dim half; equal ones if all are 0."""
    if not weight.any():
        return np.ones(len(weight))
    level = weighted_median(weight, weight)
    return np.where(weight < 0.5 * level, 0, weight)


def weighted_median(values: Reals, weights: Reals) -> float:
    """Value below which half of the weight lies."""
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(total, total[-1] / 2)])


def plane(pixels: Pixels) -> tuple[Reals, float]:
    """Plane q . x = 1 through pixels, robust against a minority of others; and its residual.

    The residual is the median relative distance of the pixels from the plane.
    """
    ray, inverse, weight = pixels.ray, 1 / pixels.distance, pixels.weight
    for _ in range(8):
        weighted = ray * weight[:, None]
        normal, *_ = np.linalg.lstsq(weighted.T @ ray, weighted.T @ inverse, rcond=None)
        residual = np.abs(inverse - ray @ normal)
        scale = max(1.5 * np.median(residual), 1e-9 * np.median(inverse))
        weight = pixels.weight / (1 + (residual / scale) ** 2)
    return normal, float(np.median(residual) / np.median(inverse))


def ball_distance(pixels: Pixels, direction: Reals, radius: float) -> tuple[float, float]:
    """Distance of the centre of a ball of this angular radius from its front; and its spread.

    Along a ray at the angle t from the centre, the front is at
    ``D (cos t - sqrt(sin^2 a - sin^2 t))``.
    """
    cosine = np.clip(pixels.ray @ direction, -1, 1)
    root = np.sqrt(np.maximum(np.sin(radius) ** 2 - (1 - cosine**2), 0))
    centre = pixels.distance / (cosine - root)
    middle = weighted_median(centre, pixels.weight)
    return middle, weighted_median(np.abs(centre - middle), pixels.weight) / middle
