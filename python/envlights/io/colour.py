"""Conversion of samples to linear Rec.709: curve, primaries and white of a file."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights._srgb import decode_srgb
from envlights.io.raw_image import Header


class ColourConversion(NamedTuple):
    """Steps from samples to linear Rec.709."""

    curve: Callable[[NDArray[Any]], NDArray[Any]] | None
    """Linear values of codes from 0 to 1; None for samples that are linear."""

    matrix: NDArray[np.float64] | None
    """Linear RGB of the file to linear Rec.709, (3, 3); None for Rec.709."""

    white: float | None
    """Linear value of the largest code; None for floating point."""

    notes: tuple[str, ...]
    """Remarks on what is converted."""

    def table(self, bits: int) -> NDArray[np.float32]:
        """Linear value of each code."""
        codes = np.arange(1 << bits) / ((1 << bits) - 1)
        return np.asarray(codes if self.curve is None else self.curve(codes), dtype=np.float32)


def conversion(header: Header, colour: str | None) -> ColourConversion:
    """Conversion that a file asks for, or `colour` by hand."""
    del colour
    if header.dtype.kind == "f":
        return ColourConversion(None, None, None, ())
    return ColourConversion(decode_srgb, None, 1.0, ("integer samples were decoded from sRGB",))
