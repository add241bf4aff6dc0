"""Position of a light card, by the depth of its own pixels and of the surface around it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights.cards import Cards, geometry
from envlights.kernels.sphere import pixel_solid_angles, row_directions
from envlights.placing.placed_light import PlacedLight
from envlights.placing.planes import Reals

#: Distance of a lamp in front of the plane around it, relative to that of the plane, from which it
#: hangs: without it, panels in noise of 5 % become spheres, which cost 8 % at 2 m.
_HANGING = 0.04
#: Pixels of a hanging rectangle from which its own depth has a plane; smaller ones are spheres.
_LEAST_PIXELS = 100


class _Pixels(NamedTuple):
    """Pixels of a depth map: unit directions (n, 3), distance (n,), and weight (n,)."""

    ray: Reals
    distance: Reals
    weight: Reals


def place_cards(
    cards: Cards, distance: Reals, light: NDArray[np.float32]
) -> tuple[tuple[PlacedLight, ...], Reals]:
    """Lights of cards with their positions, and the distance of the surfaces without them.

    Parameters
    ----------
    cards : Cards
    distance : ndarray, shape (height, 2 * height)
        Distance along the ray of each pixel, infinite if unknown.
    light : ndarray, shape (height, 2 * height)
        Luminance of the cards alone.
    """
    behind = distance.copy()
    lights = [_place_card(cards, row, distance, light, behind) for row in range(len(cards))]
    return tuple(lights), behind


def _place_card(
    cards: Cards, row: int, distance: Reals, light: NDArray[np.float32], behind: Reals
) -> PlacedLight:
    """Card as a sphere, as a plane, or as a sun where there is no surface around it."""
    near = _rows_near(cards.matrix[row], len(distance))
    ray = row_directions(len(distance), near)
    own, covered, ring = _regions(cards, row, ray, np.pi / len(distance))
    angle = np.broadcast_to(pixel_solid_angles(*distance.shape)[near], own.shape)
    around = _Pixels(ray[ring], distance[near][ring], angle[ring])
    plane = _plane(around) if _has_surface(around) else None
    if plane is not None:  # the surface behind the light
        behind[near][covered] = 1 / np.maximum(ray[covered] @ plane[0], 1e-12)
    lamp = _Pixels(ray[own], distance[near][own], _bright(light[near][own] * angle[own]))
    if not _has_surface(lamp):  # a window, in the wall around it
        return on_plane(cards, row, *plane) if plane else infinite(cards, row)
    lamp = _Pixels(*(each[np.isfinite(lamp.distance)] for each in lamp))
    if plane and _median(lamp.distance * (lamp.ray @ plane[0]), lamp.weight) > 1 - _HANGING:
        return on_plane(cards, row, *plane)
    if not _is_ellipse(cards, row) and len(lamp.distance) >= _LEAST_PIXELS:
        return on_plane(cards, row, *_plane(lamp))
    return sphere(cards, row, *_globe(lamp, cards.direction[row], cards.angular_radius[row]))


def _is_ellipse(cards: Cards, row: int) -> bool:
    return cards.shape[row] not in ("rectangle", "tube")


def _rows_near(matrix: Reals, height: int) -> slice:
    """Rows of a map that hold a card and its surroundings."""
    theta = np.arccos(np.clip(geometry.unit(geometry.centres(matrix[None]))[0, 1], -1, 1))
    reach = 1.3 * np.hypot(*geometry.sizes(matrix[None])[0]) + 6 * np.pi / height
    first, last = ((theta + side * reach) * height / np.pi for side in (-1, 1))
    return slice(max(int(first), 0), min(int(last) + 1, height))


def _regions(cards: Cards, row: int, ray: Reals, pixel: float) -> list[NDArray[np.bool_]]:
    """Pixels of a card, those that it may touch, and those around it."""
    place = ray @ np.linalg.inv(cards.matrix[row]).T
    with np.errstate(divide="ignore", invalid="ignore"):
        off = 2 * np.abs(place[..., :2] / place[..., 2:] - 0.5)
    step = pixel / cards.size[row]
    inside = []
    for extent in (np.maximum(1, 2.5 * step), 1.15 + 1.5 * step, 1.7 + 4 * step):
        parts = off / extent
        length = np.hypot(*np.moveaxis(parts, -1, 0)) if _is_ellipse(cards, row) else parts.max(-1)
        inside.append((place[..., 2] > 0) & (length <= 1))
    own, covered, wide = inside
    return [own, covered, wide & ~covered]


def _has_surface(pixels: _Pixels) -> bool:
    """True if at least half of the weight has a distance."""
    known = np.isfinite(pixels.distance)
    return bool(known.sum() >= 3 and pixels.weight[known].sum() >= 0.5 * pixels.weight.sum())


def _bright(weight: Reals) -> Reals:
    """Weights without the dim half; equal ones if all are 0."""
    if not weight.any():
        return np.ones(len(weight))
    return np.where(weight < 0.5 * _median(weight, weight), 0, weight)


def _median(values: Reals, weights: Reals) -> float:
    """Value below which half of the weight lies."""
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(total, total[-1] / 2)])


def _plane(pixels: _Pixels) -> tuple[Reals, float]:
    """Plane q . x = 1, robust against a minority of pixels, and their median relative distance."""
    ray, distance, weight = (each[np.isfinite(pixels.distance)] for each in pixels)
    now: Reals = weight
    for _ in range(8):
        weighted = ray * now[:, None]
        normal, *_ = np.linalg.lstsq(weighted.T @ ray, weighted.T @ (1 / distance), rcond=None)
        residual = np.abs(distance * (ray @ normal) - 1)
        now = np.divide(weight, 1 + (residual / max(1.5 * np.median(residual), 1e-9)) ** 2)
    return normal.astype(float), float(np.median(residual))


def _globe(pixels: _Pixels, direction: Reals, radius: float) -> tuple[float, float]:
    """Distance of the centre of a ball of this angular radius by its front, and its spread.

    Along a ray at the angle t from the centre, the front is at
    ``D (cos t - sqrt(sin^2 a - sin^2 t))``.
    """
    cosine = np.clip(pixels.ray @ direction, -1, 1)
    root = np.sqrt(np.maximum(np.sin(radius) ** 2 - (1 - cosine**2), 0))
    centre = pixels.distance / (cosine - root)
    middle = _median(centre, pixels.weight)
    return middle, _median(np.abs(centre - middle), pixels.weight) / middle


def on_plane(cards: Cards, row: int, plane: Reals, residual: float) -> PlacedLight:
    """Light in a plane q . x = 1; it faces the camera if the plane is too oblique."""
    matrix, direction = cards.matrix[row], cards.direction[row]
    corners = geometry.corners(matrix[None])[0] @ plane
    if (corners > 0.2 * corners.max()).all():
        matrix = geometry.tilt(matrix, geometry.unit(plane))
        if not _is_ellipse(cards, row):  # all programs have rectangles, few have sheared ones
            matrix = geometry.nearest_rectangle(matrix)
    metres = 1 / max(direction @ plane, 1e-12)
    length = np.linalg.norm(matrix @ [0.5, 0.5, 1])
    return _light("plane", cards, row, matrix * (metres / length), residual)


def sphere(cards: Cards, row: int, metres: float, spread: float) -> PlacedLight:
    """Light as a sphere at this distance."""
    square = geometry.square_towards(cards.direction[row], float(cards.angular_radius[row]))
    return _light("sphere", cards, row, square * metres, spread)


def infinite(cards: Cards, row: int) -> PlacedLight:
    """Light at infinity."""
    return _light("sun", cards, row, cards.matrix[row], 0.0)


def _light(kind: str, cards: Cards, row: int, matrix: Reals, uncertainty: float) -> PlacedLight:
    radius, texture = float(cards.angular_radius[row]), cards.textures[row]
    light = _is_ellipse(cards, row), matrix, cards.irradiance[row], radius, texture
    return PlacedLight(kind, *light, uncertainty)
