"""From coefficients to images, and from images to coefficients, a block of texels at a time."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._check import shown
from envlights._native import EnvLightsError

#: Texels of a block: the rows of a few images stay in the cache until they are in place.
_BLOCK = 8192
#: Numbers of a block of many images: what is done with them takes tenths of a second, for Ctrl-C.
_NUMBERS = 2**21


def expand(
    coefficients: NDArray[np.float64],
    basis: NDArray[Any],
    lit: NDArray[np.bool_],
    mean: NDArray[Any],
    norm: NDArray[np.float64],
    wanted: NDArray[np.bool_] | None = None,
) -> NDArray[Any]:
    """Images of `coefficients` (n, 3, components), black where not `lit`: (n, H, W, 3).

    Components of the basis beyond those of `coefficients` are not read. A `mean` that is not empty
    is added `norm` times. Blocks without a texel that is `wanted` (H, W) stay black.
    """
    images, _, components = coefficients.shape
    rows = coefficients.reshape(3 * images, components).astype(basis.dtype)
    shares = np.repeat(norm, 3).astype(basis.dtype)
    out = np.zeros((images, lit.size, 3), basis.dtype)
    for kept, texels in _blocks(lit, images):
        if wanted is not None and not wanted.ravel()[texels].any():
            continue
        block = basis[kept, :components] @ rows.T
        if len(mean):
            block += mean[kept, None] * shares
        out[:, texels] = block.reshape(-1, images, 3).swapaxes(0, 1)
    return out.reshape(images, *lit.shape, 3)


def check_range(
    coefficients: NDArray[np.float64], norm: NDArray[np.float64], mean: NDArray[Any], dtype: Any
) -> None:
    """Refuse frames that may hold values beyond the range of `dtype`.

    The columns of the basis are orthonormal: no texel, and no part of its sum, is larger than the
    norm of its coefficients. A rounded basis is so within a factor far below 2.
    """
    with np.errstate(over="ignore"):  # an infinity is refused, too
        largest = np.linalg.norm(coefficients, axis=2).max(initial=0.0)
    largest += norm.max(initial=0.0) * np.abs(mean).max(initial=0.0)
    most = float(np.finfo(dtype).max) / 2
    if not largest <= most:
        raise EnvLightsError(
            f"direct is too bright: the images may reach {largest:.3g}, and the model holds values"
            f" up to {most:.3g}; divide direct by a scale and multiply the images by it"
        )


def project(
    images: NDArray[Any], basis: NDArray[Any], lit: NDArray[np.bool_], mean: NDArray[Any]
) -> NDArray[np.float64]:
    """Coefficients of images (n, H, W, 3) less the `mean`, in the basis: (n, 3, rank)."""
    flat = images.reshape(len(images), -1, 3)
    coefficients = np.zeros((3 * len(images), basis.shape[1]))
    for kept, texels in _blocks(lit, len(images)):
        block = flat[:, texels].swapaxes(1, 2).reshape(3 * len(images), -1).astype(basis.dtype)
        if len(mean):
            block -= mean[kept]
        coefficients += block @ basis[kept]
    return coefficients.reshape(len(images), 3, -1)


def truncated(coefficients: NDArray[np.float64], error: float) -> NDArray[np.float64]:
    """The first components of each frame that keep its relative `error`; the others are 0.

    The columns of the basis are orthonormal, so the squared error is the sum of the squares of the
    components that are left out. Components that no frame keeps are cut off.
    """
    energy = np.einsum("ncr,ncr->nr", coefficients, coefficients)
    left = np.cumsum(energy[:, ::-1], axis=1)[:, ::-1]
    kept = left > error**2 * left[:, :1]
    first: NDArray[np.float64] = (coefficients * kept[:, None])[..., : kept.sum(axis=1).max()]
    return first


def region_mask(region: Any, shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Mask of the texels in two slices, (H, W), or a refusal."""
    wanted = np.zeros(shape, np.bool_)
    try:
        rows, columns = region
        for each, side in zip((rows, columns), shape, strict=True):
            slice.indices(each, side)
        wanted[rows, columns] = True
    except (TypeError, ValueError):
        raise EnvLightsError(
            f"region must be two slices, of rows and of columns; got {shown(region)}"
        ) from None
    return wanted


def _blocks(lit: NDArray[np.bool_], images: int) -> list[tuple[slice, Any]]:
    """Slices of rows of the basis, and the texels of these rows: their numbers or a slice.

    Smaller ones for many `images`, which are done together.
    """
    rows = min(max(_NUMBERS // (3 * max(images, 1)), 1), _BLOCK)
    kept = [slice(start, start + rows) for start in range(0, np.count_nonzero(lit), rows)]
    if lit.all():
        return [(each, each) for each in kept]
    texels = np.flatnonzero(lit)
    return [(each, texels[each]) for each in kept]
