"""Read-only arrays, and conversion for ``__array__``."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def freeze(array: NDArray[Any]) -> NDArray[Any]:
    """Read-only copy of `array`."""
    return seal(array.copy())


def seal(array: NDArray[Any]) -> NDArray[Any]:
    """Make `array` read-only and return it; only for arrays that no caller holds."""
    array.flags.writeable = False
    return array


def convert(array: NDArray[Any], dtype: Any, copy: bool | None) -> NDArray[Any]:
    """Return value of ``__array__`` for an object that stores `array`."""
    if copy:
        return np.array(array, dtype)
    if copy is False and dtype is not None and np.dtype(dtype) != array.dtype:
        raise ValueError(f"the array is {array.dtype}; as {np.dtype(dtype)} it must be copied")
    return np.asarray(array, dtype)
