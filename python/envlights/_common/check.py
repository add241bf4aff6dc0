"""Checks for arguments of public functions, before a kernel reads them."""

from __future__ import annotations

import contextlib
import functools
import inspect
import math
import numbers
import os
from collections.abc import Callable, Iterable
from difflib import get_close_matches
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.blocks import in_blocks
from envlights._native import EnvLightsError

_Function = TypeVar("_Function", bound=Callable[..., Any])

#: Largest accepted count; an array with that many elements does not fit into memory.
LARGEST_COUNT = 2**32 - 1


#: Tolerance for the products of the rows of a rotation matrix.
_ROTATION_TOLERANCE = 1e-6

#: Longest tuple or list that an error message shows; for longer ones it shows the type.
_FEW = 4


def describe(value: object) -> str:
    """Text for `value` in an error message: number, quoted text, short list, or only the type."""
    if isinstance(value, str | os.PathLike):
        return f"'{value}'"
    if value is None or isinstance(value, numbers.Number):
        return str(value)
    if isinstance(value, slice):
        ends = (value.start, value.stop)
        return ":".join("" if end is None else describe(end) for end in ends)
    if isinstance(value, tuple | list) and len(value) <= _FEW:
        return f"({', '.join(map(describe, value))})"
    return f"an object of the type {type(value).__name__}"


def for_kernels(array: ArrayLike, dtype: type[Any]) -> NDArray[Any]:
    """`array` in C order with aligned elements, as the kernels require."""
    given = np.asanyarray(array)
    is_ready = given.dtype == dtype and given.flags.c_contiguous and given.flags.aligned
    if is_ready or given.ndim == 0:
        return _laid_out(given, dtype)
    return in_blocks(given.shape, lambda rows: _laid_out(given[rows], dtype))


def _laid_out(array: NDArray[Any], dtype: type[Any]) -> NDArray[Any]:
    return np.require(array, dtype, ["C_CONTIGUOUS", "ALIGNED"])


def reals(name: str, values: ArrayLike, ndim: int | None) -> NDArray[np.float64]:
    """C-contiguous float64 array of `values` with `ndim` axes; None allows any number of axes."""
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise EnvLightsError(f"{name} must be an array of real numbers; {error}") from None
    if array.dtype.kind not in "fiu":
        raise EnvLightsError(f"{name} must hold real numbers; got the dtype {array.dtype}")
    if ndim not in (None, array.ndim):
        raise EnvLightsError(f"{name} must have {ndim} axes; got the shape {array.shape}")
    return for_kernels(array, np.float64)


def is_vector(values: ArrayLike) -> bool:
    """True if `values` have a single axis; False for ragged lists, which `reals` rejects."""
    with contextlib.suppress(ValueError):
        return np.ndim(values) == 1
    return False


def one_or_more(name: str, values: ArrayLike) -> tuple[NDArray[np.float64], bool]:
    """Vectors as rows, (n, 3), and True if `values` are a single vector."""
    is_one = is_vector(values) and np.size(values) > 0
    array = reals(name, values, 1 if is_one else 2)
    return (array[None], True) if is_one else (array, False)


def count(name: str, value: object, least: int = 0, most: int = LARGEST_COUNT) -> int:
    """`value` as an int from `least` to `most`; raises an error that names the argument."""
    is_whole = isinstance(value, numbers.Integral) and not isinstance(value, bool)
    if not is_whole or int(value) < least:  # type: ignore[call-overload]
        raise EnvLightsError(
            f"{name} must be a whole number, {least} or more; got {describe(value)}"
        )
    if int(value) > most:  # type: ignore[call-overload]
        raise EnvLightsError(f"{name} must be a whole number up to {most}; got {describe(value)}")
    return int(value)  # type: ignore[call-overload, no-any-return]


def counts(name: str, values: object) -> list[int]:
    """`values` as a list of non-negative ints; raises an error that names the argument."""
    if isinstance(values, str | bytes) or not isinstance(values, Iterable):
        raise EnvLightsError(f"{name} must be a sequence of whole numbers; got {describe(values)}")
    return [count(name, value) for value in values]


def amount(name: str, value: object, least: float = 0.0, most: float = math.inf) -> float:
    """`value` as a finite float from `least` to `most`; raises an error that names the argument."""
    number = math.nan
    if isinstance(value, numbers.Real) and not isinstance(value, bool):
        with contextlib.suppress(OverflowError):  # an int too large for a float
            number = float(value)
    if not (least <= number <= most and math.isfinite(number)):
        limits = f", from {least:g} to {most:g}" if math.isfinite(most) else f", {least:g} or more"
        limits = limits * math.isfinite(least) + " (1 is 100 %)" * (most == 1)
        raise EnvLightsError(f"{name} must be a finite number{limits}; got {describe(value)}")
    return number


def positive(name: str, value: object, most: float = math.inf) -> float:
    """`value` as a finite float above 0, up to `most`; the error names the argument."""
    number = amount(name, value, most=most)
    if number == 0:
        limit = f", up to {most:g}" if math.isfinite(most) else ""
        raise EnvLightsError(f"{name} must be above 0{limit}; got 0")
    return number


def first_not_finite(image: NDArray[Any]) -> tuple[int, int, Any] | None:
    """Row, column and value of the first sample that is NaN or infinite, or None."""
    bad = np.argwhere(~np.isfinite(image))
    if not len(bad):
        return None
    row, column = bad[0][:2]
    return row, column, image[tuple(bad[0])]


def colour(name: str, values: ArrayLike) -> list[float]:
    """Non-negative RGB of a surface; raises an error that names the argument."""
    channels = reals(name, values, 1)
    if channels.shape != (3,):
        raise EnvLightsError(f"{name} must be three numbers; got the shape {channels.shape}")
    return [amount(name, float(channel)) for channel in channels]


def check_choice(name: str, value: object, choices: tuple[str, ...]) -> None:
    """Raise an error if `value` is not one of the `choices`."""
    if not isinstance(value, str) or value not in choices:
        wanted = " or ".join(map(describe, choices))
        raise EnvLightsError(f"{name} must be {wanted}; got {describe(value)}")


def flag(name: str, value: object) -> bool:
    """`value` as a bool; raises an error that names the argument."""
    if not isinstance(value, bool | np.bool_):
        raise EnvLightsError(f"{name} must be True or False; got {describe(value)}")
    return bool(value)


def check_progress(value: object) -> None:
    """Raise an error if `progress` is neither a bool nor None."""
    if value is not None:
        flag("progress", value)


def texts(name: str, values: object) -> list[str]:
    """`values`, one or several texts, as a list; raises an error that names the argument."""
    each = [values] if isinstance(values, str) or not isinstance(values, Iterable) else [*values]
    for text in each:
        if not isinstance(text, str):
            raise EnvLightsError(f"{name} must be text; got {describe(text)}")
    return [str(text) for text in each]


def float_image(name: str, values: ArrayLike, ndim: int) -> NDArray[np.float32]:
    """C-contiguous float32 array of `values` with `ndim` axes; the error names the argument."""
    is_ready = isinstance(values, np.ndarray) and values.dtype == np.float32
    array = values if is_ready else reals(name, values, ndim)
    if np.ndim(array) != ndim:
        raise EnvLightsError(f"{name} must have {ndim} axes; got the shape {np.shape(array)}")
    return for_kernels(array, np.float32)


def whole_pixels(values: ArrayLike) -> NDArray[np.int64]:
    """Integer rows and columns of pixels; raises an error for other values."""
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise EnvLightsError(f"pixels must be an array of whole numbers; {error}") from None
    if array.dtype.kind not in "iu" or array.ndim != 2 or array.shape[1] != 2:
        raise EnvLightsError(
            f"pixels must be whole numbers of the shape (n, 2);"
            f" got the dtype {array.dtype} and the shape {array.shape}"
        )
    return for_kernels(array, np.int64)


def whole_numbers(name: str, values: ArrayLike) -> NDArray[np.int64]:
    """C-contiguous int64 array of `values` with one axis; the error names the argument."""
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise EnvLightsError(f"{name} must be an array of whole numbers; {error}") from None
    if array.ndim != 1 or (array.size and array.dtype.kind not in "iu"):
        raise EnvLightsError(
            f"{name} must hold whole numbers along one axis;"
            f" got the dtype {array.dtype} and the shape {array.shape}"
        )
    return for_kernels(array, np.int64)


def rotation(matrix: ArrayLike, name: str = "matrix") -> NDArray[np.float64]:
    """`matrix` as a rotation, (3, 3); raises an error unless orthonormal with determinant 1."""
    if isinstance(matrix, numbers.Real) or is_vector(matrix):
        raise EnvLightsError(
            f"{name} must be a rotation of the shape (3, 3), not angles; got {describe(matrix)}"
        )
    turn = reals(name, matrix, 2)
    if turn.shape != (3, 3):
        raise EnvLightsError(f"{name} must have the shape (3, 3); got {turn.shape}")
    if not np.allclose(turn @ turn.T, np.eye(3), rtol=0, atol=_ROTATION_TOLERANCE):
        raise EnvLightsError(f"{name} must be a rotation; its rows must be orthonormal")
    if np.linalg.det(turn) < 0:
        raise EnvLightsError(f"{name} must be a rotation; it is a reflection")
    return turn


def unit_vector(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """Normalised vector of three numbers, (3,); raises an error if that is impossible."""
    vector = reals(name, values, 1)
    length = np.linalg.norm(vector)
    if vector.shape != (3,) or not 0 < length < np.inf:
        raise EnvLightsError(
            f"{name} must be three finite numbers, and not all 0; got {vector.tolist()}"
        )
    unit: NDArray[np.float64] = vector / length
    return unit


#: Kinds of parameters that cannot be passed by name.
_MANY = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)


def named_arguments(*others: Callable[..., Any]) -> Callable[[_Function], _Function]:
    """Decorator whose errors for unknown keywords name the most similar argument.

    It also has the options of `others`.
    """

    def decorate(function: _Function) -> _Function:
        functions: list[Callable[..., Any]] = [function, *others]
        given = [each for one in functions for each in _parameters(one)]
        names = dict.fromkeys(each.name for each in given if each.kind not in _MANY)

        @functools.wraps(function)
        def call(*args: Any, **keywords: Any) -> Any:
            for name in keywords:
                if name not in names:
                    raise TypeError(_refusal(function.__qualname__, name, [*names]))
            return function(*args, **keywords)

        return call  # type: ignore[return-value]

    return decorate


def _parameters(function: Callable[..., Any]) -> list[inspect.Parameter]:
    return [*inspect.signature(function).parameters.values()]


def _refusal(function: str, name: str, names: list[str]) -> str:
    near = get_close_matches(name, names, n=1)
    meant = f" (did you mean {near[0]}=?)" if near else ""
    return (
        f"{function}() got an unexpected keyword argument '{name}'{meant}; it has"
        f" {', '.join(names)}"
    )
