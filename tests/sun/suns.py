"""Skies with a sun, for tests."""

import numpy as np

import envlights as el
from envlights import kernels
from envlights._common.srgb import encode_srgb

#: Unit vector towards the sun.
TOWARDS = np.array([0.48, 0.6, 0.64])
IRRADIANCE = np.array([40.0, 38.0, 34.0])


def sky(height=64, registration="cell-centred", **options):
    """A blue sky over brown ground, of 8 bits in floating point."""
    up = kernels.pixel_directions(
        height, 2 * height, border_sampled=registration == "border-sampled"
    )[..., 1:2]
    radiance = np.where(up > 0, [0.3, 0.4, 0.6], [0.2, 0.15, 0.1]) * (1 + 0.2 * up)
    return el.EnvMap(
        radiance.astype(np.float32), layout=el.io.Layout(registration=registration), **options
    )


def clipped(height=64, degrees=6.0):
    """The sky with a plateau at white around the sun, and the plateau."""
    env = sky(height)
    towards = kernels.pixel_directions(height, 2 * height)
    plateau = towards @ TOWARDS > np.cos(np.radians(degrees))
    radiance = np.where(plateau[..., None], np.float32(1), env.radiance)
    return el.EnvMap(radiance, clip_level=1.0), plateau


def sun_of(plateau=None, answer="sun", direction=TOWARDS, **options):
    """A sun by hand; sky of luminance 1.5 behind it."""
    behind = None if plateau is None else np.where(plateau, np.float32(1.5), np.float32(0))
    fields = {
        "direction_uncertainty": 0.02,
        "irradiance": IRRADIANCE,
        "interval": (0.5, 2.0),
        "wide_interval": (0.2, 4.0),
        "evidence": ("depth", "symmetry"),
        "plateau": behind,
    }
    return el.sun.Sun(answer, direction=direction, **(fields | options))


def photograph(radiance, white_share):
    """An 8-bit picture of a map, of whose sphere a share is white; and the luminance of white."""
    largest = radiance.max(axis=2)
    solid_angle = kernels.pixel_solid_angles(*largest.shape).ravel()
    order = np.argsort(-largest, axis=None)
    last = np.searchsorted(np.cumsum(solid_angle[order]), 4 * np.pi * white_share)
    white = float(largest.ravel()[order[last]])
    codes = np.round(255 * encode_srgb(np.minimum(radiance / white, 1)))
    return el.EnvMap(codes.astype(np.uint8)), white
