"""Basis in int8 or float16, because reading the basis takes most of the time of a frame.

16 texels of a component share a scale, so that dark corners keep their digits. With the rounding
error `D`, a frame of the coefficients `a` is B a + D a. The columns of B are orthonormal, so

    |D a| / |B a| <= |D|_2,

the largest singular value of D, for any frame. It is computed from ``D^T D``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from envlights import _native
from envlights._common.result import Result
from envlights._common.words import percent

#: Texels in a tile, and texels with a common scale, as the kernel defines them.
TILE, SHARE = _native.BASIS_TILE, _native.BASIS_SHARE
#: Largest value before scaling, for each type in which a basis is stored, the most compact first.
LARGEST: dict[str, float] = {"int8": 127.0, "float16": 1.0}
#: Texels that are rounded at a time.
_BLOCK = 8192


@dataclass(frozen=True, eq=False, repr=False)
class CompactBasis(Result):
    """Orthonormal columns, rounded, stored in tiles of 32 texels of the image."""

    values: NDArray[Any]
    """int8 or float16, (tiles, rank, 32)."""

    scales: NDArray[np.float32]
    """Factor of the values in each half of a tile, (tiles, rank, 2)."""

    places: NDArray[np.int64]
    """Index into `values` for each tile of the image, or -1 for a black tile."""

    def in_short(self) -> str:
        """Type and size."""
        return f"{self.values.dtype}, {self.values.nbytes / 1e6:.3g} MB"

    @property
    def dtype(self) -> np.dtype[np.float32]:
        """Type of the expanded images."""
        return self.scales.dtype

    def expand(
        self,
        coefficients: NDArray[np.float64],
        shape: tuple[int, int],
        needed: NDArray[np.bool_] | None,
    ) -> NDArray[np.float32]:
        """Images of `coefficients` (n, 3, components), at least where `needed`: (n, H, W, 3)."""
        places = self.places
        if needed is not None:
            places = np.where(in_tiles(needed.ravel()).any(axis=1), places, -1)
        rows = np.ascontiguousarray(coefficients.swapaxes(1, 2), np.float32)
        out = _native.transfer_frames(self.values, self.scales, rows, places)
        return out[:, : shape[0] * shape[1]].reshape(len(out), *shape, 3)

    def dense(self, lit: NDArray[np.bool_]) -> NDArray[np.float32]:
        """Columns over the lit texels, (lit texels, rank)."""
        tiles = self.values * np.repeat(self.scales, SHARE, axis=2)
        rows: NDArray[np.float32] = tiles.swapaxes(1, 2)[in_tiles(lit.ravel())[self.places >= 0]]
        return rows


def compress(
    basis: NDArray[Any], lit: NDArray[np.bool_], coefficients: NDArray[np.float64], error: float
) -> tuple[NDArray[Any] | CompactBasis, str]:
    """Most compact basis that stays within the `error`, and a note on the choice.

    `coefficients` of the pairs, (k, 3, rank), give their own error for the note.
    """
    energy = np.einsum("kcr,kcs->rs", coefficients, coefficients)
    for dtype in LARGEST:
        # Round, and bound the change of every frame by the largest singular value of the rounding
        # error.
        compact, wrong = round_basis(basis, lit, dtype)
        most = np.sqrt(np.linalg.eigvalsh(wrong)[-1])
        if most <= error:
            usual = np.sqrt(np.sum(wrong * energy) / np.trace(energy))
            return compact, (
                f"the basis is stored as {dtype}: no frame changes by more than"
                f" {percent(most, 2)} of its norm, and the pairs change by {percent(usual, 2)}"
            )
    return basis, f"the basis is not compressed: {' and '.join(LARGEST)} exceed the error {error:g}"


def round_basis(
    basis: NDArray[Any], lit: NDArray[np.bool_], dtype: str
) -> tuple[CompactBasis, NDArray[np.float64]]:
    """Basis (lit texels, rank) in `dtype`, and ``D^T D`` of its rounding error."""
    places = places_of(lit)
    rank = basis.shape[1]
    values = np.empty((places.max() + 1, rank, TILE), dtype)
    scales = np.empty((*values.shape[:2], TILE // SHARE), np.float32)
    wrong = np.zeros((rank, rank))
    end = 0
    for tiles in _tiles(basis, lit):
        begin, end = end, end + len(tiles)
        values[begin:end], scales[begin:end] = _round_tiles(tiles, dtype)
        change = values[begin:end] * np.repeat(scales[begin:end], SHARE, axis=2) - tiles
        rows = change.swapaxes(0, 1).reshape(rank, -1).astype(np.float64)
        wrong += rows @ rows.T
    return CompactBasis(values, scales, places), wrong


def _round_tiles(tiles: NDArray[Any], dtype: DTypeLike) -> tuple[NDArray[Any], NDArray[np.float32]]:
    """Tiles (n, rank, 32) rounded to `dtype`, and their scales."""
    largest = np.abs(tiles).reshape(*tiles.shape[:2], TILE // SHARE, SHARE).max(axis=3)
    scales = (largest / LARGEST[np.dtype(dtype).name]).astype(np.float32)
    inverse = np.divide(1.0, scales, out=np.zeros(scales.shape), where=scales > 0)
    values = tiles * np.repeat(inverse, SHARE, axis=2)
    return (np.rint(values) if np.dtype(dtype).kind == "i" else values).astype(dtype), scales


def _tiles(basis: NDArray[Any], lit: NDArray[np.bool_]) -> Iterator[NDArray[Any]]:
    """Lit tiles in batches, (n, rank, 32); black texels are 0."""
    flat = lit.ravel()
    end = 0
    for first in range(0, flat.size, _BLOCK):
        here = flat[first : first + _BLOCK]
        block = np.zeros((-(-len(here) // TILE) * TILE, basis.shape[1]), basis.dtype)
        begin, end = end, end + int(np.count_nonzero(here))
        block[: len(here)][here] = basis[begin:end]
        tiles = block.reshape(-1, TILE, basis.shape[1]).swapaxes(1, 2)
        yield tiles[in_tiles(here).any(axis=1)]


def places_of(lit: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Index of each tile of the image among the lit tiles, or -1."""
    lit_tiles = in_tiles(lit.ravel()).any(axis=1)
    return np.where(lit_tiles, np.cumsum(lit_tiles) - 1, -1)


def in_tiles(texels: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Mask of texels by tile, (tiles, 32); the last tile is padded."""
    return np.pad(texels, (0, -len(texels) % TILE)).reshape(-1, TILE)
