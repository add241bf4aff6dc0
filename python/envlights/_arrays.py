"""Arrays that cannot be written to, and what NumPy makes of what holds one."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def freeze(array: NDArray[Any]) -> NDArray[Any]:
    """A copy of `array` that cannot be written to."""
    return seal(array.copy())


def seal(array: NDArray[Any]) -> NDArray[Any]:
    """`array` itself, closed to writing; for one that nobody else holds."""
    array.flags.writeable = False
    return array


def convert(array: NDArray[Any], dtype: Any, copy: bool | None) -> NDArray[Any]:
    """What ``__array__`` returns of the `array` that an object holds."""
    if copy:
        return np.array(array, dtype)
    if copy is False and dtype is not None and np.dtype(dtype) != array.dtype:
        raise ValueError(f"the array is {array.dtype}; as {np.dtype(dtype)} it must be copied")
    return np.asarray(array, dtype)
