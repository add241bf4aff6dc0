"""Axes of a target, and the rotations between them and ours.

Ours is right-handed with +y up; the centre of a map looks along +z, its left quarter along +x.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Matrix = tuple[tuple[int, int, int], ...]


class Axes(NamedTuple):
    """Axes of a target.

    Examples
    --------
    >>> import envlights as el
    >>> el.export.AXES["blender"].to_target([[0, 1, 0]])
    array([[0., 0., 1.]])
    >>> el.export.AXES["blender"].names
    ('+y', '+z', '+x')
    """

    matrix: Matrix
    """Rows: each axis of the target in our frame. Columns: our +x, +y, +z in the target."""

    map: Matrix | None = None
    """Directions of an unrotated equirectangular image in the target, or None without such maps.

    Column 2 is the direction of the centre of the image, column 0 that of its left quarter. If this
    is `matrix`, our maps need no rotation."""

    @property
    def handedness(self) -> int:
        """1 for a right-handed target, -1 for a left-handed one."""
        return round(float(np.linalg.det(self.matrix)))

    @property
    def hand(self) -> str:
        """Handedness as a word."""
        return "right" if self.handedness > 0 else "left"

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each of our axes in the target."""
        return tuple(map(_axis_name, zip(*self.matrix, strict=True)))

    def to_target(self, direction: ArrayLike) -> NDArray[np.float64]:
        """Directions, (n, 3), in the target's frame."""
        turned: NDArray[np.float64] = np.asarray(direction, np.float64) @ np.transpose(self.matrix)
        return turned + 0.0  # no minus zero

    def from_target(self, direction: ArrayLike) -> NDArray[np.float64]:
        """Directions of the target, (n, 3), in our frame."""
        turned: NDArray[np.float64] = np.asarray(direction, np.float64) @ np.asarray(self.matrix)
        return turned + 0.0

    def turn_of_map(self) -> NDArray[np.float64]:
        """Rotation in the target's frame that aligns the target's map with our lights."""
        turn: NDArray[np.float64] = np.asarray(self.matrix, np.float64) @ np.transpose(
            self.map or self.matrix
        )
        return turn


def _axis_name(direction: Iterable[int]) -> str:
    """Name of a direction along an axis, such as "+x"."""
    signs = zip(direction, "xyz", strict=True)
    return next(("+" if sign > 0 else "-") + axis for sign, axis in signs if sign)
