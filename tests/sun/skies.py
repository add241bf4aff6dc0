"""Clear skies by the formula of the CIE, with a sun in one pixel, over ground that it lights."""

import numpy as np

from envlights.kernels.image import LUMINANCE
from envlights.kernels.sphere import pixel_directions, pixel_solid_angles
from tests.reference import srgb

HEIGHT = 256

#: Gradation and indicatrix of the sky of the type 12 of ISO 15469, clear with low turbidity.
_A, _B, _C, _D, _E = -1.0, -0.32, 10.0, -3.0, 0.45

#: Colours of sky, sun and ground.
SKY, SUN, GROUND = np.array([0.7, 1.0, 1.5]), np.array([1.0, 0.95, 0.85]), np.array([1.0, 0.9, 0.8])


def towards(azimuth, elevation):
    """Unit vector at an azimuth and an elevation in degrees."""
    turn, lift = np.radians((azimuth, elevation))
    return np.array([np.sin(turn) * np.cos(lift), np.sin(lift), -np.cos(turn) * np.cos(lift)])


def nearest_pixel(direction, height=HEIGHT):
    """Row and column of the pixel at a direction, and its middle."""
    directions = pixel_directions(height, 2 * height)
    at = np.unravel_index((directions @ direction).argmax(), directions.shape[:2])
    return at, directions[at]


def cie_clear(sun, height=HEIGHT):
    """Luminance of the upper half of a clear sky over that at the zenith, (height, 2 height)."""
    directions = pixel_directions(height, 2 * height)

    def gradation(cosine):
        return 1 + _A * np.exp(_B / np.maximum(cosine, 0.01))

    def indicatrix(angle):
        return 1 + _C * (np.exp(_D * angle) - np.exp(_D * np.pi / 2)) + _E * np.cos(angle) ** 2

    angle = np.arccos(np.clip(directions @ sun, -1, 1))
    zenith = np.arccos(sun[1])
    value = gradation(directions[..., 1]) * indicatrix(angle)
    return np.where(directions[..., 1] > 0, value / (gradation(1.0) * indicatrix(zenith)), 0)


def sunny(sun, ratio=4.0, height=HEIGHT, stripes=True):
    """Map of a clear sky with a sun of `ratio` times its irradiance, and the sun's irradiance.

    The ground has an albedo of 0.2 and, with stripes, lies in the shade by a quarter.
    """
    at, sun = nearest_pixel(sun, height)
    directions = pixel_directions(height, 2 * height)
    solid_angles = pixel_solid_angles(height, 2 * height)
    radiance = cie_clear(sun, height)[..., None] * (SKY / (SKY @ LUMINANCE))
    up = np.maximum(directions[..., 1], 0) * solid_angles
    of_sky = (radiance * up[..., None]).sum(axis=(0, 1))
    flux = ratio * (of_sky @ LUMINANCE)
    colour = SUN / (SUN @ LUMINANCE)
    lit = 0.2 / np.pi * (of_sky + flux * sun[1] * colour) * GROUND
    shade = 0.2 / np.pi * of_sky * GROUND
    ground = np.where((np.arange(2 * height) // 7 % 4 == 0)[None, :, None] & stripes, shade, lit)
    radiance = np.where(directions[..., 1:2] > 0, radiance, ground)
    radiance[at] += flux * colour / solid_angles[at]
    return radiance, flux, sun


def expose(radiance, white_share):
    """Codes of a map with this fraction of the sphere at white, without its single pixels."""
    luminance = radiance @ LUMINANCE
    solid_angles = pixel_solid_angles(*luminance.shape)
    order = np.argsort(luminance, axis=None)
    below = np.cumsum(solid_angles.ravel()[order]) / (4 * np.pi)
    white = luminance.ravel()[order[np.searchsorted(below, 1 - white_share)]]
    return codes(radiance / white), float(white)


def codes(linear):
    """8-bit sRGB codes of linear values, clipped at 1."""
    return (255 * srgb.encode(np.clip(linear, 0, 1)) + 0.5).astype(np.uint8)
