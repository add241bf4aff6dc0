"""Lights with positions, as they are seen from a point."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from envlights.cards import Cards, geometry
from envlights.placing.placed_light import PlacedLight
from envlights.placing.reading import Reals
from envlights.rigs.lights import Lights

#: Angular radius in radians above which a rectangle is cut into four: as one disc, a panel of 1.2 m
#: adds 0.8 % to the error at 1 m.
_LARGE = 0.15

#: Direction, irradiance at normal incidence and angular radius of a light.
_Disc = tuple[Reals, Reals, float]


def lights_from(
    lights: Sequence[PlacedLight], point: Reals, units: str, *, most: int = 0
) -> Lights:
    """Lights as discs; those that turn their back are left out.

    Large rectangles become four discs each, the brightest first, as long as there are at most
    `most` lights.
    """
    discs: list[_Disc] = []
    left = most - len(lights)
    for light in lights:
        parts = _quarters(light.matrix) if light.kind == "plane" and not light.is_disc else []
        is_cut = left >= 3 and bool(parts) and _seen(light, point)[2] > _LARGE
        left -= 3 * is_cut
        each = [_plane(light, matrix, point) for matrix in parts] if is_cut else []
        discs += [one for one in each or [_seen(light, point)] if one[1].any()]
    columns = zip(*discs, strict=True) if discs else ([], [], [])
    direction, irradiance, radius = (np.array(column, float) for column in columns)
    return Lights(direction.reshape(-1, 3), irradiance.reshape(-1, 3), radius, units=units)


def cards_from(lights: Sequence[PlacedLight], point: Reals, units: str) -> Cards:
    """Planes as cards around a point; those that turn their back are left out."""
    planes = [(light, _moved(light.matrix, point)) for light in lights if light.kind == "plane"]
    planes = [(light, matrix) for light, matrix in planes if np.linalg.det(matrix) > 0]
    return Cards(
        ["disc" if light.is_disc else light.shape for light, _ in planes],
        np.reshape([matrix for _, matrix in planes], (-1, 3, 3)),
        np.reshape([_seen(light, point)[1] for light, _ in planes], (-1, 3)),
        [light.texture for light, _ in planes],
        units=units,
        is_placed=True,
    )


def _seen(light: PlacedLight, point: Reals) -> _Disc:
    """Light as a disc; black if it turns its back."""
    if light.kind == "plane":
        return _plane(light, light.matrix, point)
    if light.kind == "sun":
        return light.direction, light.irradiance, light.angular_radius
    to = light.position - point
    distance = max(float(np.linalg.norm(to)), light.radius)
    radius = float(np.arcsin(min(light.radius / distance, 1.0)))
    return to / distance, light.irradiance * (light.distance / distance) ** 2, radius


def _plane(light: PlacedLight, matrix: Reals, point: Reals) -> _Disc:
    """Part of a plane with this matrix, by its vector irradiance."""
    moved = _moved(matrix, point)
    vector = geometry.vector_irradiance(geometry.outline(moved, light.is_disc))
    length = float(np.linalg.norm(vector))
    if np.linalg.det(moved) <= 0 or not length:
        return light.direction, np.zeros(3), 0.0
    radius = float(np.arcsin(np.sqrt(min(length / np.pi, 1.0))))
    return vector / length, light.radiance * length, radius


def _moved(matrix: Reals, point: Reals) -> Reals:
    """Matrix of a card from another origin."""
    moved = matrix.copy()
    moved[:, 2] -= point
    return moved


def _quarters(matrix: Reals) -> list[Reals]:
    """Matrices of the four quarters of a rectangle."""
    across, down, corner = matrix.T
    return [
        np.stack([across / 2, down / 2, corner + a * across + b * down], axis=1)
        for a in (0, 0.5)
        for b in (0, 0.5)
    ]
