r"""Spectra of spheres: mean squared images over all views, as factors per degree.

A sphere under the radiance L has the mean squared pixel
:math:`\sum_l \lambda_l \sum_m L_{lm}^2 / 4 \pi`, for a mean over all sides.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._native import EnvLightsError
from envlights.comparison.harmonics import DEGREE, FINE_DEGREE
from envlights.comparison.protocol import Material
from envlights.kernels.gloss import spectrum

#: Reflectance of the coating at normal incidence, for a refractive index of 1.5.
_COAT = 0.04


@lru_cache(maxsize=16)
def of_material(material: Material) -> NDArray[np.float64] | None:
    """Factors per degree; None for a mirror, whose factors all equal `specular` squared."""
    if not material.specular:
        return material.base**2 * lambertian()
    if not material.roughness:
        return None
    if not material.base:
        # For a metal, the Fresnel term is its constant reflectance, without the increase at the
        # rim.
        return material.specular**2 * of_metal(material.roughness)
    if material.specular != _COAT:
        raise EnvLightsError(
            "a material with a base and a coat has exact means only for specular=0.04;"
            f" got {material.specular:g}; give the protocol a camera"
        )
    return spectrum(material.roughness, DEGREE, material="plastic", base=material.base)


@lru_cache(maxsize=16)
def of_metal(roughness: float) -> NDArray[np.float64]:
    """Factors of a rough metal with reflectance 1."""
    return spectrum(roughness, DEGREE, material="metal")


@lru_cache(maxsize=1)
def lambertian() -> NDArray[np.float64]:
    """Factors of a white Lambertian sphere: squared coefficients of the clamped cosine over pi.

    Ramamoorthi and Hanrahan (2001), equation 8.
    """
    return _native.kernel_spectra(DEGREE)[0] / np.pi**2


@lru_cache(maxsize=1)
def shadows() -> NDArray[np.float64]:
    """Factors of irradiance with part of the light blocked, over all blocking planes.

    Kernel at the angle g: ``2/3 (sin g + (pi - g) cos g) (1 - g/pi) / 2``. High degrees see its
    slope at 0, -1/3, which is that of -1/3 of the chord, ``2 sin(g/2)``.
    """
    twice = 2 * np.arange(DEGREE + 1.0, FINE_DEGREE + 1)
    cone = 16 * np.pi / 3 / ((twice - 1) * (twice + 1) * (twice + 3))
    return np.concatenate([_native.kernel_spectra(DEGREE)[1], cone])
