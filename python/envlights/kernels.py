"""The compiled steps on plain numpy arrays, one function for each step.

Directions are unit vectors in the frame of `EnvMap`: right-handed, +y up, the centre of an
equirectangular image along +z, its left quarter along +x. All arrays are float64 unless a
function says otherwise; none is changed. An array must not be written to by another thread while a
kernel reads it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native
from envlights._check import count, reals

__all__ = [
    "direction_to_uv",
    "halton",
    "hammersley",
    "icosphere",
    "irradiance",
    "pixel_directions",
    "pixel_solid_angles",
    "radical_inverse",
    "relative_rms",
    "rig_irradiance",
    "sum_over_sources",
    "uniform_sphere",
    "uv_to_direction",
    "working_irradiance",
]

#: Width of the map that `working_irradiance` makes when it is not told another.
WORKING_COLUMNS = 256


def radical_inverse(index: int, base: int = 2) -> float:
    """Digits of `index` in `base`, mirrored behind the point: van der Corput's sequence.

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
        How many.

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
        How many.
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
    return _native.halton(count("n", n), [count("base", base) for base in bases])


def uniform_sphere(uv: ArrayLike) -> NDArray[np.float64]:
    """Points of the unit square on the sphere, equal areas staying equal.

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


def uv_to_direction(uv: ArrayLike) -> NDArray[np.float64]:
    """Directions of equirectangular image coordinates.

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
    """Direction of every pixel's sample in an equirectangular image.

    Parameters
    ----------
    height, width : int
        Size of the image, 2 or more.
    border_sampled : bool
        Whether the outer pixels lie on the seam and the poles (OpenEXR's `envmap` files).

    Returns
    -------
    ndarray, shape (height, width, 3)

    Examples
    --------
    >>> pixel_directions(2, 4)[0, 0].round(3)
    array([ 0.5  ,  0.707, -0.5  ])
    """
    size = count("height", height), count("width", width)
    return _native.pixel_directions(*size, border_sampled)


def pixel_solid_angles(
    height: int, width: int, *, border_sampled: bool = False
) -> NDArray[np.float64]:
    """Exact solid angle of every pixel in an equirectangular image.

    Parameters
    ----------
    height, width : int
        Size of the image, 2 or more.
    border_sampled : bool
        Whether the outer pixels lie on the seam and the poles (and are cut by them).

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
    return _native.pixel_solid_angles(*size, border_sampled)


def icosphere(faces: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Faces of a subdivided icosahedron: even normals for a probe, or sources of a scene.

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


def irradiance(
    radiance: NDArray[np.float32], normals: ArrayLike, *, border_sampled: bool = False
) -> NDArray[np.float64]:
    r"""Exact irradiance of an equirectangular map at `normals`.

    `EnvMap.probe` checks and cleans a map and then calls this.

    Parameters
    ----------
    radiance : ndarray of float32, shape (height, width, 3)
        Finite and not negative; read in place.
    normals : array_like, shape (n, 3)
        Unit vectors.
    border_sampled : bool
        Whether the outer pixels lie on the seam and the poles.

    Returns
    -------
    ndarray, shape (n, 3)
        :math:`E(n) = \int L(\omega) \max(0, n \cdot \omega)\, d\omega`.

    Examples
    --------
    >>> irradiance(np.ones((64, 128, 3), np.float32), [[0, 1, 0]]).round(4)
    array([[3.1416, 3.1416, 3.1416]])
    """
    return _native.irradiance(radiance, reals("normals", normals, 2), border_sampled)


def working_irradiance(
    radiance: NDArray[np.float32],
    normals: ArrayLike,
    *,
    border_sampled: bool = False,
    columns: int = WORKING_COLUMNS,
    source_share: float = 2e-3,
) -> tuple[NDArray[np.float64], int]:
    """Irradiance of a map at many normals, from a smaller working map.

    The map is averaged into at most `columns` columns; cells with more than `source_share` of the
    flux become point sources of exact direction. On 14 real maps the relative RMS difference from
    `irradiance` was 3e-5 to 1.4e-4 with 256 columns, and up to 4e-4 with 128.

    Parameters
    ----------
    radiance, normals, border_sampled
        As for `irradiance`.
    columns : int
        Width of the working map.
    source_share : float
        Share of the flux of any channel from which a cell is a source.

    Returns
    -------
    irradiance : ndarray, shape (n, 3)
    sources : int
        How many cells were taken as sources.

    Examples
    --------
    >>> working_irradiance(np.ones((64, 128, 3), np.float32), [[0, 1, 0]])[0].round(2)
    array([[3.14, 3.14, 3.14]])
    """
    normals = reals("normals", normals, 2)
    columns = count("columns", columns, least=2)
    return _native.working_irradiance(radiance, normals, border_sampled, columns, source_share)


def sum_over_sources(
    normals: ArrayLike,
    directions: ArrayLike,
    radiance: ArrayLike,
    solid_angles: ArrayLike,
    *,
    k_d: float = 1.0,
    C: Sequence[float] = (1.0, 1.0, 1.0),  # noqa: N803, the paper's name
) -> NDArray[np.float64]:
    r"""Probe values as a plain sum over K sources: equations 1 to 3 of Madsen et al. (2003).

    Parameters
    ----------
    normals : array_like, shape (n, 3)
        Unit vectors.
    directions : array_like, shape (K, 3)
        Unit vectors towards the sources.
    radiance : array_like, shape (K, 3)
        Of the sources.
    solid_angles : array_like, shape (K,)
        Of the sources; the paper's even sphere has ``4 pi / K``.
    k_d : float
        Diffuse coefficient of the probe: 1 gives irradiance, ``1 / pi`` the radiance of white.
    C : sequence of 3 floats
        Colour of the probe.

    Returns
    -------
    ndarray, shape (n, 3)
        :math:`\sum_j k_d C L_j \omega_j \max(0, n \cdot l_j)`.

    Examples
    --------
    >>> sum_over_sources([[0, 1, 0]], [[0, 1, 0]], [[1, 2, 3]], [0.5])
    array([[0.5, 1. , 1.5]])
    """
    vectors = reals("normals", normals, 2), reals("directions", directions, 2)
    sources = reals("radiance", radiance, 2), reals("solid_angles", solid_angles, 1)
    return _native.sum_over_sources(*vectors, *sources, float(k_d), [float(c) for c in C])


def rig_irradiance(
    normals: ArrayLike, ambient: ArrayLike, directions: ArrayLike, irradiance: ArrayLike
) -> NDArray[np.float64]:
    r"""Irradiance under ambient and directional lights: equations 4 to 6 of Madsen et al. (2003).

    Parameters
    ----------
    normals : array_like, shape (n, 3)
        Unit vectors.
    ambient : array_like, shape (3,)
        Radiance of the constant environment.
    directions : array_like, shape (m, 3)
        Unit vectors towards the lights.
    irradiance : array_like, shape (m, 3)
        Of each light at normal incidence.

    Returns
    -------
    ndarray, shape (n, 3)
        :math:`\pi L_a + \sum_j E_j \max(0, n \cdot l_j)`.

    Examples
    --------
    >>> rig_irradiance([[0, 1, 0]], [0, 0, 0], [[0, 1, 0]], [[1, 2, 3]])
    array([[1., 2., 3.]])
    """
    lights = reals("directions", directions, 2), reals("irradiance", irradiance, 2)
    radiance = reals("ambient", ambient, 1).tolist()
    return _native.rig_irradiance(reals("normals", normals, 2), radiance, *lights)


def relative_rms(seen: ArrayLike, wanted: ArrayLike, weights: ArrayLike) -> float:
    r"""Relative RMS difference of two probes over all channels.

    Parameters
    ----------
    seen, wanted : array_like, shape (n, 3)
        Irradiance at the same normals.
    weights : array_like, shape (n,)
        Solid angle of each normal.

    Returns
    -------
    float
        :math:`\|seen - wanted\| / \|wanted\|`; the numerator alone where `wanted` is black.

    Examples
    --------
    >>> round(relative_rms([[1.1, 1.1, 1.1]], [[1, 1, 1]], [1]), 12)
    0.1
    """
    probes = reals("seen", seen, 2), reals("wanted", wanted, 2)
    return _native.relative_rms(*probes, reals("weights", weights, 1))
