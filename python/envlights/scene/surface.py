"""The surfaces of a scene as a lightmap of positions, normals and albedo."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.arrays import freeze
from envlights._common.check import first_not_finite, reals
from envlights._common.result import Result
from envlights._common.words import percent
from envlights._native import EnvLightsError

#: Height above a surface at which rays start, relative to the size of the scene, so that it does
#: not shadow itself.
_LIFT = 1e-4


@dataclass(frozen=True, eq=False, repr=False)
class Surface(Result):
    """Diffuse surfaces as texels, in the form that most tools can bake.

    Examples
    --------
    Two texels of a white floor, and one without a surface:

    >>> floor = Surface([[[0, 0, 0], [1, 0, 0], [0, 0, 0]]], [[[0, 1, 0], [0, 1, 0], [0, 0, 0]]],
    ...                 [[[0.8, 0.8, 0.8]] * 3])
    >>> floor.covered
    array([[ True,  True, False]])
    """

    position: NDArray[np.float64]
    """Points in the units of the scene, (H, W, 3): right-handed, +y up."""

    normal: NDArray[np.float64]
    """Unit normals on the visible side, (H, W, 3); zero where a texel has no surface."""

    albedo: NDArray[np.float64]
    """Reflectance of a Lambertian surface, linear RGB, (H, W, 3)."""

    def in_short(self) -> str:
        """Size and covered texels."""
        height, width, _ = self.position.shape
        return f"{width}x{height} texels, {percent(self.covered.mean())} with a surface"

    def __post_init__(self) -> None:
        # Check and seal the maps.
        for name in ("position", "normal", "albedo"):
            object.__setattr__(self, name, freeze(_map(name, getattr(self, name))))
            _check_size(name, getattr(self, name).shape, self.position.shape)
        # Raise an error for normals with lengths other than 0 or 1, an empty surface, a negative
        # albedo.
        length = np.linalg.norm(self.normal, axis=-1)
        bad = np.argwhere((length > 0) & (np.abs(length - 1) > 1e-3))
        if len(bad):
            row, column = bad[0]
            raise EnvLightsError(
                "normal must have the length 1, or 0 where there is no surface; that at row"
                f" {row}, column {column} has {length[row, column]:.6g}"
            )
        if not length.any():
            raise EnvLightsError("normal is zero in every texel; the surface is empty")
        if (self.albedo < 0).any():
            raise EnvLightsError(f"albedo must not be negative; got {self.albedo.min():g}")

    @property
    def covered(self) -> NDArray[np.bool_]:
        """Mask of the texels with a surface, (H, W)."""
        return np.asarray(np.any(self.normal != 0, axis=-1), np.bool_)

    @property
    def lift(self) -> float:
        """Height above the surface at which rays start, in the units of the scene."""
        points = self.position[self.covered]
        return _LIFT * float(np.linalg.norm(np.ptp(points, axis=0))) or _LIFT

    def lifted(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Origins of rays and unit normals at the covered texels, (n, 3) each."""
        normal = self.normal[self.covered]
        normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)
        return self.position[self.covered] + self.lift * normal, normal

    def thinned(self, rows: int, columns: int) -> Surface:
        """Surface with the middle texel of each block of `rows` x `columns` texels."""
        some = slice(rows // 2, None, rows), slice(columns // 2, None, columns)
        return Surface(self.position[some], self.normal[some], self.albedo[some])

    def reflected(self, irradiance: NDArray[np.float64]) -> NDArray[np.float64]:
        """Radiance of the surface, (H, W, 3), for `irradiance` of its covered texels, (n, 3)."""
        image = np.zeros(self.albedo.shape)
        image[self.covered] = irradiance
        image *= self.albedo / np.pi
        return image

    def means(self, image: NDArray[np.float64], size: int) -> NDArray[np.float64]:
        """Means over the covered texels of each of `size` x `size` blocks, 0 if there are none."""
        rows, columns, _ = image.shape
        blocks = (size, rows // size, size, columns // size)
        count = self.covered.reshape(blocks).sum(axis=(1, 3))[..., None]
        total = (image * self.covered[..., None]).reshape(*blocks, 3).sum(axis=(1, 3))
        mean: NDArray[np.float64] = np.divide(
            total, count, out=np.zeros_like(total), where=count > 0
        )
        return mean


def tangent_frames(normal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Two tangents and the normal as rows of right-handed frames, (n, 3, 3).

    Duff et al. (2017), "Building an orthonormal basis, revisited".
    """
    x, y, z = normal.T
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    first = np.stack([1 + sign * x * x * a, sign * b, -sign * x], axis=-1)
    second = np.stack([b, sign + y * y * a, -y], axis=-1)
    return np.stack([first, second, normal], axis=1)


def _map(name: str, values: ArrayLike) -> NDArray[np.float64]:
    array = reals(name, values, 3)
    if array.shape[2] != 3 or 0 in array.shape:
        raise EnvLightsError(f"{name} must have the shape (height, width, 3); got {array.shape}")
    if bad := first_not_finite(array):
        row, column, value = bad
        raise EnvLightsError(f"{name} must be finite; row {row}, column {column} holds {value}")
    return array


def _check_size(name: str, given: tuple[int, ...], wanted: tuple[int, ...]) -> None:
    if given != wanted:
        raise EnvLightsError(f"{name} must have the shape of position, {wanted}; got {given}")
