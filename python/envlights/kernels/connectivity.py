"""Connected regions of pixels of an equirectangular image."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def connected_regions(
    rows: NDArray[np.intp], columns: NDArray[np.intp], size: tuple[int, ...]
) -> NDArray[np.intp]:
    """Label of the connected region of each pixel, across the seam and the poles.

    The pixels are in the order of memory; `size` is the shape of the image.
    """
    pairs = _pairs(rows, columns, size)
    label = np.arange(len(rows))
    while True:
        low = label[pairs].min(axis=0)
        joined = label.copy()
        # Set each label to the smallest neighbouring label, then follow the links to their ends.
        for end in pairs:
            np.minimum.at(joined, label[end], low)
        while (joined != joined[joined]).any():
            joined = joined[joined]
        joined = joined[label]
        if (joined == label).all():
            break
        label = joined
    numbers: NDArray[np.intp] = np.unique(label, return_inverse=True)[1]
    return numbers


def _pairs(
    rows: NDArray[np.intp], columns: NDArray[np.intp], size: tuple[int, ...]
) -> NDArray[np.intp]:
    """Indices of neighbours among pixels in the order of memory, (2, n)."""
    height, width = size[:2]
    flat = rows * width + columns
    pairs = []
    for down, right in ((0, 1), (1, -1), (1, 0), (1, 1)):
        beside = (rows + down) * width + (columns + right) % width
        at = np.minimum(np.searchsorted(flat, beside), max(len(flat) - 1, 0))
        found = np.flatnonzero((flat[at] == beside) & (rows + down < height))
        pairs.append(np.stack([found, at[found]]))
    # Join all pixels at a pole.
    for row in (0, height - 1):
        polar = np.flatnonzero(rows == row)
        pairs.append(np.stack([polar, np.broadcast_to(polar[:1], polar.shape)]))
    return np.concatenate(pairs, axis=1)
