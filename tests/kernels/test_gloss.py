"""Spectrum of a shiny ball against its definition, evaluated by sampling."""

import numpy as np
import pytest

import envlights as el
from envlights import kernels
from envlights.kernels.gloss import spectrum

PROBE = np.array([1, 2 / 3, 1 / 4, 0, -1 / 24])


def samples_of_lobe(roughness, incidence, count):
    """Directions that sample GGX about the normal +z, and weights of its lobe times the cosine."""
    u, v = kernels.hammersley(count).T + np.array([[0.5 / count], [0.0]])
    square = roughness**4
    cosine = np.sqrt((1 - u) / (1 + (square - 1) * u))
    half = np.stack([np.sin(2 * np.pi * v), np.cos(2 * np.pi * v)]) * np.sqrt(1 - cosine**2)
    half = np.concatenate([half, cosine[None]]).T
    view = np.array([np.sin(incidence), 0, np.cos(incidence)])
    towards = half @ view
    light = 2 * towards[:, None] * half - view

    def masking(c):
        return 2 * c / (c + np.sqrt(square + (1 - square) * c * c))

    lit = np.maximum(light[:, 2], 0)
    weights = masking(lit) * masking(view[2]) * np.maximum(towards, 0) / (view[2] * cosine)
    return light, weights * (lit > 0) / count


def by_definition(roughness, degree, nodes=10, count=1500):
    """Mean over the pixels of the lobe's product with itself under each Legendre polynomial."""
    at, shares = np.polynomial.legendre.leggauss(nodes)
    out = np.zeros(degree + 1)
    for u, share in zip((at + 1) / 2, shares / 2, strict=True):
        light, weights = samples_of_lobe(roughness, np.arcsin(np.sqrt(u)), count)
        cosines = np.clip(light @ light.T, -1, 1)
        values = np.polynomial.legendre.legvander(cosines.ravel(), degree)
        out += share * np.outer(weights, weights).ravel() @ values
    return out


@pytest.mark.parametrize("roughness", [0.3, 0.6])
def test_the_spectrum_is_the_product_of_the_lobe_with_itself(roughness):
    """The addition theorem turns the squared coefficients into products of all pairs of samples."""
    expected = by_definition(roughness, 8)
    np.testing.assert_allclose(spectrum(roughness, 8), expected, atol=0.01 * expected[0])


def test_a_white_base_has_the_spectrum_of_the_probe():
    none, half, whole = (spectrum(0.4, 4, "plastic", base=base) for base in (0, 0.5, 1))
    np.testing.assert_allclose(2 * (whole - 2 * half + none), PROBE**2, atol=2e-4)


@pytest.mark.parametrize(
    "bad",
    [{"roughness": 0.1}, {"roughness": 1.1}, {"degree": -1}, {"material": "wood"}, {"base": 2}],
)
def test_impossible_balls_are_refused(bad):
    with pytest.raises(el.EnvLightsError, match=next(iter(bad))):
        spectrum(**{"roughness": 0.5, "degree": 4, **bad})
