"""Directions on the sphere, and pixels of an equirectangular image."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native
from envlights._common.blocks import in_blocks
from envlights._common.check import count, flag, reals

#: Name of the frame in files.
FRAME = "right-handed, +y up; image centre +z, left quarter +x; towards the light"


def uv_to_direction(uv: ArrayLike) -> NDArray[np.float64]:
    """Directions at equirectangular image coordinates.

    Parameters
    ----------
    uv : array_like, shape (n, 2)
        `u` from the left edge (0) to the right (1), `v` from the top (0) to the bottom (1).

    Returns
    -------
    ndarray, shape (n, 3)
        ``(sin phi sin theta, cos theta, -cos phi sin theta)``, ``phi = 2 pi u``, ``theta = pi v``.

    See Also
    --------
    direction_to_uv : the inverse.

    Examples
    --------
    The centre of the image looks along +z:

    >>> uv_to_direction([[0.5, 0.5]]).round(12)
    array([[0., 0., 1.]])
    """
    return _native.uv_to_direction(reals("uv", uv, 2))


def direction_to_uv(direction: ArrayLike) -> NDArray[np.float64]:
    """Equirectangular image coordinates of directions.

    Parameters
    ----------
    direction : array_like, shape (n, 3)
        Unit vectors.

    Returns
    -------
    ndarray, shape (n, 2)
        `u` in [0, 1) and `v` in [0, 1].

    See Also
    --------
    uv_to_direction : the inverse.

    Examples
    --------
    >>> direction_to_uv([[1, 0, 0]])
    array([[0.25, 0.5 ]])
    """
    return _native.direction_to_uv(reals("direction", direction, 2))


def pixel_directions(
    height: int, width: int, *, border_sampled: bool = False
) -> NDArray[np.float64]:
    """Direction of each pixel sample in an equirectangular image.

    Parameters
    ----------
    height, width : int
        Size of the image, 2 or more.
    border_sampled : bool
        True: the outer pixels lie on the seam and the poles (OpenEXR's `envmap` files).

    Returns
    -------
    ndarray, shape (height, width, 3)

    Examples
    --------
    >>> pixel_directions(2, 4)[0, 0].round(3)
    array([ 0.5  ,  0.707, -0.5  ])
    """
    size = count("height", height), count("width", width)
    return _native.pixel_directions(*size, flag("border_sampled", border_sampled), 0, size[0])


def samples_at(image: NDArray[np.floating], directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Bilinear samples of a cell-centred map, (height, width, channels), at unit directions."""
    height, width, _ = image.shape
    u, v = direction_to_uv(directions).T
    x, y = u * width - 0.5, np.clip(v * height - 0.5, 0, height - 1)
    column, row = np.floor(x).astype(int), np.floor(y).astype(int)
    right, down = (x - column)[:, None], (y - row)[:, None]
    columns = column % width, (column + 1) % width
    rows = row, np.minimum(row + 1, height - 1)
    upper, lower = (
        (1 - right) * image[each, columns[0]] + right * image[each, columns[1]] for each in rows
    )
    samples: NDArray[np.float64] = (1 - down) * upper + down * lower
    return samples


def over_map(
    height: int, value: Callable[[NDArray[np.float64]], NDArray[Any]], *, finer: int = 1
) -> NDArray[Any]:
    """Results of `value` at the pixel directions of a map, computed in blocks of rows.

    `finer` multiplies the resolution at which `value` is called.
    """
    high, wide = finer * height, 2 * finer * height

    def of_rows(rows: slice) -> NDArray[Any]:
        return value(row_directions(high, slice(finer * rows.start, finer * rows.stop)))

    return in_blocks((height, finer * wide, 3), of_rows)


def row_directions(height: int, rows: slice) -> NDArray[np.float64]:
    """Directions of the pixels in a slice of rows of a map, (n, 2 * height, 3)."""
    return _native.pixel_directions(height, 2 * height, False, rows.start, rows.stop)


def pixel_solid_angles(
    height: int, width: int, *, border_sampled: bool = False
) -> NDArray[np.float64]:
    """Exact solid angle of each pixel in an equirectangular image.

    Parameters
    ----------
    height, width : int
        Size of the image, 2 or more.
    border_sampled : bool
        True: the outer pixels lie on the seam and the poles, which cut them.

    Returns
    -------
    ndarray, shape (height, width)
        Steradians; the sum is 4 pi.

    Examples
    --------
    >>> float(pixel_solid_angles(8, 16).sum() / (4 * np.pi))
    1.0
    """
    size = count("height", height), count("width", width)
    return _native.pixel_solid_angles(*size, flag("border_sampled", border_sampled))
