"""Inner products of all indirect images, computed in blocks of texels.

An image has three rows, one for each channel, so that a basis serves all channels:

    Y = (3 k, texels),    G = Y Y^T = sum over blocks of Y_b Y_b^T

An image has about a thousand times more texels than there are images, so G is small; and a basis
needs nothing but G.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._common.interruptible import interruptible
from envlights._common.progress import progress_bar
from envlights._native import EnvLightsError
from envlights.transfer.pairs import Pairs, check_finite

#: Texels in a part, rounded to whole rows of the image. The kernels need enough for several
#: threads; NumPy, which needs reordered float64, as many as fit into the cache.
_PART, _SMALL_PART = 8192, 1024
#: Number of texels below which float32 rounding does not average out, and float64 is cheap.
_FEW = 2**16


@dataclass(frozen=True, eq=False)
class Gram:
    """Results of one pass over every texel."""

    products: NDArray[np.float64]
    """Inner products of the image channels, (3 k, 3 k); the mean is subtracted first if centred."""

    energy: NDArray[np.float64]
    """Sum of squares of each image, (k,); the mean is not subtracted."""

    lit: NDArray[np.bool_]
    """Texels that are not black in every image, (H, W)."""


def gram(pairs: Pairs, centred: bool, progress: bool | None = False) -> Gram:
    """Inner products of the scaled indirect images, minus the mean image if `centred`."""
    # Sum the lower half of the products, part by part.
    rows = 3 * len(pairs.scale)
    products = np.zeros((rows, rows))
    lit = np.empty(pairs.indirect.shape[1:3], np.bool_)
    inner = _single if is_for_kernels(pairs) else _double
    # Overflow and NaN raise an error below, which names the image.
    with np.errstate(over="ignore", invalid="ignore"):
        for where, part in parts(pairs, progress):
            found, is_lit = inner(part, pairs.scale)
            products += found
            lit[where] = is_lit.reshape(lit[where].shape)
    energy = np.diagonal(products).copy()
    if not np.isfinite(energy).all():
        _refuse(pairs)
    # Fill the upper half; for centred images, subtract the contribution of the mean.
    products = np.tril(products) + np.tril(products, -1).T
    if centred:
        mean = products.mean(axis=0)
        products += mean.mean() - mean - mean[:, None]
    return Gram(products, energy.reshape(-1, 3).sum(axis=1), lit)


def is_for_kernels(pairs: Pairs) -> bool:
    """True for large float32 images, for which the buffers of the kernels pay off."""
    _, height, width, _ = pairs.indirect.shape
    return bool(pairs.dtype == np.float32 and height * width >= _FEW)


def _single(part: NDArray[Any], scale: NDArray[np.float64]) -> tuple[Any, NDArray[np.bool_]]:
    """Lower half of the inner products, and the mask of texels that are not black."""
    return _native.transfer_gram(part, scale.astype(np.float32))


def _double(part: NDArray[Any], scale: NDArray[np.float64]) -> tuple[Any, NDArray[np.bool_]]:
    """All inner products in float64 by BLAS, and the mask of texels that are not black."""
    block = texel_rows(part, scale)
    lit: NDArray[np.bool_] = np.any(block, axis=1)
    return product(block.T, block), lit


def parts(pairs: Pairs, progress: bool | None = False) -> Iterator[tuple[slice, NDArray[Any]]]:
    """Row slices, and the unscaled texels of all images in these rows, (k, texels, 3)."""
    images, height, width, _ = pairs.indirect.shape
    step = max(1, (_PART if is_for_kernels(pairs) else _SMALL_PART) // width)
    for first in progress_bar(range(0, height, step), "learning", "part", progress):
        where = slice(first, min(first + step, height))
        part = pairs.indirect[:, where].astype(pairs.dtype, copy=False)
        yield where, part.reshape(images, -1, 3)


def texel_rows(part: NDArray[Any], scale: NDArray[Any]) -> NDArray[Any]:
    """Scaled values of all images at each texel, (texels, 3 k)."""
    scaled: NDArray[Any] = part.swapaxes(0, 1) * scale[:, None]
    return scaled.reshape(len(scaled), -1)


def _refuse(pairs: Pairs) -> None:
    check_finite("indirect", pairs.indirect)
    raise EnvLightsError(
        f"the squares of indirect overflow {pairs.dtype}; scale the images down or give float64"
    )


def product(left: NDArray[Any], right: NDArray[Any]) -> NDArray[Any]:
    """Matrix product ``left @ right``, which Ctrl-C can interrupt."""
    whole: NDArray[Any] = interruptible(lambda: left @ right, left.size * right.shape[-1])
    return whole


def eigensystem(symmetric: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Eigenvalues in ascending order, and eigenvectors as columns, of one matrix or a stack."""
    values, vectors = interruptible(
        lambda: np.linalg.eigh(symmetric), 10 * symmetric.size * symmetric.shape[-1]
    )
    return values, vectors
