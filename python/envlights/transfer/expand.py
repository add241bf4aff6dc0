"""Images from coefficients, and coefficients from images, in blocks of texels."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import describe
from envlights._native import EnvLightsError

#: Texels in a block: the rows of a few images fit into the cache.
_BLOCK = 8192
#: Numbers in a block of many images: a block takes a few tenths of a second, so that Ctrl-C works.
_NUMBERS = 2**21


def expand(
    coefficients: NDArray[np.float64],
    basis: NDArray[Any],
    lit: NDArray[np.bool_],
    mean: NDArray[Any],
    norm: NDArray[np.float64],
    needed: NDArray[np.bool_] | None = None,
) -> NDArray[Any]:
    """Images of `coefficients` (n, 3, components), black where not `lit`: (n, H, W, 3).

    Components of the basis beyond those of `coefficients` are not read. A `mean` that is not empty
    is added `norm` times. Blocks without a texel that is `needed` (H, W) stay black.
    """
    images, _, components = coefficients.shape
    rows = coefficients.reshape(3 * images, components).astype(basis.dtype)
    norms = np.repeat(norm, 3).astype(basis.dtype)
    out = np.zeros((images, lit.size, 3), basis.dtype)
    for part, texels in _blocks(lit, images):
        if needed is not None and not needed.ravel()[texels].any():
            continue
        block = basis[part, :components] @ rows.T
        if len(mean):
            block += mean[part, None] * norms
        out[:, texels] = block.reshape(len(block), images, 3).swapaxes(0, 1)
    return out.reshape(images, *lit.shape, 3)


def bound(
    coefficients: NDArray[np.float64], norm: NDArray[np.float64], mean: NDArray[Any]
) -> float:
    """Largest value that frames may hold, and sums of their parts; infinity on overflow.

    The columns of the basis are orthonormal: no texel, and no part of its sum, is larger than the
    norm of its coefficients. A rounded basis is so within a factor far below 2.
    """
    with np.errstate(over="ignore"):
        largest = np.linalg.norm(coefficients, axis=2).max(initial=0.0)
    return float(largest + norm.max(initial=0.0) * np.abs(mean).max(initial=0.0))


def check_range(largest: float, dtype: Any, owner: str = "model") -> None:
    """Raise an error for frames that may reach `largest`, if that is beyond half the `dtype`."""
    most = float(np.finfo(dtype).max) / 2
    if not largest <= most:
        raise EnvLightsError(
            f"direct is too bright: the images may reach {largest:.3g}, and the {owner} holds"
            f" values up to {most:.3g}; divide direct by a scale and multiply the images by it"
        )


def project(
    images: NDArray[Any], basis: NDArray[Any], lit: NDArray[np.bool_], mean: NDArray[Any]
) -> NDArray[np.float64]:
    """Coefficients in the basis, (n, 3, rank), of images (n, H, W, 3) minus the `mean`."""
    flat = images.reshape(len(images), -1, 3)
    coefficients = np.zeros((3 * len(images), basis.shape[1]))
    for part, texels in _blocks(lit, len(images)):
        block = flat[:, texels].swapaxes(1, 2).reshape(3 * len(images), -1).astype(basis.dtype)
        if len(mean):
            block -= mean[part]
        coefficients += block @ basis[part]
    return coefficients.reshape(len(images), 3, -1)


def truncate(coefficients: NDArray[np.float64], error: float) -> NDArray[np.float64]:
    """Leading components of each frame, as many as its relative `error` needs; the others become 0.

    The columns of the basis are orthonormal, so the squared error is the sum of the squares of the
    omitted components. Components that no frame needs are dropped.
    """
    # A power of two, which causes no rounding, keeps the squares in range.
    largest = np.abs(coefficients).max(axis=(1, 2), keepdims=True, initial=0.0)
    shares = np.ldexp(coefficients, -np.frexp(largest)[1])
    energy = np.einsum("ncr,ncr->nr", shares, shares)
    residual = np.cumsum(energy[:, ::-1], axis=1)[:, ::-1]
    is_needed = residual > error**2 * residual[:, :1]
    most = is_needed.sum(axis=1).max()
    first: NDArray[np.float64] = (coefficients * is_needed[:, None])[..., :most]
    return first


def region_mask(region: Any, shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Mask of the texels in two slices, (H, W); raises an error for other regions."""
    needed = np.zeros(shape, np.bool_)
    try:
        rows, columns = region
        for each, side in zip((rows, columns), shape, strict=True):
            slice.indices(each, side)
        needed[rows, columns] = True
    except (TypeError, ValueError):
        raise EnvLightsError(
            f"region must be two slices, of rows and of columns; got {describe(region)}"
        ) from None
    return needed


def _blocks(lit: NDArray[np.bool_], images: int) -> list[tuple[slice, Any]]:
    """Row slice of the basis, and matching texels, of each block.

    Texels are indices, or a slice if all are lit. Blocks of many `images` have fewer texels.
    """
    rows = min(max(_NUMBERS // (3 * max(images, 1)), 1), _BLOCK)
    parts = [slice(start, start + rows) for start in range(0, np.count_nonzero(lit), rows)]
    if lit.all():
        return [(each, each) for each in parts]
    texels = np.flatnonzero(lit)
    return [(each, texels[each]) for each in parts]
