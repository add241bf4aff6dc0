"""A clear sky with its sun, over ground that lies partly in shadow."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import kernels
from envlights._common.check import amount, count, unit_vector
from envlights._native import EnvLightsError
from envlights.environment.envmap import EnvMap
from envlights.kernels.angles import SUN_RADIUS
from envlights.kernels.image import LUMINANCE
from envlights.kernels.sphere import direction_to_uv, pixel_directions, pixel_solid_angles
from envlights.rigs.lights import Lights
from envlights.sun.disc_pixels import add_disc
from envlights.synthetic.scene import MOST_ROWS, SyntheticMap

#: Parameters of the standard clear sky, type 12 of CIE S 011: gradation to the horizon, and glow of
#: the sun.
_A, _B, _C, _D, _E = -1.0, -0.32, 10.0, -3.0, 0.45
#: Colours of a luminance of about 1: of the blue sky, of its horizon, of the sun and of the ground.
_BLUE, _PALE, _SUN, _GROUND = (0.6, 0.95, 2.0), (1.0, 1.0, 1.0), (1.06, 1.0, 0.85), (1.1, 1.0, 0.8)
#: Reflectance of the ground.
_ALBEDO = 0.2


def clear_sky(
    height: int, sun: ArrayLike = (0.48, 0.6, 0.64), *, ratio: float = 4.0
) -> SyntheticMap:
    """A clear sky with its sun, over ground of albedo 0.2 with shadows on a third of it.

    Parameters
    ----------
    height : int
        Rows; the map is twice as wide.
    sun : array_like, shape (3,)
        Direction of the sun, above the horizon.
    ratio : float
        Irradiance of the sun at normal incidence over that of the sky on an upward surface, of
        luminance. It is 2 to 6 under clear skies.

    Returns
    -------
    SyntheticMap
        The irradiance of the sky on an upward surface has a luminance of 1. The sun is its light.

    Notes
    -----
    Luminance of the sky: standard clear sky, type 12 of CIE S 011 / ISO 15469 (2004). Colours are
    simple mixtures of blue and white.

    Examples
    --------
    >>> sky = clear_sky(128, ratio=3.0)
    >>> sky.lights.luminance.round(1), sky.lights.direction.round(2)
    (array([3.]), array([[0.48, 0.6 , 0.64]]))
    """
    rows = count("height", height, least=2, most=MOST_ROWS)
    towards = _direction(sun)
    strength = amount("ratio", ratio)
    background = _background(rows, towards, strength).astype(np.float32)
    is_there = strength > 0
    lights = Lights(
        towards[None][:is_there],
        strength * _colour(_SUN)[None][:is_there],
        np.array([SUN_RADIUS])[:is_there],
    )
    radiance = add_disc(EnvMap(background), lights) if is_there else background
    solid_angle = 2 * np.pi * (1 - np.cos(lights.angular_radius))
    (pixel,) = kernels.uv_to_pixel(direction_to_uv(towards[None]), rows, 2 * rows)
    with_background = lights.irradiance + solid_angle[:, None] * background[tuple(pixel)]
    return SyntheticMap(radiance, lights, solid_angle, with_background, "a clear sky")


def _background(height: int, towards: NDArray[np.float64], ratio: float) -> NDArray[np.float64]:
    """Sky and ground without the disc of the sun."""
    directions = pixel_directions(height, 2 * height)
    up = directions[..., 1]
    sky = np.where(up > 0, _luminance(directions, towards), 0)
    sky /= (sky * up * pixel_solid_angles(height, 2 * height)).sum()
    glow = np.exp(-4 * np.arccos(np.clip(directions @ towards, -1, 1)))
    blue = np.sqrt(np.clip(up, 0, 1)) * (1 - 0.7 * glow)
    colours = blue[..., None] * _colour(_BLUE) + (1 - blue[..., None]) * _colour(_PALE)
    lit = _colour(_BLUE) + ratio * towards[1] * _colour(_SUN)
    light = np.where(_is_in_shadow(directions)[..., None], _colour(_BLUE), lit)
    ground = _ALBEDO / math.pi * _colour(_GROUND) * light
    return np.where(up[..., None] > 0, sky[..., None] * colours, ground)


def _luminance(
    directions: NDArray[np.float64], towards: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Luminance of the standard sky, relative."""
    angle = np.arccos(np.clip(directions @ towards, -1, 1))
    gradation = 1 + _A * np.exp(_B / np.maximum(directions[..., 1], 1e-3))
    scattering = 1 + _C * (np.exp(_D * angle) - math.exp(_D * math.pi / 2))
    return np.asarray(gradation * (scattering + _E * np.cos(angle) ** 2))


def _is_in_shadow(directions: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Pattern of shadows on the plane below the viewer, of about a third of it."""
    x, y, z = np.moveaxis(directions, -1, 0)
    flat = np.maximum(-y, 0.02)
    wave = np.sin(2.1 * x / flat) + np.sin(2.7 * z / flat) + np.sin(1.3 * (x + z) / flat)
    return np.asarray((y < 0) & (wave > 0.55))


def _colour(channels: tuple[float, float, float]) -> NDArray[np.float64]:
    """Colour of luminance 1."""
    return np.array(channels) / float(np.array(channels) @ LUMINANCE)


def _direction(sun: ArrayLike) -> NDArray[np.float64]:
    """Unit vector above the horizon; raises an error for other directions."""
    unit = unit_vector("sun", sun)
    if unit[1] <= 0:
        raise EnvLightsError(f"sun must be above the horizon, with y > 0; got {unit.tolist()}")
    return unit
