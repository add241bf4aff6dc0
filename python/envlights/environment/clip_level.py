"""Clip level of a picture of integer codes, from its histogram."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._common.srgb import decode_srgb

#: Codes from here on count as the largest value of the format, which JPEG compression blurs.
_FULL = 254


class CodeHistogram:
    """Histogram of the brightest channel, by solid angle and 8-bit code; rows come in any order."""

    def __init__(self, height: int) -> None:
        edges = np.cos(np.linspace(0, np.pi, height + 1))
        self._weights = edges[:-1] - edges[1:]
        self.sums = np.zeros(256)

    def add(self, codes: NDArray[Any], top: int = 0) -> None:
        """Add uint8 or uint16 codes, (rows, width, channels); `top` is the first row's index."""
        weights = np.ascontiguousarray(self._weights[top : top + len(codes)])
        if codes.dtype.itemsize == 1:
            self.sums += _native.code_histogram_8(codes.astype(np.uint8, copy=False), weights)
        else:
            self.sums += _native.code_histogram_16(codes.astype(np.uint16, copy=False), weights)

    def white_code(self) -> int:
        """Code from 0 to 255 at which the picture is clipped; 255 if it is not clipped."""
        code = _native.white_code(self.sums)
        return 255 if code is None or code >= _FULL else code


def white_of(histogram: CodeHistogram, table: NDArray[np.float32]) -> tuple[float, list[str]]:
    """Linear clip level, and a note if it is below the largest code.

    `table` holds the linear value of each code, (n,) or (3, n).
    """
    code = histogram.white_code()
    value = float(table[..., code * (table.shape[-1] - 1) // 255].max())
    notes = (
        [] if code == 255 else [f"the picture is clipped at code {code} of 255, by its histogram"]
    )
    return value, notes


def clip_level_of_codes(
    codes: NDArray[Any], coverage: NDArray[np.float32] | None, notes: list[str]
) -> float:
    """Linear clip level of sRGB codes, (..., height, width, 3); adds a note if it is below 1.

    Pixels with a `coverage` share of 0 do not count.
    """
    if coverage is not None:
        codes = np.where(coverage[..., None] > 0, codes, 0).astype(codes.dtype, copy=False)
    rows = codes.reshape(-1, *codes.shape[-2:])
    histogram = CodeHistogram(len(rows))
    histogram.add(rows)
    clip_level, said = white_of(histogram, decode_srgb(np.linspace(0, 1, 256)))
    notes += said
    return clip_level
