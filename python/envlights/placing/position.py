"""Position of one light card, by the depth of its own pixels and of the surface around it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights.cards import Cards, geometry
from envlights.placing.placed_light import PlacedLight
from envlights.placing.reading import Reals
from envlights.placing.surface import (
    Pixels,
    ball_distance,
    pixels_of_card,
    plane,
    weighted_median,
)

#: Distance of a light in front of the plane around it, relative to that of the plane, from which
#: it hangs. Lamps at 0.1 m below a ceiling hang; 5 % of noise makes half of them flush at 0.02.
_HANGING = 0.04
#: Pixels of a hanging rectangle from which its own depth has a plane; smaller ones are spheres.
_LEAST_PIXELS = 100


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
    """Card as a sphere, as a plane, or as a sun where there is no surface."""
    is_ellipse = cards.shape[row] not in ("rectangle", "tube")
    pixels = pixels_of_card(distance, light, cards.matrix[row], is_ellipse=is_ellipse)
    wall, around = _plane_of(pixels.ring)
    if wall is not None:
        pixels.behind(behind, wall)
    if not pixels.own.has_surface:  # a window: it lies in the surface around it
        return on_plane(cards, row, wall, around)
    own = pixels.own.known()
    if wall is not None and _ratio(own, wall) > 1 - _HANGING:
        return on_plane(cards, row, wall, around)
    if not is_ellipse and len(own.distance) >= _LEAST_PIXELS:
        return on_plane(cards, row, *plane(own))
    return sphere(cards, row, *ball_distance(own, cards.direction[row], cards.angular_radius[row]))


def _plane_of(ring: Pixels) -> tuple[Reals | None, float]:
    """Plane of the surface around a light, and its residual; none if there is no surface."""
    known = ring.known()
    return plane(known) if ring.has_surface and len(known.distance) >= 3 else (None, 0.0)


def _ratio(own: Pixels, wall: Reals) -> float:
    """Distance of a light relative to that of the plane around it; above 1 behind it."""
    return weighted_median(own.distance * (own.ray @ wall), own.weight)


def infinite(cards: Cards, row: int) -> PlacedLight:
    """Light of a card at infinity."""
    return _light("sun", cards, row, cards.matrix[row], 0.0)


def on_plane(cards: Cards, row: int, wall: Reals | None, residual: float) -> PlacedLight:
    """Light in a plane q . x = 1; at infinity without one, and facing where it is too oblique."""
    if wall is None:
        return infinite(cards, row)
    matrix, direction = cards.matrix[row], cards.direction[row]
    corners = geometry.corners(matrix[None])[0] @ wall
    if (corners > 0.2 * corners.max()).all():
        matrix = geometry.tilt(matrix, geometry.unit(wall))
    metres = 1 / max(direction @ wall, 1e-12)
    length = np.linalg.norm(matrix @ [0.5, 0.5, 1])
    return _light("plane", cards, row, matrix * (metres / length), residual)


def sphere(cards: Cards, row: int, metres: float, spread: float) -> PlacedLight:
    """Light of a card as a sphere at this distance."""
    direction, radius = cards.direction[row], float(cards.angular_radius[row])
    square = geometry.square_towards(direction, min(radius, 1.4))
    return _light("sphere", cards, row, square * metres, spread)


def _light(kind: str, cards: Cards, row: int, matrix: Reals, uncertainty: float) -> PlacedLight:
    radius, texture = float(cards.angular_radius[row]), cards.textures[row]
    light = cards.shape[row], matrix, cards.irradiance[row], radius, texture
    return PlacedLight(kind, *light, uncertainty)
