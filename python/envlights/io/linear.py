"""Samples of a file as linear Rec.709: transfer curve, exposure of the header, primaries."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights.io.colour import ColourConversion
from envlights.io.raw_image import Header


class Linear:
    """Function from samples of some rows to linear Rec.709."""

    def __init__(self, header: Header, conversion: ColourConversion) -> None:
        self._conversion = conversion
        is_integer = header.dtype.kind == "u"
        self._table = conversion.table(8 * header.dtype.itemsize) if is_integer else None
        exposure = np.asarray(header.exposure, np.float32)
        self._divisor = None if (exposure == 1).all() else exposure
        matrix = conversion.matrix
        self._matrix = None if matrix is None else np.asarray(matrix.T, np.float32)

    def __call__(self, samples: NDArray[Any]) -> NDArray[np.float32]:
        """Linear values, (rows, width, 3), of red, green and blue or of one grey channel."""
        linear = self._decoded(samples)
        if linear.shape[2] == 1:
            return np.repeat(linear, 3, axis=2)
        if self._divisor is not None:
            linear = linear / self._divisor
        return linear if self._matrix is None else linear @ self._matrix

    def _decoded(self, samples: NDArray[Any]) -> NDArray[np.float32]:
        """Linear values in the primaries of the file."""
        if self._table is not None:
            return _looked_up(samples, self._table)
        values = samples.astype(np.float32, copy=False)
        curve = self._conversion.curve
        return values if curve is None else np.asarray(curve(values), np.float32)


def _looked_up(codes: NDArray[Any], table: NDArray[np.float32]) -> NDArray[np.float32]:
    """Values of codes; `table` is (codes,), or (3, codes) for one of each channel."""
    if table.ndim == 2 and codes.shape[2] == 1:
        table = table[1]
    if table.ndim == 2:
        return np.stack([table[c][codes[..., c]] for c in range(3)], axis=2)
    if codes.shape[2] != 3:
        return table[codes]
    table, codes = np.ascontiguousarray(table), np.ascontiguousarray(codes)
    return _native.decode_8(codes, table) if codes.itemsize == 1 else _native.decode_16(codes, table)
