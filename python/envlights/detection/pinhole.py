"""Pinhole camera of a photograph: directions of places, solid angles of pixels.

The frame is that of the photograph: it looks along +z, its right is -x, its upper side +y.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Pinhole(NamedTuple):
    """Camera without distortion, with its axis in the middle of the picture."""

    height: int
    """Rows of the picture."""

    width: int
    """Columns of the picture."""

    focal: float
    """Focal length in pixels."""

    @classmethod
    def of_field(cls, height: int, width: int, field_of_view: float) -> Pinhole:
        """Camera with a horizontal field of view in radians."""
        return cls(height, width, width / 2 / math.tan(field_of_view / 2))

    @property
    def field_of_view(self) -> float:
        """Horizontal field of view in radians."""
        return 2 * math.atan(self.width / 2 / self.focal)

    def directions(self, position: NDArray[np.float64]) -> NDArray[np.float64]:
        """Unit vectors towards places (x, y) from the top left corner, (n, 3)."""
        right, up = self._slopes(position[:, 0], position[:, 1])
        vectors = np.stack([-right, up, np.ones_like(right)], axis=1)
        unit: NDArray[np.float64] = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
        return unit

    def solid_angles(self, pixel: NDArray[np.int64], size: tuple[int, int]) -> NDArray[np.float64]:
        r"""Exact solid angles of pixels (row, column) of the picture at another `size`, (n,).

        :math:`A(a, b) = \mathrm{atan2}(ab, \sqrt{1 + a^2 + b^2})` is the solid angle from the axis
        to the slopes a and b; a pixel has four corners.
        """
        y, x = (pixel / size * (self.height, self.width)).T
        right, up = self._slopes(x, y)
        far_right, down = self._slopes(x + self.width / size[1], y + self.height / size[0])
        return (
            _corner(far_right, up)
            - _corner(right, up)
            - _corner(far_right, down)
            + _corner(right, down)
        )

    def _slopes(
        self, x: NDArray[np.float64], y: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Tangents of the angles to the right and up."""
        return (x - self.width / 2) / self.focal, (self.height / 2 - y) / self.focal


def _corner(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    angle: NDArray[np.float64] = np.arctan2(a * b, np.sqrt(1 + a * a + b * b))
    return angle
