"""Distances of lamps in an empty box, by the light that they throw on its walls.

On each wall, radiance = albedo * (direct light of the lamps) + c * (light of the other walls) + a
linear function of the position. Factors and linear function are solved in closed form (variable
projection). Distances are those of a grid with the least squared relative residuals, found one lamp
after the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights._common.words import percent
from envlights.cards import Cards
from envlights.environment.envmap import EnvMap
from envlights.kernels.image import area_means
from envlights.kernels.sphere import pixel_directions, pixel_solid_angles
from envlights.placing.depth import box_distance
from envlights.placing.placed_light import PlacedLight
from envlights.placing.placed_lights import near_irradiance
from envlights.placing.planes import Reals
from envlights.placing.position import sphere

#: Rows of samples of the walls; twice as many columns.
_ROWS = 32
#: Distances that are compared, relative to that of the wall behind the lamp.
_DISTANCES = np.geomspace(0.98, 0.2, 60)
#: Flux relative to all cards, from which the light of a lamp on the walls is visible.
_LEAST_FLUX = 0.01
#: Ratio of squared residuals from which one of two hypotheses is certain. With 1.1, one of 75
#: downlights in 40 random rooms, of walls with a texture of 30 %, hangs at 40 % of its distance.
_CERTAIN = 1.15
#: Inner normals of the walls at the largest and at the least x, y and z.
_NORMALS = np.concatenate([-np.eye(3), np.eye(3)])


class _Samples(NamedTuple):
    """Points on walls: position (s, 3), wall of the six, mean radiance of RGB, solid angle."""

    point: Reals
    wall: NDArray[np.intp]
    radiance: Reals
    weight: Reals

    def received(self, lights: Sequence[PlacedLight], patches: Reals) -> Reals:
        """Irradiance of each sample, as the mean of RGB."""
        irradiance = near_irradiance(self.point, _NORMALS, lights, patches).mean(axis=2)
        values: Reals = irradiance[np.arange(len(self.wall)), self.wall]
        return values


class _Wall(NamedTuple):
    """Radiance (s,), direct light of fixed lights (s,), and of lamps at each distance (n, c, s).

    Samples are weighted, and without the part that is linear in the position or indirect light.
    """

    radiance: Reals
    fixed: Reals
    lamps: Reals

    def losses(self, chosen: Sequence[int], row: int) -> Reals:
        """Squared residual for each distance of a lamp, with the others at theirs."""
        others = sum((self.lamps[k, at] for k, at in enumerate(chosen) if k != row), self.fixed)
        light = others + self.lamps[row]
        match = np.maximum(light @ self.radiance, 0) ** 2
        power = np.maximum((light**2).sum(axis=1), 1e-300)
        losses: Reals = self.radiance @ self.radiance - match / power
        return losses


def hang(
    lights: Sequence[PlacedLight],
    cards: Cards,
    remainder: EnvMap,
    patches: Reals,
    corners: tuple[Reals, Reals],
) -> tuple[tuple[PlacedLight, ...], str]:
    """Lights of a room, with lamps that hang in front of their wall, and a note.

    Parameters
    ----------
    lights : sequence of PlacedLight
        Lights of the cards, on the walls.
    cards : Cards
    remainder : EnvMap
    patches : ndarray, shape (n, 10)
        Patches of the remainder.
    corners : tuple of ndarray, shape (3,)
        Least and largest coordinates of the room, from the camera.
    """
    flux = cards.irradiance.mean(axis=1)
    samples = _samples(cards, remainder, corners)
    is_lit = (flux > _LEAST_FLUX * flux.sum()) & samples.radiance.any()
    free = [k for k, light in enumerate(lights) if is_lit[k] and light.is_disc]
    held = [light for k, light in enumerate(lights) if k not in free]
    around, direct = samples.received((), patches), samples.received(held, patches[:0])
    lamps = [_lamp(lights[k], flux[k], samples) for k in free]
    walls = [_wall(samples, around, direct, lamps, number) for number in range(6)]
    starts = (0, len(_DISTANCES) // 3, len(_DISTANCES) // 2)
    loss, chosen = min(_descend(walls, [start] * len(free)) for start in starts)
    placed, doubtful = list(lights), 0
    for row, k in enumerate(free):
        losses = _losses(walls, chosen, row)
        doubtful += bool(1 / _CERTAIN < losses[0] / losses[1:].min() < _CERTAIN)
        if chosen[row]:
            metres, spread = _least(losses[1:])
            placed[k] = sphere(cards, k, metres * lights[k].distance, spread)
    loss /= _CERTAIN ** np.count_nonzero(chosen)
    residual = np.sqrt(loss / max(samples.weight.sum(), 1e-300))
    return tuple(placed), _note(chosen, residual, doubtful)


def _note(chosen: Sequence[int], residual: float, doubtful: int) -> str:
    """Note on the lamps of a room."""
    hanging, lamps = np.count_nonzero(chosen), len(chosen)
    note = f"the depth is that of the walls of a room; {hanging} of {lamps} round lamps hang"
    note += f" in front, by their light on the walls, which fits to {percent(residual)}" * (
        lamps > 0
    )
    return note + f"; {doubtful} may hang or not, and stay on their wall" * (doubtful > 0)


def _samples(cards: Cards, remainder: EnvMap, corners: tuple[Reals, Reals]) -> _Samples:
    """Samples that lie on one wall, without the surroundings of cards, which are a guess."""
    ray, point, _ = _box(corners, _ROWS)
    *_, fine = _box(corners, 8 * _ROWS)
    walls = fine.reshape(_ROWS, 8, 2 * _ROWS, 8)
    level = area_means(remainder.cells().mean(axis=2), _ROWS, 2 * _ROWS)
    reach = np.cos(np.minimum(2 * cards.angular_radius, np.pi))
    kept = ~(ray @ cards.direction.T > reach).any(axis=-1) & (level > 1e-6 * level.max())
    kept &= walls.min(axis=(1, 3)) == walls.max(axis=(1, 3))
    weight = np.broadcast_to(pixel_solid_angles(_ROWS, 2 * _ROWS), kept.shape)
    return _Samples(point[kept], walls[:, 0, :, 0][kept], level[kept], weight[kept])


def _box(corners: tuple[Reals, Reals], rows: int) -> tuple[Reals, Reals, NDArray[np.intp]]:
    """Ray of each pixel, its point on a wall, and the number of the wall."""
    ray = pixel_directions(rows, 2 * rows)
    point = ray * box_distance(corners, rows)[..., None]
    wall = np.concatenate([corners[1] - point, point - corners[0]], axis=-1).argmin(axis=-1)
    return ray, point, wall


def _lamp(light: PlacedLight, flux: float, samples: _Samples) -> Reals:
    """Direct light of a lamp on its wall, and as a small sphere at each distance, (c, s)."""
    metres = light.distance * _DISTANCES[:, None]
    to = light.direction * metres[..., None] - samples.point
    cosine = np.maximum((to * _NORMALS[samples.wall]).sum(axis=2), 0)
    balls = flux * metres**2 * cosine / np.maximum((to**2).sum(axis=2), 1e-12) ** 1.5
    return np.vstack([samples.received([light], np.zeros((0, 10))), balls])


def _wall(
    samples: _Samples, around: Reals, direct: Reals, lamps: list[Reals], number: int
) -> _Wall:
    """Samples of one wall, relative to their radiance, without their linear part."""
    on = samples.wall == number
    scale = np.sqrt(samples.weight[on]) / samples.radiance[on]
    along = np.delete(samples.point[on], number % 3, axis=1)
    linear = np.column_stack([np.ones(len(along)), along, around[on]])
    basis, _ = np.linalg.qr(linear * scale[:, None])
    distances = np.reshape(lamps, (len(lamps), 1 + len(_DISTANCES), len(on)))
    parts = [part[..., on] * scale for part in (samples.radiance, direct, distances)]
    return _Wall(*(part - (part @ basis) @ basis.T for part in parts))


def _losses(walls: Sequence[_Wall], chosen: Sequence[int], row: int) -> Reals:
    """Squared relative residual of all walls for each distance of a lamp, with rounding."""
    rounding = np.full(1, np.finfo(np.float32).eps, float)
    return sum((wall.losses(chosen, row) for wall in walls), rounding)


def _descend(walls: Sequence[_Wall], start: list[int]) -> tuple[float, list[int]]:
    """Local minimum, and the distance of each lamp there; 0 is the wall, which is preferred."""
    chosen, least = list(start), np.inf
    for _ in _DISTANCES:  # ends earlier, after 2 to 6 sweeps
        before = list(chosen)
        for row in range(len(chosen)):
            losses = _losses(walls, chosen, row)
            losses[1:] *= _CERTAIN
            chosen[row] = int(losses.argmin())
            least = float(losses[chosen[row]])
        if chosen == before:
            break
    return least * _CERTAIN ** np.count_nonzero(chosen[:-1]), chosen


def _least(losses: Reals) -> tuple[float, float]:
    """Relative distance of the least loss, by a parabola, and half of the range within 5 %."""
    at = int(np.clip(losses.argmin(), 1, len(losses) - 2))
    near, middle, far = losses[at - 1 : at + 2]
    shift = 0.5 * (near - far) / max(near - 2 * middle + far, 1e-300)
    step = _DISTANCES[1] / _DISTANCES[0]
    good = _DISTANCES[losses <= 1.05 * losses.min()]
    distance = _DISTANCES[at] * step ** np.clip(shift, -1, 1)
    return float(distance), float(0.5 * (good[0] / good[-1] - 1))
