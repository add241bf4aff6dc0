"""Changed lights drawn into the map from which they were removed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights._common.words import quantity
from envlights._native import EnvLightsError
from envlights.environment.envmap import EnvMap
from envlights.kernels.angles import azimuths
from envlights.kernels.probe import disc_map
from envlights.rigs.light import Light
from envlights.rigs.lights import Lights
from envlights.splitting.removed_lights import RemovedLights


class RemovedRadiance(NamedTuple):
    """Radiance that was removed from a map."""

    env: EnvMap
    """Map before the removal."""

    light_of_block: NDArray[np.uint32]
    """Light number of each block of pixels, from 1; 0 for none, (rows, columns)."""

    block: int
    """Block size in pixels."""

    def light_of_pixel(self) -> NDArray[np.uint32]:
        """Light number of each pixel, from 1; 0 for none, (height, width)."""
        blocks = self.light_of_block.repeat(self.block, axis=0).repeat(self.block, axis=1)
        return blocks[: self.env.height, : self.env.width]


class Change(NamedTuple):
    """Light before and after a change."""

    number: int
    """Number of the removed light in the map."""

    old: Light
    """The removed light."""

    new: Light
    """The light to draw."""

    @property
    def keeps_pixels(self) -> bool:
        """True if the size is unchanged, and no black channel is lit."""
        old_size = min(self.old.angular_radius, np.pi / 2)
        is_lit = (self.old.irradiance > 0) | (self.new.irradiance == 0)
        return self.new.angular_radius == old_size and bool(is_lit.all())

    @property
    def gain(self) -> NDArray[np.float32]:
        """Factor on the irradiance of each channel."""
        old = np.where(self.old.irradiance > 0, self.old.irradiance, 1)
        return (self.new.irradiance / old).astype(np.float32)

    @property
    def keeps_place(self) -> bool:
        """True if the direction is unchanged."""
        return np.array_equal(self.old.direction, self.new.direction)


def relight(
    remainder: EnvMap, removed: RemovedRadiance, before: RemovedLights, lights: Lights
) -> EnvMap:
    """The `remainder` of a map with other `lights`; see `Split.with_lights`."""
    changes, discs = _changes(before, lights)
    moved = [change for change in changes if not change.keeps_place]
    if len(discs) or moved:
        _check_whole(remainder)
    light, lit = removed.light_of_pixel(), removed.env.radiance - remainder.radiance
    gains = np.zeros((len(before) + 1, 3), np.float32)
    for change in changes:
        gains[change.number + 1] = change.gain if change.keeps_place else 0
    radiance = remainder.radiance + lit * gains[light]
    for change in moved:
        is_here = (light == change.number + 1)[..., None]
        radiance += _turn(change, np.where(is_here, lit * change.gain, np.float32(0)))
    if len(discs):
        radiance += disc_map(
            remainder.height, discs.direction, discs.irradiance, discs.angular_radius
        )
    note = f"{quantity(len(lights), 'light')} drawn in place of {len(before)} removed"
    return remainder.with_radiance(radiance, (*removed.env.notes, note))


def _changes(before: RemovedLights, lights: Lights) -> tuple[list[Change], Lights]:
    """Lights whose original pixels can be reused, and lights to draw as discs."""
    rows = {number: row for row, number in enumerate(before.origin or ())}
    lights = lights.discs()
    changes, discs = [], []
    for row, number in enumerate(lights.origin or (-1,) * len(lights)):
        if number != -1 and number not in rows:
            raise EnvLightsError(
                f"the lights must be those of this split, changed; light {row} was number {number},"
                f" and the split has {quantity(len(before), 'light')}"
            )
        change = Change(number, before[rows[number]], lights[row]) if number != -1 else None
        if change is not None and change.keeps_pixels:
            changes.append(change)
        else:
            discs.append(row)
    return changes, lights[discs]


def _check_whole(env: EnvMap) -> None:
    """Raise an error for maps into which no pixels can be drawn."""
    if env.coverage is not None:
        raise EnvLightsError(
            "the map shows a part of the sphere, where lights can be dimmed, coloured and left out,"
            " but not moved, resized or added; fill the map first"
        )
    if env.is_border_sampled:
        raise EnvLightsError(
            "the map is border-sampled, where lights can be dimmed, coloured and left out, but not"
            f" moved, resized or added; split env.resized({env.width}) instead"
        )


def _turn(change: Change, pixels: NDArray[np.float32]) -> NDArray[np.float32]:
    """Pixels of a light, rotated to its new direction and scaled to its irradiance."""
    new = change.new
    turned = EnvMap(pixels).rotated(_rotation(change.old.direction, new.direction))
    found = turned.probe(new.direction)
    scale = new.irradiance / np.where(found > 0, found, 1)
    return turned.radiance * scale.astype(np.float32)


def _rotation(old: NDArray[np.float64], new: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rotation from `old` to `new`: along the meridian, then about the pole."""
    turned: NDArray[np.float64] = _frame(new) @ _frame(old).T
    return turned


def _frame(direction: NDArray[np.float64]) -> NDArray[np.float64]:
    """Matrix with the columns east, along the meridian, and `direction`."""
    azimuth = azimuths(direction[None])[0]
    east = np.array([np.cos(azimuth), 0, np.sin(azimuth)])
    return np.column_stack([east, np.cross(direction, east), direction])
