"""Coordinate frames of other programs: their axes and camera matrices, relative to ours.

Ours is right-handed with +y up; the centre of a map looks along +z, its left quarter along +x.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import amount, check_choice, reals, unit_vector
from envlights._common.check import rotation as checked_rotation
from envlights._native import EnvLightsError

__all__ = ["FRAMES", "Axes", "rotation"]

Matrix = tuple[tuple[int, int, int], ...]

_OURS: Matrix = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
#: Cameras of OpenGL: +x right, +y up, view along -z.
_OPENGL: Matrix = ((-1, 0, 0), (0, 1, 0), (0, 0, -1))
#: Cameras of OpenCV: +x right, +y down, view along +z.
_OPENCV: Matrix = ((-1, 0, 0), (0, -1, 0), (0, 0, 1))
#: Cyclic axes: our x, y, z become y, z, x; +y becomes +z, and the centre of the map +x.
_CYCLE: Matrix = ((0, 0, 1), (1, 0, 0), (0, 1, 0))
#: Quarter turn about +x of `UsdLuxDomeLight::OrientToStageUpAxis`, and of programs that reference a
#: stage of +y up.
_UPRIGHT: Matrix = ((1, 0, 0), (0, 0, -1), (0, 1, 0))
#: Axes of an equirectangular map in three.js: centre along +x, left quarter along -z.
_THREE: Matrix = ((0, 0, 1), (0, 1, 0), (-1, 0, 0))
#: Axes of a map in pbrt's `imgtool makeequiarea`: +z up, the centre along -x, the left quarter
#: along +y. The matrix mirrors, because pbrt's frame is left-handed.
_PBRT: Matrix = ((0, 0, -1), (1, 0, 0), (0, 1, 0))
#: Unity: +x right, while our +x is on the left of the map.
_MIRRORED_X: Matrix = ((-1, 0, 0), (0, 1, 0), (0, 0, 1))
#: Unity's Skybox/Panoramic: u = 0.5 - atan2(z, x) / 2 pi, so the centre looks along +x.
_PANORAMIC: Matrix = ((0, 0, 1), (0, 1, 0), (1, 0, 0))
#: Unreal: x forward, y right, z up.
_UNREAL: Matrix = ((0, 0, 1), (-1, 0, 0), (0, 1, 0))


class Axes(NamedTuple):
    """Frame of a program: its axes, and the axes of its cameras.

    Examples
    --------
    >>> import envlights as el
    >>> el.frames.FRAMES["blender"].to_target([[0, 1, 0]])
    array([[0., 0., 1.]])
    >>> el.frames.FRAMES["blender"].names
    ('+y', '+z', '+x')
    """

    matrix: Matrix
    """Rows: axes of the target in our frame. Columns: our +x, +y, +z in the target."""

    map: Matrix | None = None
    """Directions of an unrotated equirectangular image in the target; None if it has no such maps.

    Column 2 is the direction of the centre of the image, column 0 that of its left quarter. If this
    is `matrix`, our maps need no rotation."""

    camera: Matrix = _OPENGL
    """Axes of a camera that looks at the centre of an unrotated map."""

    is_extrinsic: bool = False
    """True if a camera matrix maps world to camera, False if it maps camera to world."""

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
        """Name of each of our axes in the target frame."""
        return tuple(map(_axis_name, zip(*self.matrix, strict=True)))

    def to_target(self, direction: ArrayLike) -> NDArray[np.float64]:
        """Directions, (n, 3) or (3,), converted to the target frame."""
        turned: NDArray[np.float64] = _vectors(direction) @ np.transpose(self.matrix)
        return turned + 0.0  # avoid -0.0

    def from_target(self, direction: ArrayLike) -> NDArray[np.float64]:
        """Directions of the target, (n, 3) or (3,), converted to our frame."""
        turned: NDArray[np.float64] = _vectors(direction) @ np.asarray(self.matrix)
        return turned + 0.0

    def turn_of_map(self) -> NDArray[np.float64]:
        """Rotation in the target frame that aligns the target's map with our lights."""
        turn: NDArray[np.float64] = np.asarray(self.matrix, np.float64) @ np.transpose(
            self.map or self.matrix
        )
        return turn

    def rotation(self, matrix: ArrayLike) -> NDArray[np.float64]:
        """Rotation in our frame equal to `matrix`, (3, 3), in the target frame."""
        own = np.asarray(self.matrix)
        turn: NDArray[np.float64] = own.T @ checked_rotation(matrix) @ own
        return turn

    def view(self, camera: ArrayLike) -> NDArray[np.float64]:
        """Rotation in our frame that moves the view direction of a camera to the centre of a map.

        Parameters
        ----------
        camera : array_like, shape (3, 3), (3, 4) or (4, 4)
            The camera's matrix as the program stores it: from the camera to the world, or the other
            way if `is_extrinsic`. A translation is not used.

        Examples
        --------
        A camera of nerfstudio that looks along +y of the world, with +z up, sees our +x ahead:

        >>> import envlights as el
        >>> pose = [[1, 0, 0, 5], [0, 0, -1, 5], [0, 1, 0, 5]]
        >>> el.frames.FRAMES["nerfstudio"].view(pose) @ [1, 0, 0]
        array([0., 0., 1.])
        """
        pose = reals("camera", camera, 2)
        if pose.shape in ((3, 4), (4, 4)):
            pose = pose[:3, :3]
        to_camera = checked_rotation(pose, "camera")
        to_camera = to_camera if self.is_extrinsic else to_camera.T
        turn: NDArray[np.float64] = np.transpose(self.camera) @ to_camera @ np.asarray(self.matrix)
        return turn + 0.0


def _vectors(direction: ArrayLike) -> NDArray[np.float64]:
    """Vectors along the last axis; raises an error for other values."""
    vectors = reals("direction", direction, None)
    if vectors.shape[-1:] != (3,):
        raise EnvLightsError(f"direction must have the shape (n, 3) or (3,); got {vectors.shape}")
    return vectors


def _axis_name(direction: Iterable[int]) -> str:
    """Name of a direction along an axis, such as "+x"."""
    signs = zip(direction, "xyz", strict=True)
    return next(("+" if sign > 0 else "-") + axis for sign, axis in signs if sign)


#: Frame of each program. The centre of a map is straight ahead of a camera of OpenGL, OpenCV,
#: COLMAP, Unity, Unreal and ROS, and where the others show the centre of a panorama. nerfstudio has
#: Blender's world, +z up.
FRAMES: dict[str, Axes] = {
    "envlights": Axes(_OURS, _OURS, _OURS),
    "opengl": Axes(_OPENGL),
    "opencv": Axes(_OPENCV, camera=_OPENCV, is_extrinsic=True),
    "colmap": Axes(_OPENCV, camera=_OPENCV, is_extrinsic=True),
    "nerfstudio": Axes(_CYCLE),
    "blender": Axes(_CYCLE, _CYCLE),
    "usd": Axes(_OURS, _OURS),
    "usd-z": Axes(_UPRIGHT, _UPRIGHT),
    "unreal": Axes(_UNREAL, camera=_UNREAL),
    "unity": Axes(_MIRRORED_X, _PANORAMIC, _MIRRORED_X),
    "mitsuba": Axes(_OURS, _OURS, _OURS),
    "three": Axes(_THREE, _THREE),
    "gltf": Axes(_OURS),
    "godot": Axes(_OURS, _OURS),
    "radiance": Axes(_CYCLE, _CYCLE),
    "pbrt": Axes(_PBRT, _PBRT, _MIRRORED_X),
    "mujoco": Axes(_CYCLE),
    "sapien": Axes(_CYCLE),
    "genesis": Axes(_CYCLE),
    "ros": Axes(_CYCLE, camera=_CYCLE),
}


def frame_named(name: object) -> Axes:
    """Frame by name; raises an error that lists the known names."""
    check_choice("frame", name, tuple(FRAMES))
    return FRAMES[str(name)]


def rotation(yaw: float = 0.0, pitch: float = 0.0, roll: float = 0.0) -> NDArray[np.float64]:
    """Rotation by three angles in radians, for `EnvMap.rotated`, `Rig.rotated` and their like.

    Parameters
    ----------
    yaw : float
        Turn about +y: the centre of the map, +z, goes to the left, to +x.
    pitch : float
        Turn about +x: the centre of the map goes up.
    roll : float
        Turn about +z: the zenith goes to the left. It is the first turn, the yaw the last.

    Returns
    -------
    ndarray, shape (3, 3)

    Examples
    --------
    >>> import numpy as np
    >>> import envlights as el
    >>> (el.frames.rotation(yaw=np.pi / 2) @ [0, 0, 1]).round(9)
    array([1., 0., 0.])
    """
    turn = np.eye(3)
    for name, angle, (start, end) in (
        ("yaw", yaw, (2, 0)),
        ("pitch", pitch, (2, 1)),
        ("roll", roll, (1, 0)),
    ):
        value = amount(name, angle, -math.inf)
        step = np.eye(3)
        step[[start, end], [start, end]] = math.cos(value)
        step[end, start], step[start, end] = math.sin(value), -math.sin(value)
        turn = turn @ step
    return turn


def turn_of(
    matrix: ArrayLike | None, frame: str | None, camera: ArrayLike | None
) -> NDArray[np.float64]:
    """Rotation in our frame, from a rotation matrix or from a camera matrix."""
    axes = frame_named("envlights" if frame is None else frame)
    if matrix is not None and camera is None:
        return axes.rotation(matrix)
    if camera is None or matrix is not None or frame is None:
        raise EnvLightsError(
            "give a matrix, a rotation, or the matrix of a camera and its frame, such as"
            " camera=pose, frame='nerfstudio'"
        )
    return axes.view(camera)


def turn_upright(up: ArrayLike) -> NDArray[np.float64]:
    """Smallest rotation that takes the direction `up`, of any length above 0, to +y."""
    x, y, z = unit_vector("up", up)
    if y < -1 + 1e-12:
        return np.diag([-1.0, -1.0, 1.0])  # keep the centre of the map
    # Rodrigues' formula for the axis (-z, 0, x), whose length is the sine.
    axis = np.array([[0, -x, 0], [x, 0, z], [0, -z, 0]])
    turn: NDArray[np.float64] = np.eye(3) + axis + axis @ axis / (1 + y)
    return turn


def __dir__() -> list[str]:
    return sorted(__all__)
