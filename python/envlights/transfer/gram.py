"""The inner products of all indirect images, a block of texels at a time.

An image has three rows, one for each channel, so that a basis serves all channels:

    Y = (3 k, texels),    G = Y Y^T = sum over blocks of Y_b Y_b^T

`k` images are fewer than their texels by a thousand times: all that a basis needs is in G.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._native import EnvLightsError
from envlights.transfer.pairs import Pairs, check_finite

#: Texels of a block, rounded to rows of the image. Products of a block are summed in the type of
#: the images and blocks in float64: in float32 that is wrong by 2e-8 of the largest eigenvalue.
#: A few hundred images of that many texels stay in the cache.
_BLOCK = 1024
#: Over fewer texels than this rounding does not average out, and float64 costs little.
_FEW = 2**16


@dataclass(frozen=True, eq=False)
class Gram:
    """What one look at every texel gives."""

    products: NDArray[np.float64]
    """Inner products of the rows, (3 k, 3 k), less their mean where that was asked for."""

    energy: NDArray[np.float64]
    """Sum of squares of each image, (k,), with the mean."""

    lit: NDArray[np.bool_]
    """Texels that are not black in every image, (H, W)."""


def gram(pairs: Pairs, centred: bool) -> Gram:
    """Inner products of the scaled indirect images; `centred`: less the mean of all rows."""
    rows = 3 * len(pairs.scale)
    products = np.zeros((rows, rows))
    energy = np.zeros(rows)
    lit = np.empty(pairs.indirect.shape[1:3], np.bool_)
    # What overflows, or is NaN, is refused below by its place.
    with np.errstate(over="ignore", invalid="ignore"):
        for where, block in blocks(pairs):
            is_lit = (block.min(axis=0) != 0) | (block.max(axis=0) != 0)
            lit[where] = is_lit.reshape(lit[where].shape)
            if centred:
                energy += np.einsum("ij,ij->i", block, block)
                block -= block.mean(axis=0)
            wide = block.astype(np.float64, copy=False) if lit.size < _FEW else block
            products += wide @ wide.T
    if not centred:
        energy = np.diagonal(products)
    if not np.isfinite(energy).all():
        _refuse(pairs)
    return Gram(products, energy.reshape(-1, 3).sum(axis=1), lit)


def blocks(pairs: Pairs) -> Iterator[tuple[slice, NDArray[Any]]]:
    """Rows of the image, and what is in them: (3 k, texels), scaled. Each may be written to."""
    images, height, width, _ = pairs.indirect.shape
    step = max(1, _BLOCK // width)
    scale = pairs.scale.astype(pairs.dtype)[:, None, None, None]
    for first in range(0, height, step):
        where = slice(first, min(first + step, height))
        part = np.moveaxis(pairs.indirect[:, where], -1, 1)
        block = np.empty(part.shape, pairs.dtype)
        np.multiply(part, scale, out=block, casting="same_kind")
        yield where, block.reshape(3 * images, -1)


def _refuse(pairs: Pairs) -> None:
    check_finite("indirect", pairs.indirect)
    raise EnvLightsError(
        f"the squares of indirect overflow {pairs.dtype}; scale the images down or give float64"
    )
