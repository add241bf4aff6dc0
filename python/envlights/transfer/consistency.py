"""Checks that the fields of a model fit together.

Types, shapes and the mask of texels are checked here. Numbers are checked for NaN and infinity
where they enter: in the images of `fit`, and in the arrays of a file.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import count
from envlights._native import EnvLightsError
from envlights.transfer.compact import LARGEST, SHARE, TILE, CompactBasis, places_of

_FLOATS = ("float32", "float64")


def check_fields(
    basis: NDArray[Any] | CompactBasis,
    lit: NDArray[np.bool_],
    size: tuple[int, int],
    arrays: Mapping[str, Any],
) -> None:
    """Refuse fields that do not fit together.

    Parameters
    ----------
    basis, lit, size
        As in `TransferModel`.
    arrays : mapping of str to ndarray
        The other arrays by name: `mean`, `transfer`, and those of `PairSummary`.
    """
    # Check the mask and the basis over its texels.
    if np.ndim(lit) != 2:
        raise EnvLightsError(f"lit must have 2 axes; got the shape {np.shape(lit)}")
    check_array("lit", lit, np.shape(lit), ("bool",))
    # Take rank and number of pairs from one array each; all others must agree with it.
    rank, pairs = np.shape(arrays["transfer"])[-1:], np.shape(arrays["direct"])[:1]
    _check_basis(basis, lit, rank)
    # Check the other arrays.
    texels, pixels = int(np.count_nonzero(lit)), pixels_of(size)
    has_mean = np.size(arrays["mean"]) > 0
    shapes = {
        "mean": (texels if has_mean else 0,),
        "transfer": (3, 3 * pixels if has_mean else pixels, *rank),
        "direct": (*pairs, 3, pixels),
        "coefficients": (*pairs, 3, *rank),
        "outside": (*pairs, 3, 3),
        "energy": pairs,
    }
    for name, shape in shapes.items():
        check_array(name, arrays[name], shape)


def _check_basis(
    basis: NDArray[Any] | CompactBasis, lit: NDArray[np.bool_], rank: tuple[int, ...]
) -> None:
    if not isinstance(basis, CompactBasis):
        check_array("basis", basis, (int(np.count_nonzero(lit)), *rank))
        return
    places = places_of(lit)
    tiles = int(places.max(initial=-1)) + 1
    check_array("basis", basis.values, (tiles, *rank, TILE), LARGEST)
    check_array("scales", basis.scales, (tiles, *rank, TILE // SHARE), ("float32",))
    if not np.array_equal(basis.places, places):
        raise EnvLightsError("places of the basis must be the tiles in which lit has texels")


def pixels_of(size: tuple[int, int]) -> int:
    """Number of pixels of a direct image; raises an error for an invalid `size`."""
    if not isinstance(size, tuple) or len(size) != 2:
        raise EnvLightsError("size must be two numbers, height and width")
    height, width = (count("size", side, least=1) for side in size)
    return height * width


def check_array(
    name: str, array: object, shape: tuple[int, ...], dtypes: Collection[str] = _FLOATS
) -> None:
    """Refuse anything but an array of NumPy of this shape and one of these types."""
    wanted = f"{name} must hold {' or '.join(dtypes)} in the shape {shape}"
    if not isinstance(array, np.ndarray):
        raise EnvLightsError(f"{wanted}; got an object of the type {type(array).__name__}")
    if array.shape != shape or array.dtype.name not in dtypes:
        raise EnvLightsError(f"{wanted}; got {array.dtype} in the shape {array.shape}")
