"""Outlines of the pixels of lights."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def outlines(number: NDArray[np.int64]) -> NDArray[np.float64]:
    """Boundary segments between unequal pixels, (n, 2, 2), with ends as (column, row).

    Pixels outside the image count as number 0. Edges in
    one line are one segment.
    """
    padded = np.pad(number, 1)
    upright = _runs((padded[1:-1, 1:] != padded[1:-1, :-1]).T)
    level = _runs(padded[1:, 1:-1] != padded[:-1, 1:-1])
    return np.concatenate([upright, level[..., ::-1]]).astype(np.float64)


def _runs(edges: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Runs along rows, as end points (row, first) and (row, end), (n, 2, 2)."""
    steps = np.diff(np.pad(edges, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    row, first = np.nonzero(steps == 1)
    _, end = np.nonzero(steps == -1)
    return np.stack([np.stack([row, first], axis=1), np.stack([row, end], axis=1)], axis=1)
