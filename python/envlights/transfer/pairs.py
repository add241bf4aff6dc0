"""Checks of the images, and pairs at one scale."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import first_not_finite
from envlights._common.result import Result
from envlights._native import EnvLightsError


@dataclass(frozen=True, eq=False)
class Pairs:
    """Images of direct and indirect light under the same lights, `k` of each."""

    direct: NDArray[np.float64]
    """Direct light, (k, 3, h * w), each image at norm 1; a black one stays black."""

    indirect: Any
    """Indirect light at its own scale, without alpha, (k, H, W, 3): an array of NumPy or Dask."""

    scale: NDArray[np.float64]
    """Factor of each pair, (k,): one over the norm of its direct image, or 0 where that is black.

    Light is linear, so every pair may be scaled. At one norm all pairs count the same, however
    bright their lights were, and a ridge means the same for each scene.
    """

    notes: tuple[str, ...]
    """Channels that were dropped and images that were left out."""

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of the large arrays: float64 if the indirect images are, otherwise float32."""
        return np.dtype(np.float64 if self.indirect.dtype.itemsize >= 8 else np.float32)

    @property
    def is_lazy(self) -> bool:
        """True if the indirect images are an array of Dask, which has yet to be computed."""
        return _is_lazy(self.indirect)


@dataclass(frozen=True, eq=False, repr=False)
class PairSummary(Result):
    """Summary of the pairs of a model, without their texels, so that more pairs can be added."""

    direct: NDArray[np.float64]
    """Direct images at norm 1, (k, 3, h * w)."""

    coefficients: NDArray[np.float64]
    """Coefficients of the indirect images in the basis, (k, 3, rank)."""

    outside: NDArray[np.float64]
    """Inner products of the residuals of the three rows of each image, (k, 3, 3)."""

    energy: NDArray[np.float64]
    """Sum of squares of each indirect image, (k,)."""

    def in_short(self) -> str:
        """Number of pairs, and rank."""
        return f"{len(self.energy)} pairs at rank {self.coefficients.shape[2]}"


def pairs_of(direct: ArrayLike, indirect: ArrayLike) -> Pairs:
    """Pairs of two stacks of images, or a refusal."""
    # Check both stacks; only the small images are read here.
    large, dropped = images("indirect", indirect)
    small, dropped_too = images("direct", direct)
    if len(small) != len(large):
        raise EnvLightsError(
            "direct and indirect must hold the same number of images; got"
            f" {len(small)} and {len(large)}"
        )
    small = np.asarray(small)
    check_finite("direct", small)
    # Find the factor that brings each direct image to norm 1.
    rows = rgb_rows(small)
    norm = np.linalg.norm(rows, axis=(1, 2))
    if not norm.any():
        raise EnvLightsError("direct is black in every image; there is nothing to learn from")
    scale = np.divide(1.0, norm, out=np.zeros_like(norm), where=norm > 0)
    notes = (*dropped_too, *dropped, *_black(np.flatnonzero(norm == 0)))
    return Pairs(rows * scale[:, None, None], large, scale, notes)


def images(name: str, values: Any) -> tuple[Any, tuple[str, ...]]:
    """A stack of RGB images, (k, height, width, 3), as a view, and a note if it had alpha.

    An array of Dask stays an array of Dask.
    """
    array = values if _is_lazy(values) else as_array(name, values)
    if array.dtype.kind != "f":
        raise EnvLightsError(
            f"{name} must hold linear light as floating point; got the dtype {array.dtype}"
        )
    # Dask gives NaN for a side that it does not know.
    has_texels = all(side > 0 for side in array.shape)
    if array.ndim != 4 or array.shape[3] not in (3, 4) or not has_texels:
        raise EnvLightsError(
            f"{name} must have the shape (k, height, width, 3 or 4); got {array.shape}"
        )
    dropped = (f"alpha of {name} was dropped",) if array.shape[3] == 4 else ()
    return array[..., :3], dropped


def as_array(name: str, values: ArrayLike) -> NDArray[Any]:
    """`values` as an array in memory, or a refusal if the images are of several sizes."""
    try:
        return np.atleast_1d(np.asarray(values))
    except ValueError as error:
        raise EnvLightsError(f"{name} must be an array of images of one size; {error}") from None


def _is_lazy(values: object) -> bool:
    # No array of Dask exists before `dask.array` is imported.
    dask_array = sys.modules.get("dask.array")
    return dask_array is not None and isinstance(values, dask_array.Array)


def rgb_rows(stack: NDArray[Any]) -> NDArray[np.float64]:
    """Each channel of a stack (k, height, width, 3) as a row of float64, (k, 3, texels)."""
    rows: NDArray[np.float64] = np.moveaxis(stack, -1, 1).reshape(len(stack), 3, -1)
    return rows.astype(np.float64)


def image_stack(
    name: str, values: ArrayLike, size: tuple[int, int], owner: str = "model"
) -> tuple[NDArray[Any], bool]:
    """One image or a stack, of the `size` of its owner, as a stack; True if it was one image."""
    array = as_array(name, values)
    is_one = array.ndim == 3
    stack, _ = images(name, array[None] if is_one else array)
    if stack.shape[1:3] != size:
        given, wanted = ("x".join(map(str, each[::-1])) for each in (stack.shape[1:3], size))
        raise EnvLightsError(f"{name} must be {wanted} pixels, as in the {owner}; got {given}")
    check_finite(name, stack)
    return stack, is_one


def check_finite(name: str, stack: NDArray[Any], first_row: int = 0) -> None:
    """Refuse the first texel that is NaN or infinite; image by image, so that none is copied.

    `first_row` is the row of the whole images at which `stack` begins.
    """
    for k, image in enumerate(stack):
        if bad := first_not_finite(image):
            row, column, value = bad
            raise EnvLightsError(
                f"{name} must be finite; image {k} holds {value}"
                f" at row {first_row + row}, column {column}"
            )


def _black(which: NDArray[np.intp]) -> tuple[str, ...]:
    if not len(which):
        return ()
    if len(which) == 1:
        return (f"1 image is left out, because direct is black: image {which[0]}",)
    return (
        f"{len(which)} images are left out, because direct is black; the first is image {which[0]}",
    )
