"""Spectrum of a glossy ball, averaged over all views."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._common.check import amount, check_choice, count
from envlights._native import EnvLightsError

#: Smallest roughness for which the quadrature is accurate.
LEAST_ROUGHNESS = 0.2
#: Materials of the ball.
MATERIALS = ("metal", "plastic")
#: Smallest roughness of a surface for which a fit reports the error.
LEAST_FITTED_ROUGHNESS = 0.3
#: Highest degree; the lobe of the smoothest surface is 0 beyond it.
_MOST_DEGREES = 500


def spectrum(
    roughness: float, degree: int, material: str = "metal", *, base: float = 0.5
) -> NDArray[np.float64]:
    r"""Mean squared pixel of a glossy ball over all views, by degree of its surroundings.

    With the coefficients :math:`L_{lm}` of the radiance in orthonormal spherical harmonics, the
    mean over all views and all pixels of the ball's image is

    .. math:: \langle I^2 \rangle = \frac{1}{4 \pi} \sum_l \lambda_l \sum_m L_{lm}^2, \qquad
       \lambda_l = \frac{4 \pi}{2 l + 1} \int_0^1 \sum_m |b_{lm}|^2 \, d \sin^2 i

    where :math:`b_{lm}` are the coefficients of the reflectance distribution times the cosine, at
    the incidence i. A mirror has :math:`\lambda_l = 1`, white Lambertian paint the squares of 1,
    2/3, 1/4, 0, -1/24, ... It holds for any lobe; none is made symmetric.

    Parameters
    ----------
    roughness : float
        Roughness of the metal or of the coat, from 0.2 to 1; its square is the alpha of GGX.
    degree : int
        Highest degree, 0 to 500.
    material : {"metal", "plastic"}
        "metal": microfacets that reflect everything. "plastic": a Lambertian base under a coat that
        reflects 0.04 at normal incidence and more at grazing incidence (Schlick 1994).
    base : float
        Reflectance of the base of "plastic", from 0 to 1. The coat takes nothing from it.

    Returns
    -------
    ndarray, shape (degree + 1,)
        :math:`\lambda_0` to :math:`\lambda_{degree}`, within 1 % of :math:`\lambda_0` of sampling.

    Raises
    ------
    EnvLightsError
        If an argument is out of range or `material` is unknown.

    References
    ----------
    B. Walter, S. R. Marschner, H. Li, K. E. Torrance: "Microfacet Models for Refraction through
    Rough Surfaces", EGSR 2007; GGX with its separable masking, equations 33 and 34.
    C. Schlick: "An Inexpensive BRDF Model for Physically-based Rendering", Eurographics 1994.

    Examples
    --------
    Rough metal blurs: the fourth degree keeps an eighth of the power of the mean.

    >>> factors = spectrum(0.5, 4)
    >>> (factors / factors[0]).round(2)
    array([1.  , 0.7 , 0.4 , 0.22, 0.12])
    """
    check_choice("material", material, MATERIALS)
    roughness = amount("roughness", roughness, LEAST_ROUGHNESS, 1.0)
    degree, base = count("degree", degree, most=_MOST_DEGREES), amount("base", base, most=1.0)
    return _native.gloss_spectrum(roughness, degree, base if material == "plastic" else None)


def checked_roughness(roughness: object) -> float:
    """`roughness` of a glossy object whose error a fit can report; raises an error otherwise."""
    value = amount("roughness", roughness, most=1.0)
    if value < LEAST_FITTED_ROUGHNESS:
        raise EnvLightsError(
            f"roughness must be from {LEAST_FITTED_ROUGHNESS:g} to 1; got {value:g}, and smoother"
            " surfaces show finer patterns of the map than a fit resolves"
        )
    return value


@lru_cache(maxsize=64)
def factors(roughness: float, material: str, degree: int) -> NDArray[np.float64]:
    """Read-only result of `spectrum`, cached, because it takes a few hundredths of a second."""
    out = spectrum(roughness, degree, material)
    out.flags.writeable = False
    return out


def error(
    bands: Sequence[Sequence[float]], roughness: float, material: str = "metal"
) -> float | None:
    """Relative RMS error, by the energies of a map and a difference per degree; None if empty."""
    check_choice("material", material, MATERIALS)
    energies, differences = bands
    if not len(energies):
        return None
    by_degree = factors(roughness, material, len(energies) - 1)
    whole, difference = float(by_degree @ energies), float(by_degree @ differences)
    return float(np.sqrt(difference / whole)) if whole > 0 else float(np.sqrt(difference))
