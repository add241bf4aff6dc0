"""Checks and defaults for the array fields of cards."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.arrays import seal
from envlights._common.check import describe, reals, texts
from envlights._native import EnvLightsError
from envlights.cards import geometry
from envlights.rigs.light_arrays import LARGEST_LIGHT, amounts, radii

#: Shapes of a card. Spheres, points and others are facing squares around a light.
SHAPES = ("rectangle", "tube", "disc", "point", "other", "sphere")
#: Shapes with an outline, and those whose outline is an ellipse.
OUTLINED, ROUND = ("rectangle", "tube", "disc", "sphere"), ("disc", "sphere")


def matrices(values: ArrayLike) -> NDArray[np.float64]:
    """Matrices of cards; raises an error for cards that are invisible from the origin."""
    matrix = reals("matrix", values, None)
    matrix = matrix if matrix.size else np.zeros((0, 3, 3))
    if matrix.shape[1:] != (3, 3):
        raise EnvLightsError(f"matrix must have the shape (n, 3, 3); got {matrix.shape}")
    volume = np.linalg.det(matrix)
    bad = np.flatnonzero(~(np.isfinite(matrix).all(axis=(1, 2)) & (volume > 0)))
    if len(bad):
        raise EnvLightsError(
            "matrix must hold finite columns U, V, O with a positive determinant: U to the right,"
            f" V down, seen from the origin; card {bad[0]} has {volume[bad[0]]:.4g}"
        )
    return matrix


def shapes(values: Sequence[str], cards: int) -> tuple[str, ...]:
    """Shape names, one per card; raises an error for other values."""
    shape = tuple(texts("shape", values))
    if len(shape) != cards:
        raise EnvLightsError(f"shape must have one name for each card ({cards}); got {len(shape)}")
    for name in shape:
        if name not in SHAPES:
            raise EnvLightsError(f"shape must be one of {', '.join(SHAPES)}; got '{name}'")
    return shape


def rows(name: str, values: ArrayLike, rows: int, columns: int) -> NDArray[np.float64]:
    """Array with this number of rows and columns; raises an error that names the argument."""
    array = reals(name, values, None)
    array = array if array.size else np.zeros((0, columns))
    if array.shape != (rows, columns):
        raise EnvLightsError(f"{name} must have the shape ({rows}, {columns}); got {array.shape}")
    return array


def overlaps(values: ArrayLike | None, cards: int) -> NDArray[np.float64]:
    """Overlap of each card, by default 1; raises an error for invalid values."""
    array = np.ones(cards) if values is None else reals("overlap", values, 1)
    if array.shape != (cards,) or not ((array >= 0) & (array <= 1)).all():
        raise EnvLightsError(
            f"overlap must hold a number from 0 to 1 for each card ({cards}); got {array.tolist()}"
        )
    return array


def uniform_radiance(
    matrix: NDArray[np.float64], shape: tuple[str, ...], irradiance: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Uniform radiance for which cards have this irradiance, (n, 3)."""
    vectors = [
        geometry.vector_irradiance(geometry.outline(each, name in ROUND))
        for each, name in zip(matrix, shape, strict=True)
    ]
    towards = geometry.unit(geometry.centres(matrix))
    unit = np.einsum("ni,ni->n", np.reshape(vectors, (-1, 3)), towards)
    radiance: NDArray[np.float64] = irradiance / unit[:, None]
    return radiance


def angular_radii(
    values: ArrayLike | None,
    order: NDArray[np.intp],
    matrix: NDArray[np.float64],
    shape: tuple[str, ...],
) -> NDArray[np.float64]:
    """Radius of each light, in `order`; by default from the vector irradiance of its card."""
    unit = 1 / uniform_radiance(matrix, shape, np.ones((len(matrix), 3)))[:, 0]
    angles: NDArray[np.float64] = np.arcsin(np.sqrt(np.minimum(unit / np.pi, 1)))
    if values is None:
        return angles
    # Replace NaN with the default.
    given = reals("angular_radius", values, 1)
    if given.shape == (len(order),):
        given = np.where(np.isnan(given[order]), angles, given[order])
    return radii(given, len(order))


def all_textures(
    values: Sequence[ArrayLike] | None, order: NDArray[np.intp], radiance: NDArray[np.float64]
) -> tuple[NDArray[np.float32], ...]:
    """Read-only textures in `order`; by default a single texel of uniform radiance."""
    if values is None:
        # In the order of the caller, so that the error names the caller's row.
        amounts("the radiance of a card", radiance[np.argsort(order)], LARGEST_LIGHT)
        return tuple(seal(colour.astype(np.float32)[None, None]) for colour in radiance)
    try:
        each = list(values)
    except TypeError:
        raise EnvLightsError(
            f"textures must be a sequence with an array for each card; got {describe(values)}"
        ) from None
    if len(each) != len(order):
        raise EnvLightsError(
            f"textures must have one for each card ({len(order)}); got {len(each)}"
        )
    return tuple(_texture(each[row]) for row in order)


def _texture(values: ArrayLike) -> NDArray[np.float32]:
    array = values if isinstance(values, np.ndarray) else reals("textures", values, None)
    if (
        array.dtype.kind not in "fiu"
        or array.ndim != 3
        or array.shape[2:] != (3,)
        or not array.size
    ):
        raise EnvLightsError(
            f"textures must have the shape (rows, columns, 3); got {array.shape} of {array.dtype}"
        )
    if not ((array >= 0) & (array <= LARGEST_LIGHT)).all():
        raise EnvLightsError(
            "textures must be finite and not negative; got samples from"
            f" {array.min():.4g} to {array.max():.4g}"
        )
    return seal(array.astype(np.float32))
