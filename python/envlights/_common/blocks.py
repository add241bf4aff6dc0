"""Work on large arrays in blocks of rows.

Python handles Ctrl-C between NumPy operations, and one operation on a large map takes seconds.
Blocks also keep temporary arrays small.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Number of elements in a block; an operation on a block takes milliseconds.
_NUMBERS = 2**18


def blocks(shape: tuple[int, ...]) -> Iterator[slice]:
    """Row slices that divide an array of this shape into blocks."""
    rows = max(_NUMBERS // max(math.prod(shape[1:]), 1), 1)
    for first in range(0, shape[0], rows):
        yield slice(first, min(first + rows, shape[0]))


def in_blocks(shape: tuple[int, ...], value: Callable[[slice], NDArray[Any]]) -> NDArray[Any]:
    """Array of this shape, filled block by block with `value(rows)` for each row slice."""
    out: NDArray[Any] | None = None
    for rows in blocks(shape):
        part = value(rows)
        if out is None:
            out = np.empty((shape[0], *part.shape[1:]), part.dtype)
        out[rows] = part
    return value(slice(0, 0)) if out is None else out
