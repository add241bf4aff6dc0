"""Pinhole camera, and the visible points of solids on a floor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights.kernels.solids import Ball, Box, Polyhedron, Solid

#: Values of `Sight.own` for rays that hit no solid.
FLOOR, NOTHING = -1, -2


class Ray(NamedTuple):
    """Rays from a common origin."""

    origin: NDArray[np.float64]
    """(3,)."""

    directions: NDArray[np.float64]
    """Unit vectors, (n, 3)."""


class Sight(NamedTuple):
    """First surface that each ray hits."""

    points: NDArray[np.float64]
    """(n, 3)."""

    normals: NDArray[np.float64]
    """Unit vectors, (n, 3)."""

    own: NDArray[np.int64]
    """Index of the solid that each ray hits, `FLOOR` or `NOTHING`, (n,)."""


@dataclass(frozen=True)
class Camera:
    """Pinhole camera above a floor at height 0, with +y up."""

    eye: tuple[float, float, float]
    """Position."""

    target: tuple[float, float, float]
    """Point in the centre of the image."""

    fov: float
    """Horizontal field of view in degrees."""

    width: int
    """Columns of the image."""

    height: int
    """Rows of the image."""

    def rays(self, per_side: int = 1) -> Ray:
        """Rays through a grid of `per_side` x `per_side` points per pixel, row by row."""
        eye = np.array(self.eye, float)
        forward = _unit(np.array(self.target, float) - eye)
        right = _unit(np.cross(forward, [0.0, 1.0, 0.0]))
        columns, rows = per_side * self.width, per_side * self.height
        scale = 2 * np.tan(np.deg2rad(self.fov) / 2) / columns
        x = scale * (np.arange(columns) + 0.5 - columns / 2)
        y = scale * (rows / 2 - np.arange(rows) - 0.5)
        across = forward + x[:, None] * right
        directions = across + y[:, None, None] * np.cross(right, forward)
        return Ray(eye, _unit(directions).reshape(-1, 3))

    def pixels(self, values: NDArray[Any], per_side: int = 1) -> NDArray[Any]:
        """Means over the rays of each pixel, (height, width, ...)."""
        grid = (self.height, per_side, self.width, per_side, *values.shape[1:])
        means: NDArray[Any] = values.reshape(grid).mean(axis=(1, 3))
        return means


def first_surfaces(rays: Ray, solids: tuple[Solid, ...]) -> Sight:
    """First hits of the rays with a floor at height 0, or with a solid."""
    origin, directions = rays
    sinking = -directions[:, 1]
    distances = np.where(sinking > 0, origin[1] / np.maximum(sinking, 1e-300), np.inf)
    normals = np.tile([0.0, 1.0, 0.0], (len(directions), 1))
    own = np.where(np.isfinite(distances), FLOOR, NOTHING)
    for row, solid in enumerate(solids):
        closer, towards = _meet(rays, solid)
        nearer = closer < distances
        distances[nearer], normals[nearer], own[nearer] = closer[nearer], towards[nearer], row
    points = origin + np.where(own == NOTHING, 1.0, distances)[:, None] * directions
    points[own == FLOOR, 1] = 0.0
    return Sight(points, normals, own)


def _meet(rays: Ray, solid: Solid) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Distance to a solid, infinity without a hit, and normal at the hit."""
    return _meet_ball(rays, solid) if isinstance(solid, Ball) else _meet_polyhedron(rays, solid)


def _meet_ball(rays: Ray, ball: Ball) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Distance to a ball, infinity without a hit, and normal at the hit."""
    away = rays.origin - np.asarray(ball.centre, float)
    along = rays.directions @ away
    square = along**2 - away @ away + ball.radius**2
    distances = np.where(square > 0, -along - np.sqrt(np.maximum(square, 0)), np.inf)
    distances[distances <= 0] = np.inf
    normals = away + np.where(np.isfinite(distances), distances, 0)[:, None] * rays.directions
    return distances, _unit(normals)


def _meet_polyhedron(
    rays: Ray, solid: Box | Polyhedron
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Distance to a convex polyhedron, infinity without a hit, and normal at the hit."""
    normals, distances = solid.planes()
    heights = normals @ rays.origin - distances
    slopes = rays.directions @ normals.T
    slopes[slopes == 0] = 1e-300
    crossings = -heights / slopes
    enters = np.where(slopes < 0, crossings, -np.inf)
    face = enters.argmax(axis=1)
    enter = enters.max(axis=1)
    leave = np.where(slopes > 0, crossings, np.inf).min(axis=1)
    return np.where((enter < leave) & (enter > 0), enter, np.inf), normals[face]


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    units: NDArray[np.float64] = vectors / lengths
    return units
