"""The nine real spherical harmonics up to order 2, and the irradiance under each."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native
from envlights._common.check import reals


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
