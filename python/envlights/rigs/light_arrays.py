"""Array fields of lights: checks, rotation, and selection by index."""

from __future__ import annotations

import operator

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import describe, reals
from envlights._native import EnvLightsError
from envlights.kernels import sphere

#: Largest irradiance or radiance, because maps and most targets use single precision.
LARGEST_LIGHT: float = float(np.finfo(np.float32).max)

#: Tolerance for the length of unit vectors in single precision.
_UNIT_TOLERANCE = 1e-5


def light_arrays(
    direction: ArrayLike, irradiance: ArrayLike
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Directions and irradiances of lights as checked arrays."""
    direction = reals("direction", direction, 2)
    irradiance = reals("irradiance", irradiance, 2)
    sphere.direction_to_uv(direction)  # raises an error for a vector whose length is not 1
    if irradiance.shape != direction.shape:
        raise EnvLightsError(
            f"irradiance must have the shape {direction.shape}; got {irradiance.shape}"
        )
    return direction, amounts("irradiance", irradiance, LARGEST_LIGHT)


def amounts(name: str, values: NDArray[np.float64], most: float = np.inf) -> NDArray[np.float64]:
    """Finite `values` from 0 to `most`; raises an error that names the row."""
    is_good = np.isfinite(values) & (values >= 0) & (values <= most)
    if not is_good.all():
        row = int(np.argwhere(~is_good)[0][0])
        limit = f", and at most {most:.3g}" if np.isfinite(most) else ""
        raise EnvLightsError(
            f"{name} must be finite, not negative{limit}; row {row} holds {values[row].tolist()}"
        )
    return values


def axes_of_lights(name: str, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit vectors, or zero vectors for lights without such an axis; raises an error otherwise."""
    length = np.linalg.norm(values, axis=1)
    bad = np.flatnonzero(~((np.abs(length - 1) <= _UNIT_TOLERANCE) | (length == 0)))
    if len(bad):
        raise EnvLightsError(
            f"{name} must be unit vectors; row {bad[0]} holds {values[bad[0]].tolist()}"
        )
    return values


def radii(values: ArrayLike | None, lights: int) -> NDArray[np.float64]:
    """Checked angular radius of each light; 0 (points) if `values` is None."""
    if values is None:
        return np.zeros(lights)
    array = reals("angular_radius", values, 1)
    if len(array) != lights:
        raise EnvLightsError(
            f"angular_radius must have a row for each light ({lights}); got {len(array)}"
        )
    bad = np.flatnonzero(~((array >= 0) & (array <= np.pi / 2)))
    if len(bad):
        raise EnvLightsError(
            "angular_radius must be from 0 to pi / 2 radians;"
            f" row {bad[0]} holds {array[bad[0]]:.6g}"
        )
    return array


def rotate(direction: NDArray[np.float64], matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rotated unit vectors, (n, 3), normalised again in case `matrix` is inexact."""
    rotated = direction @ matrix.T
    rotated /= np.linalg.norm(rotated, axis=1, keepdims=True)
    return rotated + 0.0  # avoid -0.0


def rows_of(which: object, lights: int) -> NDArray[np.intp] | None:
    """Row indices of a slice, a list of indices or a mask; None for anything else."""
    if isinstance(which, slice):
        return np.arange(lights)[which]
    if not isinstance(which, list | np.ndarray):
        return None
    try:
        chosen = np.asarray(which, None if np.size(which) else np.intp)
    except ValueError:  # ragged lists
        return None
    if chosen.ndim != 1 or chosen.dtype.kind not in "iub":
        return None
    rows: NDArray[np.intp] = np.arange(lights)[chosen]
    return rows


def row_of(which: object, lights: int) -> int:
    """Row of an index, which counts from the end if negative."""
    try:
        row = operator.index(which)  # type: ignore[arg-type]
    except TypeError:
        raise EnvLightsError(
            "an index of lights must be a number, as in lights[0], a slice, as in lights[:4], or a"
            f" list of numbers; got {describe(which)}"
        ) from None
    if not -lights <= row < lights:
        raise IndexError(f"there are {lights} lights; got the index {row}")
    return row % lights
