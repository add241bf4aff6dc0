"""Faces of cube maps: their order in conventions, and their arrangement in one picture."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from envlights._native import EnvLightsError
from envlights.environment.layouts.conventions import CONVENTIONS, CROSSES, FACES, Cross

_Samples = TypeVar("_Samples", bound=np.generic)

#: Names for the arrangement of six faces in one picture.
ARRANGEMENTS: tuple[str, ...] = ("stack", "strip", *CROSSES)


def upright_faces(stored: NDArray[_Samples], order: str) -> NDArray[_Samples]:
    """Six upright faces, (6, n, n, ...), in the order of `FACES`.

    Parameters
    ----------
    stored : ndarray, shape (6, n, n, ...)
        Faces in the order of a convention.
    order : str
        Name in `CONVENTIONS`.
    """
    convention = CONVENTIONS[order]
    if convention.faces == FACES and not any(convention.turns):
        return stored
    each = zip(stored, convention.faces, convention.turns, strict=True)
    upright = {face: np.rot90(picture, turns) for picture, face, turns in each}
    return np.stack([upright[face] for face in FACES])


def stored_faces(upright: NDArray[_Samples], order: str) -> NDArray[_Samples]:
    """Faces as a convention stores them, (6, n, n, ...), from six upright faces."""
    convention = CONVENTIONS[order]
    each = zip(convention.faces, convention.turns, strict=True)
    return np.stack([np.rot90(upright[FACES.index(face)], -turns) for face, turns in each])


def split_strip(image: NDArray[_Samples]) -> NDArray[_Samples]:
    """Six squares of a 6:1 or 1:6 picture, (6, n, n, ...), in picture order."""
    height, width = image.shape[:2]
    if height > width:
        return image.reshape(6, width, width, *image.shape[2:])
    squares = image.reshape(height, 6, height, *image.shape[2:])
    return squares.swapaxes(0, 1)


def faces_of_cross(image: NDArray[_Samples], order: str) -> NDArray[_Samples]:
    """Six upright faces, (6, n, n, ...), of an unfolded cube."""
    cross = CROSSES[order]
    each = zip(cross.places, cross.turns, strict=True)
    return np.stack([np.rot90(_square(image, cross, place), turns) for place, turns in each])


def outside_of_cross(image: NDArray[_Samples], order: str) -> NDArray[_Samples]:
    """Six squares of the cross, (6, n, n, ...), that contain no face."""
    cross = CROSSES[order]
    grid = ((row, column) for row in range(cross.rows) for column in range(cross.columns))
    return np.stack([_square(image, cross, at) for at in grid if at not in cross.places])


def cross_of_faces(upright: NDArray[_Samples], order: str) -> NDArray[_Samples]:
    """Unfolded cube from six upright faces, 0 elsewhere."""
    cross, n = CROSSES[order], upright.shape[1]
    image = np.zeros((cross.rows * n, cross.columns * n, *upright.shape[3:]), upright.dtype)
    for face, place, turns in zip(upright, cross.places, cross.turns, strict=True):
        _square(image, cross, place)[...] = np.rot90(face, -turns)
    return image


def arranged_faces(upright: NDArray[Any], order: str, arrangement: str) -> NDArray[Any]:
    """Picture of six upright faces: a stack or strip in a given order, or a cross."""
    if arrangement in CROSSES:
        return cross_of_faces(upright, arrangement)
    stored = stored_faces(upright, order)
    n = stored.shape[1]
    if arrangement == "stack":
        return stored.reshape(6 * n, n, *stored.shape[3:])
    return stored.swapaxes(0, 1).reshape(n, 6 * n, *stored.shape[3:])


def _square(image: NDArray[_Samples], cross: Cross, place: tuple[int, int]) -> NDArray[_Samples]:
    """View of a square of the grid."""
    n = image.shape[0] // cross.rows
    row, column = (n * index for index in place)
    return image[row : row + n, column : column + n]


def is_strip(height: int, width: int) -> bool:
    """True for an aspect ratio of 6:1 or 1:6."""
    return max(height, width) == 6 * min(height, width)


def crosses_of(height: int, width: int) -> tuple[str, ...]:
    """Names of the crosses with this aspect ratio."""
    return tuple(
        name
        for name, cross in CROSSES.items()
        if height * cross.columns == width * cross.rows and height % cross.rows == 0
    )


def check_square(sizes: dict[str, tuple[int, int]]) -> None:
    """Raise an error unless all faces are squares of one size; keys name the faces."""
    for name, (height, width) in sizes.items():
        if height != width:
            raise EnvLightsError(
                f"the faces of a cube are squares; {name} has {width}x{height} pixels; give six"
                " squares of one size"
            )
    if len({*sizes.values()}) > 1:
        said = ", ".join(f"{name} {size[1]}x{size[0]}" for name, size in sizes.items())
        raise EnvLightsError(f"the faces of a cube have one size; got {said}")
