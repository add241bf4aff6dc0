"""Resampling of maps: rotation, and cells in place of samples on the border.

A map is constant in each pixel, as in the exact probe. Flux is preserved.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._blocks import in_blocks
from envlights.kernels import sphere

#: Tolerance of a rotation by whole columns.
_TOLERANCE = 1e-6


def rotate(
    radiance: NDArray[np.float32], matrix: NDArray[np.float64], *, border_sampled: bool
) -> tuple[NDArray[np.float32], bool]:
    """Rotated radiance, and True if its outer pixels still lie on the seam and the poles."""
    shifted = turned_by_columns(radiance, matrix, border_sampled=border_sampled)
    if shifted is not None:
        return shifted, border_sampled
    cells = cells_of_borders(radiance) if border_sampled else radiance
    return _native.rotate_map(cells, matrix), False


def turned_by_columns(
    radiance: NDArray[np.float32], matrix: NDArray[np.float64], *, border_sampled: bool
) -> NDArray[np.float32] | None:
    """Map after a rotation about the pole by whole columns, without loss; None for others."""
    if abs(matrix[1, 1] - 1) > _TOLERANCE**2:
        return None
    # The first and last column of a border-sampled map are the same.
    own = radiance[:, :-1] if border_sampled else radiance
    ((u, _),) = sphere.direction_to_uv([matrix @ [0, 0, -1]])
    columns = round(u * own.shape[1])
    if abs(u * own.shape[1] - columns) > _TOLERANCE:
        return None
    turned = np.roll(own, columns, axis=1)
    return np.concatenate([turned, turned[:, :1]], axis=1) if border_sampled else turned


def cells_of_borders(radiance: NDArray[np.float32]) -> NDArray[np.float32]:
    """Convert a border-sampled map to cells; each is the mean over its area.

    Rows and columns are averaged one after the other, over the cosine and over the azimuth.
    """
    height, width, _ = radiance.shape
    rows = _shares(np.cos(np.pi * _border_edges(height)), np.cos(np.pi * _cell_edges(height)))
    columns = _shares(_border_edges(width), _cell_edges(width))

    def cells(some: slice) -> NDArray[np.float32]:
        lines = _average(radiance, rows, np.arange(some.start, some.stop))
        new = _average(lines.swapaxes(0, 1), columns, np.arange(width)).swapaxes(0, 1)
        return np.maximum(new, 0).astype(np.float32)

    return in_blocks(radiance.shape, cells)


def _average(
    values: NDArray[np.floating], shares: NDArray[np.float64], at: NDArray[np.intp]
) -> NDArray[np.float64]:
    """Weighted means of three neighbours along the first axis."""
    mean = np.zeros((len(at), *values.shape[1:]))
    for step in (-1, 0, 1):
        near = values[np.clip(at + step, 0, len(values) - 1)]
        mean += shares[at, step + 1, None, None] * near
    return mean


def _border_edges(samples: int) -> NDArray[np.float64]:
    """Edges of the cells of samples from 0 to 1; the first and the last cell are halves."""
    between = (np.arange(samples - 1) + 0.5) / (samples - 1)
    return np.concatenate([[0.0], between, [1.0]])


def _cell_edges(cells: int) -> NDArray[np.float64]:
    return np.linspace(0, 1, cells + 1)


def _shares(old: NDArray[np.float64], new: NDArray[np.float64]) -> NDArray[np.float64]:
    """Fraction of each new interval in the old interval before, at and after it, (n, 3).

    No new interval overlaps other old ones.
    """
    ends = np.pad(old, 1, mode="edge")  # no interval before the first and after the last
    low, high = np.minimum(ends[:-1], ends[1:]), np.maximum(ends[:-1], ends[1:])
    start, end = np.minimum(new[:-1], new[1:])[:, None], np.maximum(new[:-1], new[1:])[:, None]
    near = np.arange(len(new) - 1)[:, None] + np.arange(3)
    common = np.minimum(end, high[near]) - np.maximum(start, low[near])
    shares: NDArray[np.float64] = np.maximum(common, 0) / (end - start)
    return shares
