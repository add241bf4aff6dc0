"""Axes of each target, in one table that every exporter uses.

Ours is right-handed with +y up; the centre of a map looks along +z, its left quarter along +x.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Matrix = tuple[tuple[int, int, int], ...]

_SAME: Matrix = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
#: Our x, y, z become y, z, x: +y becomes +z, and the centre of the map +x.
_CYCLE: Matrix = ((0, 0, 1), (1, 0, 0), (0, 1, 0))


#: Axes of an equirectangular map in three.js: its centre along +x, its left quarter along -z.
_THREE: Matrix = ((0, 0, 1), (0, 1, 0), (-1, 0, 0))

#: Axes of a map in pbrt's `imgtool makeequiarea`: +z up, the centre along -x, the left quarter
#: along +y. The matrix mirrors, because pbrt's frame is left-handed.
_PBRT: Matrix = ((0, 0, -1), (1, 0, 0), (0, 1, 0))
#: Unity: +x to the right; our +x is on the left of the map.
_MIRRORED_X: Matrix = ((-1, 0, 0), (0, 1, 0), (0, 0, 1))
#: Unity's Skybox/Panoramic: u = 0.5 - atan2(z, x) / 2 pi, so the centre looks along +x.
_PANORAMIC: Matrix = ((0, 0, 1), (0, 1, 0), (1, 0, 0))
#: Unreal: x forward, y to the right, z up.
_UNREAL: Matrix = ((0, 0, 1), (-1, 0, 0), (0, 1, 0))


class Axes(NamedTuple):
    """Axes of a target.

    Examples
    --------
    >>> AXES["blender"].to_target([[0, 1, 0]])
    array([[0., 0., 1.]])
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


#: Axes by the name of the target.
AXES = {
    "csv": Axes(_SAME),
    "mitsuba": Axes(_SAME, _SAME),
    "usd": Axes(_SAME, _SAME),
    "blender": Axes(_CYCLE, _CYCLE),
    "gltf": Axes(_SAME),
    "three": Axes(_THREE, _THREE),
    "radiance": Axes(_CYCLE, _CYCLE),
    "pbrt": Axes(_PBRT, _PBRT),
    "mujoco": Axes(_CYCLE),
    "godot": Axes(_SAME, _SAME),
    "unity": Axes(_MIRRORED_X, _PANORAMIC),
    "unreal": Axes(_UNREAL),
}
