"""Outlines of lights on the sphere."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.blocks import in_blocks
from envlights._common.check import unit_vector
from envlights.kernels import sphere

#: Samples along each side of a pixel by which its coverage is measured.
_SUPERSAMPLING = 4


class Shape(Protocol):
    """Light with an outline on the sphere and uniform radiance."""

    @property
    def radiance(self) -> ArrayLike:
        """Linear RGB."""

    def coverage(self, height: int) -> NDArray[np.float64]:
        """Fraction of each pixel that the shape covers, (height, 2 * height)."""


@dataclass(frozen=True)
class Disc:
    """A round light."""

    direction: ArrayLike
    """Unit vector towards the centre."""

    angular_radius_deg: float
    """Angle from the centre to the rim, in degrees."""

    radiance: ArrayLike
    """Linear RGB."""

    @property
    def reach_deg(self) -> float:
        """Angle from the centre to the farthest point, in degrees."""
        return self.angular_radius_deg

    def angle_deg(self, directions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Angle from each direction to the nearest point of the disc, in degrees."""
        return np.maximum(_angle_deg(directions, unit(self.direction)) - self.reach_deg, 0)

    def coverage(self, height: int) -> NDArray[np.float64]:
        """Fraction of each pixel inside the rim."""
        centre = unit(self.direction)
        rim = np.cos(np.deg2rad(self.angular_radius_deg))
        return supersample(
            height, centre, self.reach_deg, lambda directions: directions @ centre >= rim
        )


@dataclass(frozen=True)
class Rectangle:
    """A window or a tube: a flat rectangle that faces the camera."""

    direction: ArrayLike
    """Unit vector towards the centre."""

    width_deg: float
    """Opening angle from side to side, in degrees, below 180."""

    height_deg: float
    """Opening angle from top to bottom, in degrees, below 180."""

    radiance: ArrayLike
    """Linear RGB."""

    tilt_deg: float = 0.0
    """Rotation about the direction in degrees; 0 is upright, 90 swaps the sides."""

    panes: tuple[int, int] = (1, 1)
    """Panes from side to side and from top to bottom, with a bar between neighbours."""

    bar_deg: float = 0.0
    """Opening angle of a bar in the middle, in degrees; a bar shows the background."""

    @property
    def reach_deg(self) -> float:
        """Angle from the centre to the corners, in degrees."""
        half = np.tan(np.deg2rad([self.width_deg, self.height_deg]) / 2)
        return float(np.rad2deg(np.arctan(np.hypot(*half))))

    def angle_deg(self, directions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Angle from each direction to the nearest point within the frame, in degrees."""
        axes, (across, along, depth) = self._in_plane(directions)
        depth = np.maximum(depth, 1e-6)  # directions behind are nearest to a side or a corner
        half = np.tan(np.deg2rad([self.width_deg, self.height_deg]) / 2)
        x, y = np.clip(across / depth, -half[0], half[0]), np.clip(along / depth, -half[1], half[1])
        nearest = np.stack([x, y, np.ones_like(x)], axis=-1) @ axes
        nearest /= np.linalg.norm(nearest, axis=-1, keepdims=True)
        return _angle_deg(directions, nearest)

    def coverage(self, height: int) -> NDArray[np.float64]:
        """Fraction of each pixel inside the frame, without the bars."""
        centre = unit(self.direction)
        return supersample(height, centre, self.reach_deg, self._glass)

    def _in_plane(
        self, directions: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The axes of the rectangle, (3, 3), and the directions along each of them, (3, ...)."""
        axes = _head_on(unit(self.direction), np.deg2rad(self.tilt_deg))
        return axes, np.moveaxis(directions @ axes.T, -1, 0)

    def _glass(self, directions: NDArray[np.float64]) -> NDArray[np.bool_]:
        """True where a direction meets a pane."""
        _, (across, along, depth) = self._in_plane(directions)
        inside: NDArray[np.bool_] = depth > 0
        bar = np.tan(np.deg2rad(self.bar_deg) / 2)
        for offset, side_deg, panes in zip(
            (across, along), (self.width_deg, self.height_deg), self.panes, strict=True
        ):
            # Cut off everything beyond the two edges, then each bar between two panes.
            half = np.tan(np.deg2rad(side_deg) / 2)
            inside &= np.abs(offset) <= half * depth
            for pane in range(1, panes):
                between = half * (2 * pane / panes - 1)
                inside &= np.abs(offset - between * depth) > bar * depth
        return inside


@dataclass(frozen=True)
class PixelSun:
    """A sun of one pixel, as in most maps."""

    direction: ArrayLike
    """Unit vector into the pixel."""

    radiance: ArrayLike
    """RGB of the pixel."""

    @property
    def reach_deg(self) -> float:
        """0: the sun is a point."""
        return 0.0

    def angle_deg(self, directions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Angle from each direction to the sun, in degrees."""
        return _angle_deg(directions, unit(self.direction))

    def coverage(self, height: int) -> NDArray[np.float64]:
        """1 at the pixel, 0 elsewhere."""
        ((u, v),) = sphere.direction_to_uv([unit(self.direction)])
        covered = np.zeros((height, 2 * height))
        covered[min(int(v * height), height - 1), int(u * 2 * height) % (2 * height)] = 1
        return covered


#: The shapes with a known size and place.
Lamp = Disc | Rectangle | PixelSun


def supersample(
    height: int,
    centre: NDArray[np.float64],
    reach_deg: float,
    inside: Callable[[NDArray[np.float64]], NDArray[np.bool_]],
) -> NDArray[np.float64]:
    """Fraction of each pixel's samples that are inside, weighted by solid angle from row to row.

    Pixels farther than `reach_deg` from the centre count as outside.
    """
    # Find the pixels within reach.
    n = _SUPERSAMPLING
    margin = np.pi / height  # more than from a pixel's centre to its corner
    reach = min(np.deg2rad(reach_deg) + margin, np.pi)
    near = sphere.over_map(height, lambda directions: directions @ centre >= np.cos(reach))
    # Test their samples.
    row, column = near.nonzero()
    step = (np.arange(n) + 0.5) / n

    def fraction(some: slice) -> NDArray[np.float64]:
        u = (column[some, None] + step) / (2 * height)
        v = (row[some, None] + step) / height
        uv = np.stack(np.broadcast_arrays(u[:, None, :], v[:, :, None]), axis=-1)
        hits = inside(sphere.uv_to_direction(uv.reshape(-1, 2))).reshape(-1, n, n)
        # Average them, by solid angle where rows are thin.
        weight = np.sin(np.pi * v)
        shares: NDArray[np.float64] = (weight * hits.mean(axis=2)).sum(axis=1) / weight.sum(axis=1)
        return shares

    covered = np.zeros((height, 2 * height))
    covered[near] = in_blocks((len(row), 3 * n * n), fraction)
    return covered


def smoothstep(values: NDArray[np.float64], start: float, end: float) -> NDArray[np.float64]:
    """Hermite's cubic 3 t^2 - 2 t^3: 0 up to `start`, 1 from `end` on."""
    t = np.clip((values - start) / (end - start), 0, 1)
    step: NDArray[np.float64] = t * t * (3 - 2 * t)
    return step


def unit(direction: ArrayLike) -> NDArray[np.float64]:
    """Normalised `direction`; raises an error for a zero vector."""
    return unit_vector("a direction", direction)


def _angle_deg(directions: NDArray[np.float64], others: NDArray[np.float64]) -> NDArray[np.float64]:
    cosine = np.clip((directions * others).sum(axis=-1), -1, 1)
    angle: NDArray[np.float64] = np.rad2deg(np.arccos(cosine))
    return angle


def _head_on(centre: NDArray[np.float64], tilt: float) -> NDArray[np.float64]:
    """Rows: right, up and towards a flat shape around `centre`, turned by `tilt` radians."""
    upright = [0.0, 1.0, 0.0] if abs(centre[1]) < 0.999 else [0.0, 0.0, 1.0]
    right = np.cross(upright, centre)
    right /= np.linalg.norm(right)
    up = np.cross(centre, right)
    cos, sin = np.cos(tilt), np.sin(tilt)
    return np.array([cos * right + sin * up, cos * up - sin * right, centre])
