"""What is asked of the images, and pairs brought to one scale."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._native import EnvLightsError


@dataclass(frozen=True, eq=False)
class Pairs:
    """Images of direct and indirect light under the same lights, `k` of each."""

    direct: NDArray[np.float64]
    """Direct light, (k, 3, h * w), each image at norm 1; a black one stays black."""

    indirect: Any
    """Indirect light as it was given, without alpha: (k, H, W, 3), of NumPy or of Dask."""

    scale: NDArray[np.float64]
    """What each pair is multiplied with, (k,): one over the norm of its direct image, or 0.

    Light is linear, so every pair may be scaled. At one norm all count the same, however bright
    their lights were, and a ridge means the same for each scene.
    """

    notes: tuple[str, ...]
    """What was dropped or left out."""

    @property
    def dtype(self) -> np.dtype[Any]:
        """The type of the large arrays: float64 where the indirect images have it, or float32."""
        return np.dtype(np.float64 if self.indirect.dtype.itemsize >= 8 else np.float32)

    @property
    def is_lazy(self) -> bool:
        """Whether the indirect images are an array of Dask, which has yet to be computed."""
        return _is_lazy(self.indirect)


def pairs_of(direct: ArrayLike, indirect: ArrayLike) -> Pairs:
    """The pairs of two stacks of images, or a refusal that names what does not fit."""
    large, dropped = images("indirect", indirect)
    small, dropped_too = images("direct", direct)
    if len(small) != len(large):
        raise EnvLightsError(
            f"direct and indirect must hold as many images; got {len(small)} and {len(large)}"
        )
    small = np.asarray(small)
    check_finite("direct", small)
    rows = np.moveaxis(small, -1, 1).reshape(len(small), 3, -1).astype(np.float64)
    norm = np.linalg.norm(rows, axis=(1, 2))
    if not norm.any():
        raise EnvLightsError("direct is black in every image; there is nothing to learn from")
    scale = np.divide(1.0, norm, out=np.zeros_like(norm), where=norm > 0)
    notes = (*dropped_too, *dropped, *_black(np.flatnonzero(norm == 0)))
    return Pairs(rows * scale[:, None, None], large, scale, notes)


def images(name: str, values: Any) -> tuple[Any, tuple[str, ...]]:
    """A stack of RGB images, (k, height, width, 3), as a view, and what was dropped of it.

    An array of Dask stays one.
    """
    array = values if _is_lazy(values) else as_array(name, values)
    if array.dtype.kind != "f":
        raise EnvLightsError(
            f"{name} must hold linear light as floating point; got the dtype {array.dtype}"
        )
    # Dask calls a side that it does not know NaN.
    is_whole = all(side > 0 for side in array.shape)
    if array.ndim != 4 or array.shape[3] not in (3, 4) or not is_whole:
        raise EnvLightsError(
            f"{name} must have the shape (k, height, width, 3 or 4); got {array.shape}"
        )
    dropped = (f"alpha of {name} was dropped",) if array.shape[3] == 4 else ()
    return array[..., :3], dropped


def as_array(name: str, values: ArrayLike) -> NDArray[Any]:
    """`values` as an array in memory, or a refusal where they are of several sizes."""
    try:
        return np.atleast_1d(np.asarray(values))
    except ValueError as error:
        raise EnvLightsError(f"{name} must be an array of images of one size; {error}") from None


def _is_lazy(values: object) -> bool:
    # Nobody has an array of Dask before `dask.array` is imported.
    dask_array = sys.modules.get("dask.array")
    return dask_array is not None and isinstance(values, dask_array.Array)


def frames(name: str, values: ArrayLike, size: tuple[int, int]) -> tuple[NDArray[Any], bool]:
    """One image or a stack of the model's `size` as a stack, and whether it was one."""
    array = as_array(name, values)
    is_one = array.ndim == 3
    stack, _ = images(name, array[None] if is_one else array)
    if stack.shape[1:3] != size:
        seen, wanted = ("x".join(map(str, each[::-1])) for each in (stack.shape[1:3], size))
        raise EnvLightsError(f"{name} must be {wanted} pixels, as in the model; got {seen}")
    check_finite(name, stack)
    return stack, is_one


def check_finite(name: str, stack: NDArray[Any], first_row: int = 0) -> None:
    """Refuse the first texel that is NaN or infinite; image by image, to copy none of them.

    `first_row` is where the rows of `stack` begin in the whole images.
    """
    for k, image in enumerate(stack):
        bad = np.argwhere(~np.isfinite(image))
        if len(bad):
            row, column, _ = bad[0]
            raise EnvLightsError(
                f"{name} must be finite; image {k} holds {image[tuple(bad[0])]}"
                f" at row {first_row + row}, column {column}"
            )


def _black(which: NDArray[np.intp]) -> tuple[str, ...]:
    if not len(which):
        return ()
    return (f"direct is black in {len(which)} of the images ({which[0]} first): left out",)
