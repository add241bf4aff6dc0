r"""Irradiance of the sun, estimated from the brightness of the ground and of the sky.

With the horizontal irradiance E of the map without its sun, the mean unclipped luminance L of the
ground, and the sine s of the sun's elevation,

    G = max( (pi L / 0.2 - E) / s,  0.1 E ),    F = 2.8 sqrt(G E)

G is what a ground of albedo 0.2 says, and a clear sun has some 6 times the irradiance of its sky.
Both are poor, and their errors are independent; the geometric mean has the smaller one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights.kernels.image import LUMINANCE
from envlights.sun.sky_image import SkyImage

#: Factor of the estimate: median over the sunny maps of `benchmarks/sun.py`.
FACTOR = 2.8
#: Factor of an estimate by the sky only, if all of the ground is clipped or hidden.
_SKY_FACTOR = 6.0
#: Assumed albedo of the ground, and smallest ratio of irradiance by ground to irradiance by sky.
_ALBEDO, _LEAST_GROUND = 0.2, 0.1
#: Angle in degrees below the horizon at which ground begins; also the lowest elevation in the
#: estimate.
_GROUND = 3.0
#: Smallest unclipped fraction of the ground for an estimate.
_LEAST_UNCLIPPED = 0.1

#: Factors of the estimate that bound the true irradiance for two of three suns, and for nine of
#: ten: the range of seven maps with a clear sun, and that of a normal logarithm.
INTERVAL, WIDE_INTERVAL = (0.5, 2.1), (0.3, 2.4)
#: The same if cloud, haze or thick air may dim the sun: the range of twelve maps, and half of its
#: lower end. A sunset or a sun behind a cloud has up to 80 times less light than the estimate.
VEILED_INTERVAL, WIDE_VEILED_INTERVAL = (0.012, 2.1), (0.006, 2.4)

#: Colour of the sun above the air, and how much less, or more, of it than of green each unit of air
#: mass takes away: extinction by molecules (Rayleigh) and a standard aerosol in the three channels.
#: Within 15 % of the spectral model of Hosek and Wilkie (2013) for the turbidity 3, from 3 to 60
#: degrees.
_ABOVE_AIR, _DEPTH = np.array([1.105, 1.0, 0.951]), np.array([-0.064, 0.0, 0.175])


def sun_colour(sine: float) -> NDArray[np.float64]:
    """Colour of a sun in a clear sky, with luminance 1; `sine` is that of its elevation.

    The air mass is that of Kasten and Young (1989).
    """
    degrees = float(np.degrees(np.arcsin(np.clip(sine, 0, 1))))
    air_mass = 1 / (sine + 0.50572 * (degrees + 6.07995) ** -1.6364)
    colour = _ABOVE_AIR * np.exp(-_DEPTH * air_mass)
    return np.asarray(colour / (colour @ LUMINANCE))


def sun_irradiance(image: SkyImage, sine: float) -> tuple[NDArray[np.float64], bool]:
    """RGB irradiance relative to the clip level, and True if the ground was used.

    `sine` is that of the sun's elevation.
    """
    weight = image.solid_angles
    up = np.maximum(image.directions[..., 1], 0)
    sky = float((image.luminance * weight * up).sum())
    low = np.broadcast_to(image.elevation < -_GROUND, weight.shape)
    ground = low & ~image.is_touched
    colour = sun_colour(sine)
    if (weight * ground).sum() < _LEAST_UNCLIPPED * (weight * low).sum():
        return _SKY_FACTOR * sky * colour, False
    luminance = float(np.average(image.luminance[ground], weights=weight[ground]))
    height = max(sine, np.sin(np.radians(_GROUND)))
    by_ground = max((np.pi * luminance / _ALBEDO - sky) / height, _LEAST_GROUND * sky)
    return FACTOR * np.sqrt(by_ground * sky) * colour, True
