"""Large arrays some rows at a time.

Python looks for Ctrl-C between two operations of NumPy, and an operation on a large map takes
seconds. In blocks, what is computed on the way also takes little memory.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Numbers of a block: a few operations on them take milliseconds.
_NUMBERS = 2**18


def blocks(shape: tuple[int, ...]) -> Iterator[slice]:
    """Slices of the rows of an array of this shape, a block in each."""
    rows = max(_NUMBERS // max(math.prod(shape[1:]), 1), 1)
    for first in range(0, shape[0], rows):
        yield slice(first, min(first + rows, shape[0]))


def in_blocks(shape: tuple[int, ...], value: Callable[[slice], NDArray[Any]]) -> NDArray[Any]:
    """One array of the results of `value` for each slice of the rows of an array of this shape."""
    out: NDArray[Any] | None = None
    for rows in blocks(shape):
        part = value(rows)
        if out is None:
            out = np.empty((shape[0], *part.shape[1:]), part.dtype)
        out[rows] = part
    return value(slice(0, 0)) if out is None else out
