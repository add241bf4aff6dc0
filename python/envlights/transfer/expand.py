"""From coefficients to images and back, a block of texels at a time."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Texels of a block: the rows of a few images stay in the cache until they are in place.
_BLOCK = 4096


def expand(
    coefficients: NDArray[np.float64],
    basis: NDArray[Any],
    lit: NDArray[np.bool_],
    mean: NDArray[Any],
    norm: NDArray[np.float64],
) -> NDArray[Any]:
    """Images of `coefficients` (n, 3, rank), black where not `lit`: (n, H, W, 3).

    A `mean` that is not empty is added `norm` times.
    """
    images = len(coefficients)
    rows = coefficients.reshape(3 * images, -1).astype(basis.dtype)
    shares = np.repeat(norm, 3).astype(basis.dtype)
    out = np.zeros((images, lit.size, 3), basis.dtype)
    for kept, texels in _blocks(lit):
        block = basis[kept] @ rows.T
        if len(mean):
            block += mean[kept, None] * shares
        out[:, texels] = block.reshape(-1, images, 3).swapaxes(0, 1)
    return out.reshape(images, *lit.shape, 3)


def gather(
    images: NDArray[Any], basis: NDArray[Any], lit: NDArray[np.bool_], mean: NDArray[Any]
) -> NDArray[np.float64]:
    """Coefficients of images (n, H, W, 3) less the `mean`: (n, 3, rank)."""
    flat = images.reshape(len(images), -1, 3)
    coefficients = np.zeros((3 * len(images), basis.shape[1]))
    for kept, texels in _blocks(lit):
        block = flat[:, texels].swapaxes(1, 2).reshape(3 * len(images), -1).astype(basis.dtype)
        if len(mean):
            block -= mean[kept]
        coefficients += block @ basis[kept]
    return coefficients.reshape(len(images), 3, -1)


def _blocks(lit: NDArray[np.bool_]) -> list[tuple[slice, Any]]:
    """Rows of the basis, and the texels that they are, by number or as a slice."""
    starts = range(0, np.count_nonzero(lit), _BLOCK)
    kept = [slice(start, start + _BLOCK) for start in starts]
    if lit.all():
        return [(each, each) for each in kept]
    texels = np.flatnonzero(lit)
    return [(each, texels[each]) for each in kept]
