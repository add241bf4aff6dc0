"""Real spherical harmonics: nine up to degree 2 with irradiance, and maps to any degree."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native
from envlights._common.check import count, flag, float_image, reals

#: Highest degree of an expansion.
_MOST_DEGREES = 500


def harmonic_radiance(directions: ArrayLike) -> NDArray[np.float64]:
    """Values of the nine real spherical harmonics up to order 2.

    Parameters
    ----------
    directions : array_like, shape (n, 3)
        Unit vectors.

    Returns
    -------
    ndarray, shape (n, 9)
        In the order and with the signs of Ramamoorthi and Hanrahan (2001), equation 3: multiples of
        1, y, z, x, xy, yz, 3z² - 1, xz, x² - y². Their product with the coefficients of an ambient
        term, (9, 3), is its radiance.

    Raises
    ------
    EnvLightsError
        If `directions` has another shape or holds a vector of another length than 1.

    See Also
    --------
    harmonic_irradiance : the irradiance under each.

    Examples
    --------
    >>> harmonic_radiance([[0, 1, 0]]).round(3)[0] + 0.0
    array([ 0.282,  0.489,  0.   ,  0.   ,  0.   ,  0.   , -0.315,  0.   ,
           -0.546])
    """
    return _native.harmonic_radiance(reals("directions", directions, 2))


def harmonic_irradiance(normals: ArrayLike) -> NDArray[np.float64]:
    r"""Irradiance under each of the nine real spherical harmonics up to order 2.

    Parameters
    ----------
    normals : array_like, shape (n, 3)
        Unit vectors.

    Returns
    -------
    ndarray, shape (n, 9)
        The values of `harmonic_radiance` times :math:`\pi`, :math:`2 \pi / 3` and
        :math:`\pi / 4` for order 0, 1 and 2 (Ramamoorthi and Hanrahan 2001, equation 8). Their
        product with the coefficients of an ambient term, (9, 3), is the irradiance under it, as in
        `rig_irradiance`.

    Raises
    ------
    EnvLightsError
        If `normals` has another shape or holds a vector of another length than 1.

    See Also
    --------
    harmonic_radiance : the harmonics themselves.

    Examples
    --------
    >>> harmonic_irradiance([[0, 1, 0]]).round(3)[0] + 0.0
    array([ 0.886,  1.023,  0.   ,  0.   ,  0.   ,  0.   , -0.248,  0.   ,
           -0.429])
    """
    return _native.harmonic_irradiance(reals("normals", normals, 2))


def expand_map(
    radiance: ArrayLike, degree: int, *, border_sampled: bool = False
) -> NDArray[np.float64]:
    r"""Coefficients of a map in orthonormal real spherical harmonics around +y.

    Parameters
    ----------
    radiance : array_like, shape (height, width, 3)
        Radiance of cells, over which the harmonics are integrated.
    degree : int
        Highest degree, 0 to 500.
    border_sampled : bool
        True: the outer pixels lie on the seam and the poles.

    Returns
    -------
    ndarray, shape (degree + 1, degree + 1, 6)
        By order m and degree l: RGB for :math:`P_{lm}(\cos\theta) \cos(m \phi)`, then RGB for
        :math:`P_{lm}(\cos\theta) \sin(m \phi)`. :math:`\theta` is the angle to +y, and
        :math:`\phi` the azimuth from -z over +x. 0 where l < m.

    Raises
    ------
    EnvLightsError
        If the shape is wrong or `degree` is out of range.

    Examples
    --------
    >>> expand_map(np.ones((8, 16, 3)), 1)[0, 0, 0].round(3)
    np.float64(3.545)
    """
    image = float_image("radiance", radiance, 3)
    degree = count("degree", degree, most=_MOST_DEGREES)
    return _native.expand_map(image, degree, flag("border_sampled", border_sampled))


def expand_discs(
    directions: ArrayLike, irradiance: ArrayLike, angular_radius: ArrayLike, degree: int
) -> NDArray[np.float64]:
    """Coefficients of the sum of discs of uniform radiance, in closed form.

    Parameters
    ----------
    directions : array_like, shape (n, 3)
        Unit vectors to the centres.
    irradiance : array_like, shape (n, 3)
        RGB irradiance of each at normal incidence.
    angular_radius : array_like, shape (n,)
        Radians, 0 to pi / 2; 0 is a point.
    degree : int
        Highest degree, 0 to 500.

    Returns
    -------
    ndarray, shape (degree + 1, degree + 1, 6)
        As from `expand_map`.

    Raises
    ------
    EnvLightsError
        If a shape, a length, a radius or `degree` is out of range.

    Examples
    --------
    >>> expand_discs([[0, 1, 0]], [[1, 2, 3]], [0.0], 1)[0, :, 0].round(3)
    array([0.282, 0.489])
    """
    discs = reals("directions", directions, 2), reals("irradiance", irradiance, 2)
    radii = reals("angular_radius", angular_radius, 1)
    return _native.expand_discs(*discs, radii, count("degree", degree, most=_MOST_DEGREES))
