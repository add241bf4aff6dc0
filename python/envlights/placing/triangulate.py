"""Positions of the lights that two or more maps of one room share."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from envlights import _native
from envlights._common.words import quantity
from envlights._native import EnvLightsError
from envlights.cards import Cards, geometry
from envlights.placing.placed_light import PlacedLight
from envlights.placing.planes import Reals
from envlights.placing.position import infinite, on_plane, sphere

#: Angle by which two rays miss each other, and logarithm of the ratio of intensities, that cost 1;
#: lights whose pair costs more than 4 are not the same. Centres of cards miss by 0.04 degrees.
_MISS_DEG, _RATIO, _MOST_COST = 3.0, 0.5, 4.0
#: Least parallax in degrees: at 2 degrees, a miss of 0.04 degrees moves a light by 1 %.
_LEAST_PARALLAX_DEG = 2.0

#: Map and card of each ray that meets in a light.
_Rays = list[tuple[int, int]]


def triangulate(
    cards: Sequence[Cards], where: Sequence[Reals]
) -> tuple[tuple[PlacedLight, ...], list[str]]:
    """Lights of the first map where their rays meet those of the others, and notes.

    Parameters
    ----------
    cards : sequence of Cards
        Cards of each map.
    where : sequence of ndarray, shape (3,)
        Position of each map, relative to the first.
    """
    if not any(place.any() for place in where):
        raise EnvLightsError("the maps must have different positions; all are at the same one")
    rays: list[_Rays] = [[(0, row)] for row in range(len(cards[0]))]
    for number, (others, shift) in enumerate(zip(cards, where, strict=True)):
        for row, partner in _partners(cards[0], others, shift) if number else ():
            rays[row].append((number, partner))
    lights = tuple(_light(cards, where, each) for each in rays)
    near = sum(light.kind != "sun" for light in lights)
    notes = [f"{quantity(near, 'light')} placed by the parallax of {len(cards)} maps"]
    if near < len(lights):
        far = quantity(len(lights) - near, "light")
        notes.append(f"{far} without a partner or without parallax left at infinity")
    return lights, notes


def _partners(cards: Cards, others: Cards, shift: Reals) -> list[tuple[int, int]]:
    """Pairs of cards that are the same light, at the least sum of costs."""
    size = max(len(cards), len(others))
    cost = np.full((size, size), 2 * _MOST_COST)
    for i in range(len(cards)):
        for j in range(len(others)):
            cost[i, j] = min(_cost(cards, i, others, j, shift), 2 * _MOST_COST)
    chosen = _native.assignment(cost).tolist() if size else []
    return [(i, j) for i, j in enumerate(chosen) if cost[i, j] < _MOST_COST]


def _cost(cards: Cards, i: int, others: Cards, j: int, shift: Reals) -> float:
    """Cost of a pair: the angle by which the rays miss each other, and the ratio of intensities."""
    rays = np.array([cards.direction[i], others.direction[j]])
    point, miss = _meeting(rays, np.array([np.zeros(3), shift]))
    near, far = (point**2).sum(), ((point - shift) ** 2).sum()
    light, other = cards.irradiance[i] * near, others.irradiance[j] * far
    floor = 1e-6 * max(light.max(), other.max()) + 1e-300
    ratio = np.log((light + floor) / (other + floor))
    return float((np.degrees(miss) / _MISS_DEG) ** 2 + np.mean(ratio**2) / _RATIO**2)


def _meeting(rays: Reals, origins: Reals) -> tuple[Reals, float]:
    """Point nearest to some rays, (n, 3), and the largest angle between it and a ray.

    The angle is infinite if the rays are parallel or the point lies behind an origin.
    """
    across = np.eye(3) - rays[:, :, None] * rays[:, None, :]
    total = across.sum(axis=0)
    if np.linalg.cond(total) > 1e10:
        return np.ones(3), np.inf
    point = np.linalg.solve(total, np.einsum("nij,nj->i", across, origins))
    cosine = (geometry.unit(point - origins) * rays).sum(axis=1)
    return point, np.inf if (cosine <= 0).any() else float(np.arccos(np.minimum(cosine, 1)).max())


def _light(cards: Sequence[Cards], where: Sequence[Reals], rays: _Rays) -> PlacedLight:
    """Light at the meeting of its rays, or at infinity."""
    (_, row), origins = rays[0], np.array([where[k] for k, _ in rays])
    point, miss = _meeting(np.array([cards[k].direction[i] for k, i in rays]), origins)
    towards = geometry.unit(point - origins)
    parallax = np.degrees(np.arccos(np.clip(towards @ towards.T, -1, 1)).max())
    if len(rays) < 2 or not np.isfinite(miss) or parallax < _LEAST_PARALLAX_DEG:
        return infinite(cards[0], row)
    if all(cards[k].shape[i] == "rectangle" for k, i in rays):
        # The corners meet in a plane.
        sides = np.array([cards[k].corners[i] for k, i in rays])
        corners = np.array([_meeting(sides[:, corner], origins)[0] for corner in range(4)])
        normal = np.linalg.svd(corners - corners.mean(axis=0))[2][2]
        if abs(normal @ towards[0]) > 0.1:
            return on_plane(cards[0], row, normal / (normal @ point), miss)
    return sphere(cards[0], row, float(np.linalg.norm(point)), miss)
