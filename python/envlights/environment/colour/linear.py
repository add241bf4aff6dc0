"""Samples of a file as linear Rec.709, by transfer curve, header exposure and primaries."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._common.srgb import look_up
from envlights._common.words import percent
from envlights.environment.colour.choice import ColourConversion
from envlights.environment.decoders.raw_image import Header

#: Number of rows that are converted at once from floating point, to limit memory.
_ROWS_AT_ONCE = 64


class Linear:
    """Conversion of rows of samples to linear Rec.709, which counts pixels outside the gamut."""

    def __init__(
        self,
        header: Header,
        conversion: ColourConversion,
        apply_gain_map: Callable[[NDArray[np.float32], int], None] | None = None,
    ) -> None:
        self._conversion, self._gain_map = conversion, apply_gain_map
        self._bits = 8 * header.dtype.itemsize
        exposure = np.asarray(header.exposure, np.float32)
        self._divisor = None if (exposure == 1).all() else exposure
        matrix = conversion.matrix
        self._matrix = None if matrix is None else matrix.tolist()
        self._pixels = self._outside = 0

    def __call__(
        self, samples: NDArray[Any], out: NDArray[np.float32] | None = None, top: int = 0
    ) -> NDArray[np.float32]:
        """Linear values, (rows, width, 3), of red, green and blue or of one grey channel.

        `top` is the first row of the samples.

        They are written into `out` if it is given. Negative results of the matrix become 0. Floats
        without a conversion are not copied.
        """
        is_grey = samples.shape[2] == 1
        linear = self._decode(samples, None if is_grey or self._matrix is not None else out)
        if self._gain_map:
            self._gain_map(linear, top)
        if self._divisor is not None:
            linear = linear / self._divisor[: linear.shape[2]]
        if not is_grey and self._matrix is not None:
            linear, outside = _native.apply_matrix(np.ascontiguousarray(linear), self._matrix)
            self._outside += outside
            self._pixels += linear.shape[0] * linear.shape[1]
        if out is None:
            return np.repeat(linear, 3, axis=2) if is_grey else linear
        if linear is not out:
            out[...] = linear
        return out

    @property
    def notes(self) -> tuple[str, ...]:
        """Note on the fraction of pixels so far outside Rec.709; empty if there are none."""
        if not self._outside:
            return ()
        fraction = percent(self._outside / self._pixels, 2)
        return (f"{fraction} of the pixels lay outside Rec.709; their negative channels became 0",)

    def _decode(
        self, samples: NDArray[Any], out: NDArray[np.float32] | None
    ) -> NDArray[np.float32]:
        """Linear values in the primaries of the file, in `out` if given and newly computed."""
        if samples.dtype.kind == "u":
            return self._look_up(samples, self._table, out)
        curve = self._conversion.curve
        if samples.dtype == np.float16:
            if curve is None:
                return _widen(samples, out)
            bits = np.ascontiguousarray(samples).view(np.uint16)
            return self._look_up(bits, self._table_of_halves, out)
        if curve is None:
            return samples.astype(np.float32, copy=False)
        return _in_blocks(lambda part: curve(part.astype(np.float64)), samples)

    def _look_up(
        self, codes: NDArray[Any], table: NDArray[np.float32], out: NDArray[np.float32] | None
    ) -> NDArray[np.float32]:
        """Table values of codes; a grey channel uses the curve of green."""
        is_grey = table.ndim == 2 and codes.shape[2] == 1
        return look_up(codes, table[1] if is_grey else table, out)

    @cached_property
    def _table(self) -> NDArray[np.float32]:
        return self._conversion.table(self._bits)

    @cached_property
    def _table_of_halves(self) -> NDArray[np.float32]:
        """Linear value of each half-precision bit pattern."""
        halves = np.arange(1 << 16, dtype=np.uint16).view(np.float16)
        return self._conversion.values(halves.astype(np.float64))


def _widen(halves: NDArray[np.float16], out: NDArray[np.float32] | None) -> NDArray[np.float32]:
    """Half floats in single precision, in `out` if given."""
    values = np.empty(halves.shape, np.float32) if out is None else out
    _native.widen(np.ascontiguousarray(halves), values)
    return values


def _in_blocks(
    values: Callable[[NDArray[Any]], NDArray[Any]], samples: NDArray[Any]
) -> NDArray[np.float32]:
    """Converted floating-point samples, computed a few rows at a time to limit memory."""
    linear = np.empty(samples.shape, np.float32)
    for top in range(0, len(samples), _ROWS_AT_ONCE):
        rows = slice(top, top + _ROWS_AT_ONCE)
        with np.errstate(all="ignore"):
            linear[rows] = values(samples[rows])
    return linear
