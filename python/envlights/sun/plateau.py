"""Luminance of the sky behind the sun, for the pixels of its clipped region."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights.kernels.image import LUMINANCE
from envlights.kernels.sphere import uv_to_direction
from envlights.sun.sky_fit import SkyFit

#: Largest luminance of the filled sky, relative to the clip level.
_MOST = 20.0


def plateau_of(
    radiance: NDArray[np.float32],
    border_sampled: bool,
    clip_level: float,
    part: NDArray[np.bool_],
    fit: SkyFit | None,
) -> NDArray[np.float32]:
    """Luminance of the sky behind the sun in the clipped pixels of a region; 0 elsewhere.

    `part` is a mask of cells. The luminance is at least that of the pixel, and that of the `fit`
    of the sky where it is more.
    """
    height, width = radiance.shape[:2]
    v, u = _places(height, border_sampled), _places(width, border_sampled)
    rows = np.minimum((v * len(part)).astype(int), len(part) - 1)
    columns = (u * part.shape[1]).astype(int) % part.shape[1]
    plateau = np.zeros((height, width), np.float32)
    for row in np.flatnonzero(np.asarray(part.any(axis=1))[rows]):
        clipped = radiance[row].max(axis=1) >= np.float32(_native.LEAST_WHITE * clip_level)
        own = np.flatnonzero(part[rows[row], columns] & clipped)
        level = radiance[row, own] @ LUMINANCE
        if fit is not None and len(own):
            places = np.stack([u[own], np.full(len(own), v[row])], axis=1)
            level = np.maximum(
                level, clip_level * np.minimum(fit.luminance(uv_to_direction(places)), _MOST)
            )
        plateau[row, own] = level
    return plateau


def _places(count: int, border_sampled: bool) -> NDArray[np.float64]:
    """Coordinates of the rows or columns, from 0 to 1."""
    if border_sampled:
        return np.arange(count) / (count - 1)
    return (np.arange(count) + 0.5) / count
