"""Maps on other pixels: turned by whole columns, or with cells in place of samples on the border.

A map is piecewise constant here: a pixel stands for its cell, as in the exact probe. Flux is kept.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights.kernels import sphere

#: How far a turn may be from whole columns.
_TOLERANCE = 1e-6


def turned_by_columns(
    radiance: NDArray[np.float32], matrix: NDArray[np.float64], *, border_sampled: bool
) -> NDArray[np.float32] | None:
    """The map after a turn about the pole by whole columns, without loss; None for other turns."""
    if abs(matrix[1, 1] - 1) > _TOLERANCE**2:
        return None
    # Columns of border-sampled maps lie on the seam twice.
    own = radiance[:, :-1] if border_sampled else radiance
    ((u, _),) = sphere.direction_to_uv([matrix @ [0, 0, -1]])
    columns = round(u * own.shape[1])
    if abs(u * own.shape[1] - columns) > _TOLERANCE:
        return None
    turned = np.roll(own, columns, axis=1)
    return np.concatenate([turned, turned[:, :1]], axis=1) if border_sampled else turned


def cells_of_borders(radiance: NDArray[np.float32]) -> NDArray[np.float32]:
    """A border-sampled map as that many cells; each new cell is the mean of what it covers.

    Rows and columns are averaged one after the other, over the cosine and over the azimuth.
    """
    height, width, _ = radiance.shape
    row_edges = np.cos(np.pi * _border_edges(height))
    rows = _overlaps(row_edges, np.cos(np.pi * np.linspace(0, 1, height + 1)))
    columns = _overlaps(_border_edges(width), np.linspace(0, 1, width + 1))
    new = np.einsum("yr,rcn,xc->yxn", rows, radiance, columns, optimize=True)
    return np.ascontiguousarray(np.maximum(new, 0), np.float32)


def _border_edges(samples: int) -> NDArray[np.float64]:
    """Edges of the cells of samples at 0 to 1, the first and the last of which are halves."""
    between = (np.arange(samples - 1) + 0.5) / (samples - 1)
    return np.concatenate([[0.0], between, [1.0]])


def _overlaps(old: NDArray[np.float64], new: NDArray[np.float64]) -> NDArray[np.float64]:
    """Share of each new interval that each old one covers, (new, old), from their edges."""
    low, high = np.minimum(old[:-1], old[1:]), np.maximum(old[:-1], old[1:])
    start, end = np.minimum(new[:-1], new[1:]), np.maximum(new[:-1], new[1:])
    common = np.minimum(end[:, None], high) - np.maximum(start[:, None], low)
    shares: NDArray[np.float64] = np.maximum(common, 0) / (end - start)[:, None]
    return shares
