"""Map of surfaces at a depth, as it is seen from another point."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights.kernels.sphere import direction_to_uv, pixel_directions
from envlights.placing.reading import Reals

#: Steps of the search for the surface along a ray; a convex room needs fewer.
_STEPS = 40


def warped(radiance: NDArray[np.float32], distance: Reals, point: Reals) -> NDArray[np.float32]:
    """Radiance that a point receives from diffuse surfaces; nothing hides what it has not seen.

    Parameters
    ----------
    radiance : ndarray, shape (height, 2 * height, 3)
        Map at the camera.
    distance : ndarray, shape (rows, 2 * rows)
        Distance of the surface along the ray of each pixel; infinite: the light stays.
    point : ndarray, shape (3,)
        Position in metres from the camera.
    """
    rays = pixel_directions(*radiance.shape[:2]).reshape(-1, 3)
    inverse = np.where(np.isfinite(distance), 1 / distance, 0)[..., None]
    parameter = np.full(len(rays), np.median(distance))
    towards = rays
    for _ in range(_STEPS):
        points = point + parameter[:, None] * rays
        length = np.linalg.norm(points, axis=1)
        towards = points / np.maximum(length, 1e-12)[:, None]
        # Beyond the surface the step is shorter than 1, before it longer.
        ratio = length * _sampled(inverse, towards)[:, 0]
        parameter = np.clip(parameter / np.maximum(ratio, 1e-3) ** 0.7, 1e-6, 1e12)
    return _sampled(radiance, towards).reshape(radiance.shape).astype(np.float32)


def _sampled(image: NDArray[np.floating], directions: Reals) -> Reals:
    """Bilinear samples of a cell-centred map, (n, channels)."""
    height, width, _ = image.shape
    column, row = (direction_to_uv(directions) * [width, height] - 0.5).T
    row = np.clip(row, 0, height - 1)
    left, top = np.floor(column).astype(int), np.floor(row).astype(int)
    right, bottom = (left + 1) % width, np.minimum(top + 1, height - 1)
    a, b = (column - left)[:, None], (row - top)[:, None]
    upper = (1 - a) * image[top, left % width] + a * image[top, right]
    lower = (1 - a) * image[bottom, left % width] + a * image[bottom, right]
    samples: Reals = (1 - b) * upper + b * lower
    return samples
