"""Arrays that cannot be written to."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray


def frozen(array: NDArray[Any]) -> NDArray[Any]:
    """A copy of `array` that cannot be written to."""
    return sealed(array.copy())


def sealed(array: NDArray[Any]) -> NDArray[Any]:
    """`array` itself, closed to writing; for one that nobody else holds."""
    array.flags.writeable = False
    return array
