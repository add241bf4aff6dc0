"""The remainder of a map as surfaces at their depth: small diffuse patches, or another map."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights.environment.envmap import EnvMap
from envlights.kernels.image import area_means
from envlights.kernels.sphere import pixel_directions, pixel_solid_angles, samples_at
from envlights.placing.planes import Reals, pixel_planes

#: Rows of patches; twice as many columns. 32 rows have half of the error, and take 4 times as long.
_ROWS = 16


def patches_of(remainder: EnvMap, distance: Reals) -> Reals:
    """Patches of the pixels that have a distance, (n, 10), as `PlacedLights.patches`."""
    height, width = distance.shape
    same = remainder if remainder.height == height else remainder.resized(width)
    ray = pixel_directions(height, width)
    plane = pixel_planes(distance, ray, 2 * _ROWS, 256)
    length = np.linalg.norm(plane, axis=-1, keepdims=True)
    cosine = (plane * ray).sum(axis=-1, keepdims=True) / length
    known = np.isfinite(distance)[..., None] & np.isfinite(cosine)
    metres = np.where(known, distance[..., None], 0)
    area = pixel_solid_angles(height, width)[..., None] * metres**2
    area = np.where(known, area / np.maximum(cosine, 0.1), 0)
    towards = np.where(known, -plane / length, 0)
    parts = np.concatenate([ray * metres, towards, np.ones_like(area), same.cells()], axis=-1)
    sums = area_means(parts * area, _ROWS, 2 * _ROWS).reshape(-1, 10)
    size = sums[:, 6:7] * (height * width / (2 * _ROWS**2))
    facing = np.linalg.norm(sums[:, 3:6], axis=1, keepdims=True)
    some = (size > 0)[:, 0] & (facing > 0)[:, 0]
    sums, size, facing = sums[some], size[some], facing[some]
    means = sums / sums[:, 6:7]
    return np.hstack([means[:, :3], sums[:, 3:6] / facing, size, means[:, 7:]])


def warp(radiance: NDArray[np.float32], distance: Reals, point: Reals) -> NDArray[np.float32]:
    """Map of diffuse surfaces from another point, which sees no more than the camera.

    Parameters
    ----------
    radiance : ndarray, shape (height, 2 * height, 3)
        Map at the camera.
    distance : ndarray, shape (rows, 2 * rows)
        Distance along the ray of each pixel; light with an infinite one stays.
    point : ndarray, shape (3,)
        Position in metres from the camera.
    """
    rays = pixel_directions(*radiance.shape[:2]).reshape(-1, 3)
    inverse = 1 / distance[..., None]
    metres, towards = np.full(len(rays), np.median(distance[np.isfinite(distance)])), rays
    for _ in range(40):
        # The ray passes the surface where its distance from the camera is that of the depth.
        points = point + metres[:, None] * rays
        length = np.linalg.norm(points, axis=1)
        towards = points / np.maximum(length, 1e-12)[:, None]
        ratio = length * samples_at(inverse, towards)[:, 0]
        metres = np.clip(metres / np.maximum(ratio, 1e-3) ** 0.7, 1e-6, 1e12)
    return samples_at(radiance, towards).reshape(radiance.shape).astype(np.float32)


def surface_behind(distance: Reals, point: Reals) -> float:
    """Distance from the camera to the surface in the direction of a point."""
    length = np.linalg.norm(point)
    if length == 0:
        return np.inf
    inverse = samples_at(1 / distance[..., None], point[None] / length)
    return float(1 / max(inverse.item(), 1e-12))
