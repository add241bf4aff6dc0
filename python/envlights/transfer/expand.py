"""From coefficients to images and back, a block of texels at a time."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Texels of a block: the rows of a few images stay in the cache until they are in place.
_BLOCK = 16384


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
    shares = np.repeat(norm, 3).astype(basis.dtype)[:, None]
    out = np.zeros((images, lit.size, 3), basis.dtype)
    for columns, texels in _blocks(lit):
        block = rows @ basis[:, columns]
        if len(mean):
            block += shares * mean[columns]
        out[:, texels] = block.reshape(images, 3, -1).swapaxes(1, 2)
    return out.reshape(images, *lit.shape, 3)


def gather(
    images: NDArray[Any], basis: NDArray[Any], lit: NDArray[np.bool_], mean: NDArray[Any]
) -> NDArray[np.float64]:
    """Coefficients of images (n, H, W, 3) less the `mean`: (n, 3, rank)."""
    flat = images.reshape(len(images), -1, 3)
    coefficients = np.zeros((3 * len(images), len(basis)))
    for columns, texels in _blocks(lit):
        block = flat[:, texels].swapaxes(1, 2).reshape(3 * len(images), -1).astype(basis.dtype)
        if len(mean):
            block -= mean[columns]
        coefficients += block @ basis[:, columns].T
    return coefficients.reshape(len(images), 3, -1)


def _blocks(lit: NDArray[np.bool_]) -> list[tuple[slice, Any]]:
    """Columns of the basis, and the texels that they are, by number or as a slice."""
    starts = range(0, np.count_nonzero(lit), _BLOCK)
    columns = [slice(start, start + _BLOCK) for start in starts]
    if lit.all():
        return [(each, each) for each in columns]
    texels = np.flatnonzero(lit)
    return [(each, texels[each]) for each in columns]
