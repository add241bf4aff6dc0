"""Values of integer codes, by a table."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights import _native


def look_up(codes: NDArray[Any], table: NDArray[np.float32]) -> NDArray[np.float32]:
    """Values of codes of 8 or 16 bits, (height, width, channels).

    `table` holds the value of each code, (n,), or (channels, n) with one row for each channel.
    """
    tables = np.ascontiguousarray(np.atleast_2d(table))
    if codes.dtype.itemsize == 1:
        return _native.decode_8(np.ascontiguousarray(codes, dtype=np.uint8), tables)
    return _native.decode_16(np.ascontiguousarray(codes, dtype=np.uint16), tables)
