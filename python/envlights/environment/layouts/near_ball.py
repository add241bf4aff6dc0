"""Correction of a photograph of a mirror ball from a near camera to the radii of a distant camera.

A ray at the angle g from the axis of a camera at D radii meets the ball where its normal is at the
angle u - g, with sin u = D sin g, and leaves at 2 u - g. The rim is at u = 90 degrees. Beyond
180 degrees - asin(1 / D) lies the blind cone behind the ball.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from envlights._common.blocks import in_blocks

Circle = tuple[float, float, float]


def reach_of(distance: float) -> float:
    """Largest visible angle on the mirror ball, in radians from the direction to the camera."""
    return math.pi - math.asin(1 / distance)


def straighten(
    image: NDArray[np.floating], circle: Circle, distance: float
) -> NDArray[np.floating]:
    """Image whose reflections have the radii of an equisolid disc, up to `reach_of`."""
    x, y, radius = circle
    u = np.linspace(0, math.pi / 2, 8193)
    ray = np.arcsin(np.sin(u) / distance)
    far = np.sin(u - ray / 2) / math.sin(reach_of(distance) / 2)
    near = np.tan(ray) * math.sqrt(distance**2 - 1)
    columns = np.arange(image.shape[1]) + 0.5 - x
    is_ball = np.hypot(columns, np.arange(len(image))[:, None] + 0.5 - y) <= radius

    def rows_of(rows: slice) -> NDArray[np.floating]:
        down = np.arange(rows.start, rows.stop)[:, None] + 0.5 - y
        length = np.hypot(columns, down) / radius
        scale = np.where(length < 1, np.interp(length, far, near) / np.maximum(length, 1e-12), 1.0)
        return _bilinear(image, is_ball, y + scale * down - 0.5, x + scale * columns - 0.5)

    result: NDArray[np.floating] = in_blocks(image.shape, rows_of)
    return result


def _bilinear(
    image: NDArray[np.floating],
    is_ball: NDArray[np.bool_],
    rows: NDArray[np.float64],
    columns: NDArray[np.float64],
) -> NDArray[np.floating]:
    """Bilinear samples between pixel centres on the ball."""
    total, weights = np.zeros((*rows.shape, image.shape[2])), np.full(rows.shape, 1e-9)
    top, left = np.floor(rows).astype(int), np.floor(columns).astype(int)
    for down in (0, 1):
        for right in (0, 1):
            row = np.clip(top + down, 0, image.shape[0] - 1)
            column = np.clip(left + right, 0, image.shape[1] - 1)
            weight = (1 - abs(rows - top - down)) * (1 - abs(columns - left - right))
            weight = weight * is_ball[row, column]
            total += weight[..., None] * image[row, column]
            weights += weight
    samples: NDArray[np.floating] = (total / weights[..., None]).astype(image.dtype)
    return samples
