"""Identification of lights over the frames of a sequence."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights.rigs.lights import Lights

#: Angle in degrees, and ratio of flux, that cost as much as leaving a light unmatched. Two lights
#: match if they cost less than two unmatched lights: 10 degrees at equal flux.
_ANGLE_DEG, _FLUX_RATIO = 5.0, 4.0
#: Additional cost of lights that reappear after an absence, so that present lights are preferred.
_RETURN = 0.5
#: Number of vanished lights that are remembered.
_MOST_VANISHED = 64
#: Weight of the newest step in the velocity of a light; 1 would propagate the noise of each fit.
_NEWEST = 0.3


@dataclass
class _Light:
    identity: int
    direction: NDArray[np.float64]
    flux: float
    radius: float
    #: Fraction of each channel in the sum of the irradiance, (3,).
    colour: NDArray[np.float64]
    #: Rotation per frame, as axis times angle.
    velocity: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    age: int = 0
    #: Number of frames since the light was last present.
    absent: int = 0

    @property
    def next_direction(self) -> NDArray[np.float64]:
        """Direction in the next frame at constant velocity; the last one if it vanished."""
        return self.direction if self.absent else turn(self.direction, self.velocity)

    def move(
        self,
        direction: NDArray[np.float64],
        flux: float,
        radius: float,
        colour: NDArray[np.float64],
    ) -> None:
        """Update the state for the next frame."""
        if self.absent:
            self.velocity, self.age = np.zeros(3), 0
        else:
            self.age += 1
            fraction = max(1 / self.age, _NEWEST)
            step = rotation_vector(self.direction, direction)
            self.velocity = (1 - fraction) * self.velocity + fraction * step
        self.direction, self.flux, self.radius, self.absent = direction, flux, radius, 0
        self.colour = colour


class Identities:
    """Lights of a sequence, identified from frame to frame."""

    def __init__(self) -> None:
        self._lights: list[_Light] = []
        self._count = 0
        self._present: list[_Light] = []

    def next_lights(self) -> Lights:
        """Lights of the last frame in predicted directions, brightest first, in grey."""
        direction = np.reshape([light.next_direction for light in self._present], (-1, 3))
        flux = np.repeat([light.flux for light in self._present], 3).reshape(-1, 3)
        return Lights(direction, flux, np.array([light.radius for light in self._present]))

    def follow(self, lights: Lights) -> tuple[int, ...]:
        """Identity of each light of the next frame."""
        partners = self._partners(lights)
        numbers = lights.luminance.tolist(), lights.angular_radius.tolist()
        arrays = lights.direction, *numbers, _colours(lights)
        self._present = []
        for row, state in enumerate(zip(*arrays, strict=True)):
            known = partners.get(row)
            if known is None:
                known = _Light(self._count, *state)
                self._count += 1
                self._lights.append(known)
            else:
                known.move(*state)
            self._present.append(known)
        self._forget()
        return tuple(light.identity for light in self._present)

    def _partners(self, lights: Lights) -> dict[int, _Light]:
        """Known light for each matched row, by the assignment with the lowest cost."""
        known, rows = len(self._lights), len(lights)
        # Allow each light to stay unmatched, at a cost of 1, in additional columns and rows.
        costs = np.full((known + rows, known + rows), np.inf)
        costs[:known, :rows] = self._costs(lights)
        np.fill_diagonal(costs[:known, rows:], 1.0)
        np.fill_diagonal(costs[known:, :rows], 1.0)
        costs[known:, rows:] = 0.0
        # Two unmatched lights cost 2, so more expensive pairs are never assigned.
        columns = _native.assignment(np.minimum(costs, 3.0))
        return {int(columns[i]): self._lights[i] for i in range(known) if columns[i] < rows}

    def _costs(self, lights: Lights) -> NDArray[np.float64]:
        """Cost of each pair of a known light and a row, from direction, flux and colour."""
        if not self._lights or not len(lights):
            return np.zeros((len(self._lights), len(lights)))
        expected = np.array([light.next_direction for light in self._lights])
        chord = np.linalg.norm(expected[:, None] - lights.direction[None], axis=2)
        angle = np.rad2deg(2 * np.arcsin(np.minimum(chord / 2, 1)))
        radius = np.array([light.radius for light in self._lights])
        # Directions of wide lights are less certain.
        wide = np.rad2deg(radius[:, None] + lights.angular_radius) / 8
        smallest = np.finfo(float).tiny
        before = np.log(np.maximum([light.flux for light in self._lights], smallest))
        after = np.log(np.maximum(lights.luminance, smallest))
        ratio = np.abs(after - before[:, None]) / np.log(_FLUX_RATIO)
        absent = np.array([_RETURN * (light.absent > 0) for light in self._lights])
        # Lights without a common channel cost 2, and never match.
        colours = np.array([light.colour for light in self._lights])
        tint = np.abs(colours[:, None] - _colours(lights)).sum(axis=2)
        costs: NDArray[np.float64] = angle / (_ANGLE_DEG + wide) + ratio + tint + absent[:, None]
        return costs

    def _forget(self) -> None:
        """Count the frames of absence, and forget the lights that are absent longest."""
        present = {light.identity for light in self._present}
        for light in self._lights:
            light.absent += light.identity not in present
        vanished = sorted((light for light in self._lights if light.absent), key=lambda x: x.absent)
        gone = {light.identity for light in vanished[_MOST_VANISHED:]}
        self._lights = [light for light in self._lights if light.identity not in gone]


def _colours(lights: Lights) -> NDArray[np.float64]:
    """Fraction of each channel in the sum of the irradiance of each light, (n, 3)."""
    whole = np.maximum(lights.irradiance.sum(axis=1, keepdims=True), np.finfo(float).tiny)
    colours: NDArray[np.float64] = lights.irradiance / whole
    return colours


def rotation_vector(start: NDArray[np.float64], end: NDArray[np.float64]) -> NDArray[np.float64]:
    """Shortest rotation from one unit vector to another, as axis times angle, (3,)."""
    cross = _cross(start, end)
    sine = math.hypot(*cross)
    angle = math.atan2(sine, float(start @ end))
    return np.array(cross) * (angle / sine) if sine > 0 else np.zeros(3)


def turn(direction: NDArray[np.float64], rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit vector after a rotation about a perpendicular axis, given as axis times angle."""
    angle = math.hypot(*rotation.tolist())
    if angle == 0:
        return direction
    ahead = np.array(_cross(rotation, direction))
    moved = math.cos(angle) * direction + (math.sin(angle) / angle) * ahead
    return np.asarray(moved / math.hypot(*moved.tolist()))


def _cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> tuple[float, float, float]:
    """Cross product of two vectors; `np.cross` takes ten times as long for one pair."""
    (x, y, z), (u, v, w) = a.tolist(), b.tolist()
    return y * w - z * v, z * u - x * w, x * v - y * u
