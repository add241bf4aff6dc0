"""Positions of the lights that two or more maps of one room share."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from envlights import _native
from envlights._common.words import quantity
from envlights._native import EnvLightsError
from envlights.cards import Cards, geometry
from envlights.placing.placed_light import PlacedLight
from envlights.placing.position import infinite, on_plane, sphere
from envlights.placing.reading import Reals

#: Angle between two rays at their nearest points, and ratio of intensities as a logarithm, that
#: cost 1 each; a pair that costs more than 4 is no pair. Errors of centres are below 0.3 degrees.
_MISS, _RATIO, _MOST_COST = np.radians(3.0), 0.5, 4.0
#: Least parallax in radians: below 2 degrees the error of a position reaches 3 %.
_PARALLAX = np.radians(2.0)


def triangulated(
    cards: Sequence[Cards], where: Sequence[Reals]
) -> tuple[tuple[PlacedLight, ...], list[str]]:
    """Lights of the first map, at the positions where the rays of the other maps meet theirs.

    Parameters
    ----------
    cards : sequence of Cards
        Cards of each map.
    where : sequence of ndarray, shape (3,)
        Position of each map, relative to the first.
    """
    if not max(np.linalg.norm(each) for each in where) > 0:
        raise EnvLightsError("the maps must have different positions; all are at the same one")
    pairs = [
        _matched(cards[0], other, shift) for other, shift in zip(cards[1:], where[1:], strict=True)
    ]
    lights = [
        _light(cards, where, row, [each.get(row) for each in pairs]) for row in range(len(cards[0]))
    ]
    far = sum(light.kind == "sun" for light in lights)
    notes = [f"{quantity(len(lights) - far, 'light')} placed by the parallax of {len(cards)} maps"]
    if far:
        notes.append(f"{quantity(far, 'light')} without a partner or parallax stay at infinity")
    return tuple(lights), notes


def _matched(cards: Cards, others: Cards, shift: Reals) -> dict[int, int]:
    """Row of the other map for each row of the first, as far as there is one."""
    if not len(cards) or not len(others):
        return {}
    cost = np.array(
        [[_cost(cards, i, others, j, shift) for j in range(len(others))] for i in range(len(cards))]
    )
    size = len(cards) + len(others)
    square = np.full((size, size), _MOST_COST / 2)
    square[: len(cards), : len(others)] = np.minimum(cost, 2 * _MOST_COST)
    square[len(cards) :, len(others) :] = 0
    chosen = _native.assignment(square)
    return {
        i: int(j)
        for i, j in enumerate(chosen[: len(cards)])
        if j < len(others) and cost[i, j] < _MOST_COST
    }


def _cost(cards: Cards, i: int, others: Cards, j: int, shift: Reals) -> float:
    """Cost of a pair: the angle by which the rays miss each other, and the ratio of intensities."""
    rays = np.array([cards.direction[i], others.direction[j]])
    point, miss = meeting(rays, np.array([np.zeros(3), shift]))
    if not np.isfinite(miss):
        return np.inf
    squares = (point**2).sum(), ((point - shift) ** 2).sum()
    one, other = cards.irradiance[i] * squares[0], others.irradiance[j] * squares[1]
    ratio = np.log((one + 1e-9 * one.max()) / (other + 1e-9 * one.max() + 1e-300))
    return float((miss / _MISS) ** 2 + np.mean(ratio**2) / _RATIO**2)


def meeting(rays: Reals, origins: Reals) -> tuple[Reals, float]:
    """Point nearest to some rays, (n, 3) each, and the largest angle between it and a ray.

    The angle is infinite if the point lies behind an origin or the rays are parallel.
    """
    across = np.eye(3) - rays[:, :, None] * rays[:, None, :]
    total = across.sum(axis=0)
    if np.linalg.cond(total) > 1e10:
        return np.zeros(3), np.inf
    point = np.linalg.solve(total, np.einsum("nij,nj->i", across, origins))
    to = point - origins
    cosine = np.einsum("ni,ni->n", geometry.unit(to), rays)
    return point, np.inf if (cosine <= 0).any() else float(np.arccos(np.minimum(cosine, 1)).max())


def _light(
    cards: Sequence[Cards], where: Sequence[Reals], row: int, partners: Sequence[int | None]
) -> PlacedLight:
    """Light at the meeting of its rays, or at infinity."""
    rows = [(0, row), *((k, other) for k, other in enumerate(partners, 1) if other is not None)]
    origins = np.array([where[k] for k, _ in rows])
    rays = np.array([cards[k].direction[other] for k, other in rows])
    if len(rows) < 2:
        return infinite(cards[0], row)
    point, miss = meeting(rays, origins)
    towards = geometry.unit(point - origins)
    parallax = np.arccos(np.clip(towards @ towards.T, -1, 1)).max()
    if not parallax > _PARALLAX:
        return infinite(cards[0], row)
    plane = _plane(cards, rows, origins)
    if plane is None:
        return sphere(cards[0], row, float(np.linalg.norm(point)), miss)
    return on_plane(cards[0], row, plane / (plane @ point), miss)


def _plane(cards: Sequence[Cards], rows: Sequence[tuple[int, int]], origins: Reals) -> Reals | None:
    """Normal of a light that is a rectangle in all maps: its corners meet in a plane."""
    if any(cards[k].shape[row] != "rectangle" for k, row in rows):
        return None
    corners = np.array([cards[k].corners[row] for k, row in rows])
    points = np.array([meeting(corners[:, corner], origins)[0] for corner in range(4)])
    normal = np.linalg.svd(points - points.mean(axis=0))[2][2]
    facing: Reals = normal * np.sign(normal @ points.mean(axis=0))
    return facing if facing @ geometry.unit(points.mean(axis=0)) > 0.1 else None
