"""Azimuth and elevation of directions, as numbers and as text."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from envlights.kernels import sphere

#: Angular radius of the sun and of the moon, in radians.
SUN_RADIUS = math.radians(0.265)

#: Names for directions without an azimuth, whose elevations are printed as 90 and -90 degrees.
POLES = ("zenith", "nadir")


def place_of(direction: NDArray[np.float64]) -> str:
    """Azimuth and elevation of a direction, as text."""
    (azimuth,), (elevation,) = azimuths(direction[None]), elevations(direction[None])
    if round(abs(np.rad2deg(elevation))) == 90:
        return f"the {POLES[int(elevation < 0)]}"
    return f"azimuth {np.rad2deg(azimuth):.0f}°, elevation {np.rad2deg(elevation):.0f}°"


def angle_cells(direction: NDArray[np.float64]) -> tuple[str, str]:
    """Azimuth and elevation in degrees; at a pole, the name of the pole replaces the azimuth."""
    (azimuth,), (elevation,) = azimuths(direction[None]), elevations(direction[None])
    height = f"{np.rad2deg(elevation):+.1f}°"
    if height in ("+90.0°", "-90.0°"):
        return POLES[int(height[0] == "-")], height
    return f"{np.rad2deg(azimuth):.1f}°", height


def azimuths(direction: NDArray[np.float64]) -> NDArray[np.float64]:
    """Radians from -z over +x, increasing with map columns, from 0 to 2 pi, (n,)."""
    radians: NDArray[np.float64] = 2 * np.pi * sphere.direction_to_uv(direction)[:, 0]
    return radians


def elevations(direction: NDArray[np.float64]) -> NDArray[np.float64]:
    """Radians above the horizon, from -pi / 2 to pi / 2, (n,)."""
    radians: NDArray[np.float64] = np.pi * (0.5 - sphere.direction_to_uv(direction)[:, 1])
    return radians


def direction_at(azimuth: float, elevation: float) -> NDArray[np.float64]:
    """Unit vector at an azimuth and an elevation in radians, (3,)."""
    place = [azimuth / (2 * np.pi) % 1, 0.5 - elevation / np.pi]
    direction: NDArray[np.float64] = sphere.uv_to_direction([place])[0]
    return direction
