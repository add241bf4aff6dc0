"""Resampling of maps: other layouts, rotation, and conversion of border samples to cells.

A map is constant in each pixel, as in the exact probe. Flux is preserved, and so are the flux and
the direction of each bright pixel.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._common.blocks import in_blocks
from envlights.environment.layouts import picture_layout as layouts
from envlights.environment.layouts.picture_layout import PictureLayout
from envlights.kernels import sphere

#: Identity rotation.
UNTURNED = np.eye(3)

#: Default limit on the columns of a map made from a photograph or disc: 400 MB of radiance.
_MOST_COLUMNS = 8192

#: Tolerance for a rotation by whole columns.
_TOLERANCE = 1e-6


def rotate(
    radiance: NDArray[np.float32],
    coverage: NDArray[np.float32] | None,
    matrix: NDArray[np.float64],
    *,
    border_sampled: bool,
) -> tuple[NDArray[np.float32], NDArray[np.float32] | None, bool]:
    """Rotated radiance and coverage, and True if the map is still border-sampled."""
    shifted = turned_by_columns(radiance, matrix, border_sampled=border_sampled)
    if shifted is not None:
        fraction = None
        if coverage is not None:
            fraction = turned_by_columns(coverage, matrix, border_sampled=border_sampled)
        return shifted, fraction, border_sampled
    source = layouts.equirectangular(*radiance.shape[:2], border_sampled=border_sampled)
    target = source._replace(border_sampled=False)
    return *resample(radiance, coverage, source, target, matrix), False


def resample(
    radiance: NDArray[np.float32],
    coverage: NDArray[np.float32] | None,
    source: PictureLayout,
    target: PictureLayout,
    matrix: NDArray[np.float64] = UNTURNED,
) -> tuple[NDArray[np.float32], NDArray[np.float32] | None]:
    """Picture in another layout, rotated so that the light from d comes from ``matrix @ d``.

    Parameters
    ----------
    radiance : ndarray of float32, shape (source.height, source.width, 3)
        Multiplied by `coverage`.
    coverage : ndarray of float32, shape (source.height, source.width), optional
        Fraction of each pixel that is seen.
    source, target : PictureLayout
        Layouts; `target` has cells if it is equirectangular.
    matrix : ndarray, shape (3, 3)
        A rotation.

    Returns
    -------
    radiance, coverage : ndarray of float32
        In the layout `target`; `coverage` is None if all is seen.
    """
    if source.kind == "equirectangular" and source.border_sampled:
        radiance, source = cells_of_borders(radiance), source._replace(border_sampled=False)
        coverage = None if coverage is None else cells_of_borders(coverage[..., None])[..., 0]
    if np.array_equal(matrix, UNTURNED):
        if source == target:
            return radiance, coverage
        if _share_cells(source, target):
            return _same_cells(radiance, coverage, source, target)
    image, fraction = _native.resample(radiance, coverage, source, target, matrix)
    return image, None if fraction is None or (fraction == 1).all() else fraction.clip(0, 1)


def _share_cells(source: PictureLayout, target: PictureLayout) -> bool:
    """True if both are panoramas, complete or cropped, on the same pixel grid."""
    if source.kind != "equirectangular" or target.kind != source.kind or source.axes != target.axes:
        return False
    wholes = [layout.whole or (layout.height, layout.width) for layout in (source, target)]
    return wholes[0] == wholes[1] and not (source.border_sampled or target.border_sampled)


def _same_cells(
    radiance: NDArray[np.float32],
    coverage: NDArray[np.float32] | None,
    source: PictureLayout,
    target: PictureLayout,
) -> tuple[NDArray[np.float32], NDArray[np.float32] | None]:
    """Pixels of a panorama crop copied into another crop, unchanged."""
    columns = (source.whole or (source.height, source.width))[1]
    row = np.arange(target.height) + target.corner[0] - source.corner[0]
    column = (np.arange(target.width) + target.corner[1] - source.corner[1]) % columns
    is_row, is_column = (row >= 0) & (row < source.height), column < source.width
    there, here = np.ix_(is_row, is_column), np.ix_(row[is_row], column[is_column])
    image = np.zeros((target.height, target.width, 3), np.float32)
    fraction = np.zeros(image.shape[:2], np.float32)
    image[there] = radiance[here]
    fraction[there] = 1 if coverage is None else coverage[here]
    return image, None if (fraction == 1).all() else fraction


def default_width(layout: PictureLayout) -> int:
    """Columns of a map whose equator pixels are as large as the mean pixel of a picture.

    Photographs and discs give at most 8192: a camera's 24 megapixels would give a map of 6 GB.
    """
    if layout.kind == "equirectangular":
        return 2 * (layout.whole[0] if layout.whole else layout.height)
    if layout.kind == "cube":
        return max(4 * layout.width, 4)
    angles = _native.projection_solid_angles(layout)
    whole_sphere = 4 * np.pi * np.count_nonzero(angles) / float(angles.sum())
    columns = 2 * round(float(np.sqrt(np.pi * whole_sphere)) / 2)
    return min(max(columns, 4), _MOST_COLUMNS)


def on_sphere(
    radiance: NDArray[np.float32],
    coverage: NDArray[np.float32] | None,
    layout: PictureLayout,
    width: int | None,
) -> tuple[NDArray[np.float32], NDArray[np.float32] | None, bool]:
    """Equirectangular radiance and coverage of any picture, and True if border-sampled.

    A whole equirectangular picture stays as it is, unless another `width` is given.
    """
    is_map = layout.is_whole_sphere and layout.width == 2 * layout.height
    if is_map and width in (None, layout.width):
        return radiance, coverage, layout.border_sampled
    columns = default_width(layout) if width is None else width
    target = layouts.equirectangular(columns // 2)
    return *resample(radiance, coverage, layout, target), False


def turned_by_columns(
    radiance: NDArray[np.float32], matrix: NDArray[np.float64], *, border_sampled: bool
) -> NDArray[np.float32] | None:
    """Map rotated about the pole by whole columns, without loss; None for other rotations."""
    if abs(matrix[1, 1] - 1) > _TOLERANCE**2:
        return None
    # Drop the last column of a border-sampled map, which equals the first.
    own = radiance[:, :-1] if border_sampled else radiance
    ((u, _),) = sphere.direction_to_uv([matrix @ [0, 0, -1]])
    columns = round(u * own.shape[1])
    if abs(u * own.shape[1] - columns) > _TOLERANCE:
        return None
    turned = np.roll(own, columns, axis=1)
    return np.concatenate([turned, turned[:, :1]], axis=1) if border_sampled else turned


def cells_of_borders(radiance: NDArray[np.float32]) -> NDArray[np.float32]:
    """Convert a border-sampled map with any number of channels to cells, by means over areas.

    Rows and columns are averaged one after the other, over the cosine and over the azimuth.
    """
    height, width = radiance.shape[:2]
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
    """Edges between border samples, from 0 to 1; the first and last cell have half the width."""
    between = (np.arange(samples - 1) + 0.5) / (samples - 1)
    return np.concatenate([[0.0], between, [1.0]])


def _cell_edges(cells: int) -> NDArray[np.float64]:
    return np.linspace(0, 1, cells + 1)


def _shares(old: NDArray[np.float64], new: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weights of the old intervals before, at and after each new interval, (n, 3).

    No new interval overlaps other old ones.
    """
    ends = np.pad(old, 1, mode="edge")  # no interval before the first and after the last
    low, high = np.minimum(ends[:-1], ends[1:]), np.maximum(ends[:-1], ends[1:])
    start, end = np.minimum(new[:-1], new[1:])[:, None], np.maximum(new[:-1], new[1:])[:, None]
    near = np.arange(len(new) - 1)[:, None] + np.arange(3)
    common = np.minimum(end, high[near]) - np.maximum(start, low[near])
    shares: NDArray[np.float64] = np.maximum(common, 0) / (end - start)
    return shares
