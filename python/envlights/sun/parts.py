"""Candidate regions for the sun: clipped regions, or a single small spot in a smooth sky."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights.kernels.connectivity import connected_regions
from envlights.kernels.image import uv_to_pixel
from envlights.kernels.sphere import direction_to_uv
from envlights.sun.sky_image import SkyImage

#: Logarithm of the weight of a region at the zenith relative to one on the horizon, as in
#: detection.
_UPWARDS = 1.5
#: Ratio of width to height from which a region at the horizon is a strip, smallest width of a
#: strip, and elevation below which it begins, in degrees. A clear sky is clipped along the horizon.
_STRIP, _STRIP_WIDTH, _STRIP_BELOW = 4.0, 10.0, 6.0

Array = NDArray[np.float64]


class Part(NamedTuple):
    """Clipped region that may contain the sun."""

    mask: NDArray[np.bool_]
    depth: Array
    """Distance to the edge in degrees, 0 outside of the region."""
    direction: Array
    """Centroid weighted by the cube of the depth."""
    radius: float
    """Radius in degrees of a disc with the same solid angle."""
    solid_angle: float


def best_part(image: SkyImage) -> Part | None:
    """Region with the largest depth, preferring higher ones; None without a candidate."""
    depth = image.depth
    rows, columns = np.nonzero(depth > 0)
    if not len(rows):
        return None
    regions = connected_regions(rows, columns, depth.shape)
    deepest = np.zeros(regions.max() + 1)
    np.maximum.at(deepest, regions, depth[rows, columns])
    weights = image.solid_angles[rows, columns]
    towards = np.zeros((len(deepest), 3))
    np.add.at(towards, regions, image.directions[rows, columns] * weights[:, None])
    height = towards[:, 1] / np.maximum(np.linalg.norm(towards, axis=1), 1e-12)
    score = deepest * np.exp(_UPWARDS * np.maximum(height, -0.2))
    for region in np.argsort(-score, kind="stable"):
        own = regions == region
        if not _is_strip(image, rows[own], columns[own]):
            return _part(image, rows[own], columns[own])
    return None


def part_at(image: SkyImage, direction: Array) -> Part | None:
    """Region that contains a direction; None if the direction is not clipped."""
    ((row, column),) = uv_to_pixel(direction_to_uv(direction[None]), *image.core.shape)
    depth = image.depth
    if not depth[row, column] > 0:
        return None
    rows, columns = np.nonzero(depth > 0)
    regions = connected_regions(rows, columns, depth.shape)
    own = regions == regions[(rows == row) & (columns == column)]
    return _part(image, rows[own], columns[own])


def _part(image: SkyImage, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Part:
    mask = np.zeros(image.core.shape, bool)
    mask[rows, columns] = True
    depth = np.where(mask, image.depth, 0)
    sum_ = (image.directions[mask] * (image.solid_angles * depth**3)[mask][:, None]).sum(axis=0)
    solid_angle = float(image.solid_angles[mask].sum())
    radius = np.degrees(np.arccos(max(-1.0, 1 - solid_angle / (2 * np.pi))))
    return Part(mask, depth, sum_ / np.linalg.norm(sum_), float(radius), solid_angle)


def _is_strip(image: SkyImage, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> bool:
    """True if the deep half of a region is a strip along the horizon."""
    depth = image.depth[rows, columns]
    deep = depth >= 0.5 * depth.max()
    elevation = image.elevation[rows[deep], 0]
    if elevation.min() > _STRIP_BELOW:
        return False
    height = len(np.unique(rows[deep])) * 180 / len(image.core)
    width = len(np.unique(columns[deep])) * 360 / image.core.shape[1]
    return bool(width > _STRIP_WIDTH and width > _STRIP * height)
