"""Layout of a picture: its projection, and the part of the sphere that it shows."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from envlights._common.check import amount, check_choice, count, reals, unit_vector
from envlights._native import EnvLightsError

#: Matrix rows: forward, right and up of the picture, in the frame of maps.
Axes = tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]

#: Axes of a picture that looks along +z, so that its right is -x.
FRONT: Axes = ((0.0, 0.0, 1.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
#: Axes of a photographed mirror ball: forward is towards the camera, right as in the camera.
MIRRORED: Axes = ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
#: Axes of an octahedral square: up at the centre, -x at the right, +z at the bottom.
UP: Axes = ((0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, -1.0))
#: Axes of the squares of pbrt-v4: up at the centre, and mirrored.
PBRT: Axes = ((0.0, 1.0, 0.0), (0.0, 0.0, -1.0), (-1.0, 0.0, 0.0))

#: Fisheye mappings, which give the radius in focal lengths for the angle t from the axis: t, 2
#: sin(t / 2), 2 tan(t / 2), sin t.
MAPPINGS = ("equidistant", "equisolid", "stereographic", "orthographic")
#: Largest field of view of each mapping, in degrees; at 360, a stereographic picture is infinite.
_WIDEST = {"equidistant": 360.0, "equisolid": 360.0, "stereographic": 355.0, "orthographic": 180.0}


class PictureLayout(NamedTuple):
    """Projection of a picture, as the kernels need it.

    Pixel coordinates start at the top left corner of the picture, so that the centre of its first
    pixel is (0.5, 0.5). A cube is always the stack of six upright faces, as seen from inside:
    front, right, back, left, up, down.
    """

    kind: str
    """Projection, by its name in the kernels; all circular ones are "azimuthal"."""

    height: int
    """Rows of the picture; 6 n for a cube with faces of n x n pixels."""

    width: int
    """Columns of the picture; n for a cube."""

    border_sampled: bool = False
    """True if the outer samples lie on the borders of the picture or of each face."""

    whole: tuple[int, int] | None = None
    """Rows and columns of the whole sphere, if the picture is an equirectangular crop."""

    corner: tuple[int, int] = (0, 0)
    """Row and column of an equirectangular crop in the whole sphere."""

    field_of_view: float = 0.0
    """Horizontal field of view in radians, of a cylinder, a planar picture or the face of a cube; 0
    is 90 degrees for a face."""

    horizon: float | None = None
    """Row coordinate of elevation 0 in a cylinder; None for the centre."""

    mapping: str = ""
    """Mapping of an azimuthal picture: one of `MAPPINGS`."""

    reach: float = 0.0
    """Angle between the axis and the edge of an azimuthal picture, in radians."""

    circle: tuple[float, float, float] | None = None
    """Centre x, centre y and radius of the circle in pixels; None for the largest circle."""

    axes: Axes = FRONT
    """Unit vectors forward, right and up of the picture, in the frame of maps."""

    @property
    def is_whole_sphere(self) -> bool:
        """True for a complete equirectangular picture with its centre along +z."""
        return self.kind == "equirectangular" and self.whole is None and self.axes == FRONT


def equirectangular(
    height: int, width: int | None = None, *, border_sampled: bool = False, axes: Axes = FRONT
) -> PictureLayout:
    """Layout of a complete panorama; the default width is twice the height."""
    rows = count("height", height, least=2)
    columns = 2 * rows if width is None else count("width", width, least=2)
    return PictureLayout("equirectangular", rows, columns, border_sampled, axes=axes)


def crop(
    height: int, width: int, *, field_of_view: float, horizon: float | None = None
) -> PictureLayout:
    """Layout of a centred crop of a panorama, `field_of_view` radians wide."""
    view = _view(field_of_view, 360.0)
    rows = max(round(width * math.pi / view), math.ceil(width / 2))
    rows = height if height == rows + 1 else rows
    middle = height / 2 if horizon is None else amount("horizon", horizon, -rows, 2 * rows)
    top, left = round(rows / 2 - middle), round(rows - width / 2)
    if not 0 <= top <= rows - height:
        raise EnvLightsError(
            f"a picture of {width}x{height} pixels with a field of view of {math.degrees(view):g}"
            f" degrees and its horizon in row {middle:g} reaches beyond a pole; give another"
            " field of view or horizon"
        )
    return PictureLayout(
        "equirectangular", height, width, whole=(rows, 2 * rows), corner=(top, left)
    )


def cylinder(
    height: int, width: int, *, field_of_view: float, horizon: float | None = None
) -> PictureLayout:
    """Layout of a cylindrical panorama, `field_of_view` radians wide, with any horizon row."""
    view = _view(field_of_view, 360.0)
    row = None if horizon is None else amount("horizon", horizon, -100.0 * height, 100.0 * height)
    return PictureLayout("cylinder", height, width, field_of_view=view, horizon=row)


def cube(
    n: int, *, border_sampled: bool = False, field_of_view: float | None = None
) -> PictureLayout:
    """Layout of a cube with faces of n x n pixels, as the stack of six upright faces.

    The field of view of a face is in radians; 90 degrees when left out.
    """
    side = count("n", n, least=2 if border_sampled else 1)
    return PictureLayout("cube", 6 * side, side, border_sampled, field_of_view=field_of_view or 0.0)


def octahedral(n: int, *, equal_area: bool = False, axes: Axes = FRONT) -> PictureLayout:
    """Layout of an octahedron unfolded to n x n pixels; `n` must be even unless `equal_area`."""
    side = count("n", n, least=2)
    if side % 2 and not equal_area:
        raise EnvLightsError(
            f"an octahedral map has an even number of columns; got {side}; leave out one row and"
            " one column"
        )
    kind = "octahedral-equal-area" if equal_area else "octahedral"
    return PictureLayout(kind, side, side, axes=axes)


def angular_map(n: int, *, axes: Axes = FRONT) -> PictureLayout:
    """Layout of an angular map, or light probe: an equidistant disc of the whole sphere."""
    side = count("n", n, least=2)
    return PictureLayout("azimuthal", side, side, mapping="equidistant", reach=math.pi, axes=axes)


def mirror_ball(
    n: int, *, circle: tuple[float, float, float] | None = None, axes: Axes = MIRRORED
) -> PictureLayout:
    """Layout of a photograph of a mirror ball from far away.

    By default the centre shows the camera and the picture is a mirror image, as photographed. Axes
    `FRONT` are those of a ball that was mirrored to the view from inside.
    """
    side = count("n", n, least=2)
    return PictureLayout(
        "azimuthal", side, side, mapping="equisolid", reach=math.pi, circle=circle, axes=axes
    )


def fisheye(
    size: int | tuple[int, int],
    mapping: str,
    field_of_view: float,
    *,
    circle: tuple[float, float, float] | None = None,
    axes: Axes = FRONT,
) -> PictureLayout:
    """Layout of a circular fisheye picture; `size` is a number n, or (rows, columns).

    The field of view is the angle across the circle, in radians.
    """
    check_choice("mapping", mapping, MAPPINGS)
    view = _view(field_of_view, _WIDEST[mapping])
    height, width = (size, size) if isinstance(size, int) else size
    return PictureLayout(
        "azimuthal", height, width, mapping=mapping, reach=view / 2, circle=circle, axes=axes
    )


def planar(height: int, width: int, *, field_of_view: float, axes: Axes = FRONT) -> PictureLayout:
    """Layout of a photograph without distortion, `field_of_view` radians wide."""
    view = _view(field_of_view, 179.0)
    return PictureLayout("planar", height, width, field_of_view=view, axes=axes)


def _view(radians: float, widest: float) -> float:
    """Field of view in radians; error messages state it in degrees, as users give it."""
    amount("fov", math.degrees(amount("field_of_view", radians)), 0.05, widest * (1 + 1e-9))
    return float(radians)


def checked_axes(axes: ArrayLike) -> Axes:
    """Axes of a picture; raises an error unless the vectors are orthonormal."""
    matrix = reals("axes", axes, 2)
    if matrix.shape != (3, 3) or not np.allclose(matrix @ matrix.T, np.eye(3), atol=1e-6):
        raise EnvLightsError(
            "axes must be three orthonormal vectors, forward, right and up; got"
            f" {np.asarray(axes).tolist()}"
        )
    rows = [tuple(row) for row in matrix.tolist()]
    return (rows[0], rows[1], rows[2])


def looking(forward: ArrayLike, name: str = "forward") -> Axes:
    """Axes of a level camera that looks in a direction.

    Parameters
    ----------
    forward : array_like, shape (3,)
        Direction of any length. Straight up or down the pictures are those of the faces of a cube.
    name : str
        Name of the argument, for a refusal.

    Raises
    ------
    EnvLightsError
        If it is no direction.

    Examples
    --------
    >>> looking([0, 0, 2]) == FRONT
    True
    """
    forward = unit_vector(name, forward)
    level = np.hypot(forward[0], forward[2])
    if level < 1e-9:
        side = 1.0 if forward[1] > 0 else -1.0
        return ((0.0, side, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, -side))
    right = np.array([-forward[2], 0.0, forward[0]]) / level
    up = np.cross(right, forward)
    rows = [tuple(float(value) + 0.0 for value in row) for row in (forward, right, up)]
    return (rows[0], rows[1], rows[2])  # type: ignore[return-value]
