"""Checks of images, and pairs scaled to norm 1."""

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
    """Direct and indirect images of the same lights, `k` of each."""

    direct: NDArray[np.float64]
    """Direct images, (k, 3, h * w), each scaled to norm 1; black images stay black."""

    indirect: Any
    """Indirect images as given, without alpha, (k, H, W, 3): a NumPy or Dask array."""

    scale: NDArray[np.float64]
    """Scale factor of each pair, (k,): 1 / norm of its direct image, or 0 for a black one.

    Light is linear, so every pair may be scaled. At one norm all pairs count the same, however
    bright their lights were, and a ridge means the same for each scene.
    """

    notes: tuple[str, ...]
    """Notes on dropped channels and omitted images."""

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of the large arrays: float64 for indirect images in float64, otherwise float32."""
        return np.dtype(np.float64 if self.indirect.dtype.itemsize >= 8 else np.float32)

    @property
    def is_lazy(self) -> bool:
        """True if the indirect images are a Dask array, which is not computed yet."""
        return _is_lazy(self.indirect)


def pairs_of(direct: ArrayLike, indirect: ArrayLike) -> Pairs:
    """Pairs of two stacks of images; raises an error if the stacks do not match."""
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
    # Compute the factor that scales each direct image to norm 1.
    rows = rgb_rows(small)
    norm = np.linalg.norm(rows, axis=(1, 2))
    if not norm.any():
        raise EnvLightsError("direct is black in every image; there is nothing to learn from")
    scale = np.divide(1.0, norm, out=np.zeros_like(norm), where=norm > 0)
    notes = (*dropped_too, *dropped, *_black(np.flatnonzero(norm == 0)))
    return Pairs(rows * scale[:, None, None], large, scale, notes)


def images(name: str, values: Any) -> tuple[Any, tuple[str, ...]]:
    """Stack of RGB images, (k, height, width, 3), as a view, and a note if alpha was dropped.

    An array of Dask stays an array of Dask.
    """
    array = values if _is_lazy(values) else as_array(name, values)
    if array.dtype.kind != "f":
        raise EnvLightsError(
            f"{name} must hold linear light as floating point; got the dtype {array.dtype}"
        )
    # Dask reports an unknown length of an axis as NaN.
    has_texels = all(side > 0 for side in array.shape)
    if array.ndim != 4 or array.shape[3] not in (3, 4) or not has_texels:
        raise EnvLightsError(
            f"{name} must have the shape (k, height, width, 3 or 4); got {array.shape}"
        )
    dropped = (f"alpha of {name} was dropped",) if array.shape[3] == 4 else ()
    return array[..., :3], dropped


def as_array(name: str, values: ArrayLike) -> NDArray[Any]:
    """`values` as an array in memory; raises an error if the images differ in size."""
    try:
        return np.atleast_1d(np.asarray(values))
    except ValueError as error:
        raise EnvLightsError(f"{name} must be an array of images of one size; {error}") from None


def _is_lazy(values: object) -> bool:
    # Dask arrays exist only if `dask.array` is imported.
    dask_array = sys.modules.get("dask.array")
    return dask_array is not None and isinstance(values, dask_array.Array)


def rgb_rows(stack: NDArray[Any]) -> NDArray[np.float64]:
    """Rows of float64, (k, 3, texels), one per channel of a stack (k, height, width, 3)."""
    rows: NDArray[np.float64] = np.moveaxis(stack, -1, 1).reshape(len(stack), 3, -1)
    return rows.astype(np.float64)


def image_stack(
    name: str, values: ArrayLike, size: tuple[int, int], owner: str = "model"
) -> tuple[NDArray[Any], bool]:
    """One image or a stack of the `size` of its owner, as a stack; True if it was one image."""
    array = as_array(name, values)
    is_one = array.ndim == 3
    stack, _ = images(name, array[None] if is_one else array)
    if stack.shape[1:3] != size:
        given, wanted = ("x".join(map(str, each[::-1])) for each in (stack.shape[1:3], size))
        raise EnvLightsError(f"{name} must be {wanted} pixels, as in the {owner}; got {given}")
    check_finite(name, stack)
    return stack, is_one


def check_finite(name: str, stack: NDArray[Any], first_row: int = 0) -> None:
    """Raise an error at the first NaN or infinite texel; checks image by image, without a copy.

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


@dataclass(frozen=True, eq=False, repr=False)
class PairSummary(Result):
    """Summary of the training pairs, without their texels, so that more pairs can be added."""

    direct: NDArray[np.float64]
    """Direct images scaled to norm 1, (k, 3, h * w)."""

    coefficients: NDArray[np.float64]
    """Coefficients of the indirect images in the basis, (k, 3, rank)."""

    outside: NDArray[np.float64]
    """Inner products of the residuals of the three colour channels of each image, (k, 3, 3)."""

    energy: NDArray[np.float64]
    """Sum of squares of each indirect image, (k,)."""

    def in_short(self) -> str:
        """Number of pairs, and rank."""
        return f"{len(self.energy)} pairs at rank {self.coefficients.shape[2]}"
