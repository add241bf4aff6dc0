"""Reflection of a map by a rough surface."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native
from envlights._common.check import amount, float_image, reals


def rough_reflection(
    radiance: ArrayLike,
    normals: ArrayLike,
    views: ArrayLike,
    roughness: float,
    *,
    specular: float = 1.0,
) -> NDArray[np.float64]:
    r"""Radiance that a rough surface reflects towards a viewer, by a sum over all pixels.

    Parameters
    ----------
    radiance : array_like, shape (height, width, channels)
        Equirectangular map, cell-centred; finite and not negative. Maps of one size can be stacked
        along the channels, because they share the weights of the pixels.
    normals : array_like, shape (n, 3)
        Unit normals of the surface.
    views : array_like, shape (n, 3)
        Unit vectors from the surface towards the viewer.
    roughness : float
        From 0.1 to 1; its square is the width alpha of the distribution of microfacets.
    specular : float
        Reflectance of the microfacets at normal incidence, from 0 to 1. It rises to 1 at grazing
        incidence.

    Returns
    -------
    ndarray, shape (n, channels)
        :math:`\sum_p L_p \omega_p f(l_p, v)\, (n \cdot l_p)`, with the microfacets and the
        separable masking of Walter et al. (2007), equations 33 and 34, and the Fresnel term of
        Schlick (1994). It is 0 if the viewer is behind the surface.

    Raises
    ------
    EnvLightsError
        If an array has another shape, the map is not finite or is negative, a vector has another
        length than 1, or a number is out of range.

    Examples
    --------
    A white world seen in the roughest metal is 1 - ln 2 of white, because facets hide each other:

    >>> white = np.ones((64, 128, 3), np.float32)
    >>> rough_reflection(white, [[0, 1, 0]], [[0, 1, 0]], 1.0).round(2)
    array([[0.31, 0.31, 0.31]])
    """
    return _native.rough_reflection(
        float_image("radiance", radiance, 3),
        reals("normals", normals, 2),
        reals("views", views, 2),
        amount("roughness", roughness),
        amount("specular", specular),
    )
