"""Evenly distributed points in a square or on the sphere."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native
from envlights._common.check import count, counts, reals


def radical_inverse(index: int, base: int = 2) -> float:
    """Radical inverse of `index` in `base` (van der Corput's sequence).

    Parameters
    ----------
    index : int
        0 or more.
    base : int
        2 or more.

    Returns
    -------
    float
        In [0, 1).

    Examples
    --------
    >>> [radical_inverse(i) for i in range(4)]
    [0.0, 0.5, 0.25, 0.75]
    """
    return _native.radical_inverse(count("index", index), count("base", base))


def hammersley(n: int) -> NDArray[np.float64]:
    """`n` Hammersley points of the unit square: `i / n` and the radical inverse of `i` in base 2.

    Parameters
    ----------
    n : int
        Number of points.

    Returns
    -------
    ndarray, shape (n, 2)

    Examples
    --------
    >>> hammersley(4)
    array([[0.  , 0.  ],
           [0.25, 0.5 ],
           [0.5 , 0.25],
           [0.75, 0.75]])
    """
    return _native.hammersley(count("n", n))


def halton(n: int, bases: Sequence[int] = (2, 3)) -> NDArray[np.float64]:
    """First `n` Halton points: a radical inverse in each of `bases`.

    Parameters
    ----------
    n : int
        Number of points.
    bases : sequence of int
        One base for each axis, 2 or more, without common factors.

    Returns
    -------
    ndarray, shape (n, len(bases))

    Examples
    --------
    >>> halton(3).round(3)
    array([[0.   , 0.   ],
           [0.5  , 0.333],
           [0.25 , 0.667]])
    """
    return _native.halton(count("n", n), counts("bases", bases))


def uniform_sphere(uv: ArrayLike) -> NDArray[np.float64]:
    """Map points of the unit square to the sphere, with equal areas.

    Parameters
    ----------
    uv : array_like, shape (n, 2)
        `u` runs from the zenith to the nadir (``y = 1 - 2 u``), `v` around (``phi = 2 pi v``).

    Returns
    -------
    ndarray, shape (n, 3)
        Unit vectors.

    Examples
    --------
    >>> uniform_sphere([[0, 0], [0.5, 0.25]]).round(12) + 0.0
    array([[0., 1., 0.],
           [1., 0., 0.]])
    """
    return _native.uniform_sphere(reals("uv", uv, 2))


def icosphere(faces: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Face normals of a subdivided icosahedron, evenly spread, and their solid angles.

    Parameters
    ----------
    faces : int
        ``20 * 4**k``: Madsen et al. (2003) use 320 for the probe and 5120 for the scene.

    Returns
    -------
    centroids : ndarray, shape (faces, 3)
        Unit vectors.
    solid_angles : ndarray, shape (faces,)
        Steradians. They differ by -7 % to +20 % from their mean: weight by them.

    Examples
    --------
    >>> normals, solid_angles = icosphere(320)
    >>> normals.shape, round(float(solid_angles.sum() / np.pi), 12)
    ((320, 3), 4.0)
    """
    return _native.icosphere(count("faces", faces))
