"""Blocks of texels, described by sums of the basis.

With the basis rows :math:`B_t` of the texels and the coefficients of the images, a block `b` has

    sums_b = sum over t in b of B_t,    spread_cb = sum over t in b of g_c(t) B_t .

The gain g distributes the light of a block over its texels. It is the ratio of the RMS of a texel
over all images to that of its block:

    g_c(t)^2 = sum over k of y_kc(t)^2 / sum over k of a_kc^2,
    a_kc = sum over t in b of y_kc(t) .

No image is read: the basis and the coefficients have all of this up to the truncation.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights.transfer.training.gram import product


@dataclass(frozen=True, eq=False)
class Blocks:
    """Square blocks of texels."""

    sums: NDArray[np.float64]
    """Sum of the basis over each block, (blocks, rank)."""

    spread: NDArray[np.float64]
    """Sum of the basis, weighted by the gains of each channel, (3, blocks, rank)."""


def blocks(
    basis: NDArray[Any],
    lit: NDArray[np.bool_],
    coefficients: NDArray[np.float64],
    most: int,
) -> Blocks:
    """Divide the image into at most `most` square blocks, whose side is a power of two."""
    side = _side(lit.shape, most)
    # Scale the coefficients, because their squares might underflow.
    unit = np.abs(coefficients).max(initial=0) or 1.0
    scaled = coefficients.swapaxes(0, 1) / unit
    moments = (scaled.swapaxes(1, 2) @ scaled).astype(basis.dtype)
    sums, spread = [], []
    for texels in _block_rows(basis, lit, side):
        own = texels.sum(axis=1, dtype=np.float64)
        square = np.einsum("cbr,br->bc", own @ moments, own)
        gains = _gains(texels, moments, square)
        sums.append(own)
        spread.append(gains.swapaxes(1, 2).astype(basis.dtype) @ texels)
    return Blocks(np.concatenate(sums), np.concatenate(spread).swapaxes(0, 1).astype(np.float64))


def _side(shape: tuple[int, ...], most: int) -> int:
    side = 1
    while np.prod([-(-length // side) for length in shape]) > most:
        side *= 2
    return side


def _block_rows(basis: NDArray[Any], lit: NDArray[np.bool_], side: int) -> Iterator[NDArray[Any]]:
    across, rank = -(-lit.shape[1] // side), basis.shape[1]
    end = 0
    for first in range(0, len(lit), side):
        rows = np.zeros((side, across * side), np.bool_)
        own = lit[first : first + side]
        rows[: len(own), : lit.shape[1]] = own
        texels = np.zeros((*rows.shape, rank), basis.dtype)
        begin, end = end, end + int(np.count_nonzero(own))
        texels[rows] = basis[begin:end]
        grouped = texels.reshape(side, across, side, rank).swapaxes(0, 1)
        yield grouped.reshape(across, side * side, rank)


def _gains(
    texels: NDArray[Any], moments: NDArray[Any], square: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Gain of each texel in each channel, (blocks, texels, 3); 0 in blocks that stay black."""
    flat = texels.reshape(-1, texels.shape[2])
    energy = [np.einsum("tr,tr->t", product(flat, moment), flat) for moment in moments]
    squares = np.stack(energy, axis=-1).reshape(*texels.shape[:2], 3).astype(np.float64)
    ratio = np.divide(
        np.maximum(squares, 0),
        square[:, None],
        out=np.zeros_like(squares),
        where=square[:, None] > 0,
    )
    gains: NDArray[np.float64] = np.sqrt(ratio)
    return gains
