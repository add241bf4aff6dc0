"""Colours of black bodies in linear Rec.709."""

from __future__ import annotations

from envlights.kernels.image import LUMINANCE

#: XYZ to linear Rec.709 (IEC 61966-2-1).
_TO_RGB = ((3.2406, -1.5372, -0.4986), (-0.9689, 1.8758, 0.0415), (0.0557, -0.2040, 1.0570))


def planck_gains(temperature: float, white: float = 6504.0) -> tuple[float, float, float]:
    """Gains for red, green and blue that change the white of a map to that of a black body.

    White keeps its luminance, and 6504 K, next to the D65 of Rec.709, changes nothing. The
    chromaticity is the rational formula of Krystek (1985), "An algorithm to calculate correlated
    colour temperature", from 1000 to 15000 K, which needs no exponential functions.
    """
    there, here = _colour(temperature), _colour(white)
    red, green, blue = (a / b for a, b in zip(there, here, strict=True))
    weights = LUMINANCE.tolist()
    luminance = weights[0] * red + weights[1] * green + weights[2] * blue
    return red / luminance, green / luminance, blue / luminance


def _colour(t: float) -> tuple[float, float, float]:
    """Linear Rec.709 colour with luminance 1."""
    u = (0.860117757 + 1.54118254e-4 * t + 1.28641212e-7 * t * t) / (
        1.0 + 8.42420235e-4 * t + 7.08145163e-7 * t * t
    )
    v = (0.317398726 + 4.22806245e-5 * t + 4.20481691e-8 * t * t) / (
        1.0 - 2.89741816e-5 * t + 1.61456053e-7 * t * t
    )
    # Convert the chromaticity u, v of CIE 1960 to XYZ with luminance 1.
    x, z = 1.5 * u / v, (2.0 - 0.5 * u - 5.0 * v) / v
    red, green, blue = (row[0] * x + row[1] + row[2] * z for row in _TO_RGB)
    return red, green, blue
