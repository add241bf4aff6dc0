"""A ball and a box on a floor under a map or a rig: path-traced, and in closed form."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights._native import EnvLightsError
from envlights.environment.envmap import EnvMap
from envlights.kernels.solids import Ball, Box
from envlights.rigs.rig import Rig
from envlights.scene.camera import Camera
from envlights.scene.closed_form import closed_form
from envlights.scene.mitsuba.path_traced import SolidsOnFloor, Still, path_traced

#: Reflectance of all surfaces.
_REFLECTANCE = 0.7
#: Number of times that light bounces.
_BOUNCES = 3
#: Columns of an image for measurements; pictures have more. An image has two thirds as many rows.
_COLUMNS = 120
#: Elevation of the eye in degrees, its distance from the point at which it looks, the height of
#: that point, and the width of the image in degrees.
_ELEVATION, _DISTANCE, _LOOKED_AT, _FOV = 26.0, 4.6, 0.3, 32.0


def still_life(
    light: EnvMap | Rig,
    azimuth: float,
    samples: int,
    seed: int,
    bounces: int = _BOUNCES,
    width: int = _COLUMNS,
) -> Still:
    """Render the scene with Mitsuba, seen from an azimuth in radians; see `path_traced`."""
    return path_traced(
        light, still_scene(azimuth), still_camera(azimuth, width), samples, seed, bounces
    )


def closed_still(rig: Rig, azimuth: float, width: int = _COLUMNS) -> NDArray[np.float64]:
    """Radiance of the scene, seen from an azimuth in radians, without a renderer and noise.

    The shape is (2/3 width, width, 3). Direct light and its shadows are exact. Light between
    surfaces is that of the model of `kernels.reflected_irradiance`. Lights below the horizon are
    behind the floor.
    """
    if rig.ambient.ndim == 2:
        raise EnvLightsError(
            "the closed form needs a rig with a constant ambient term; this one has harmonics,"
            " (9, 3); fit with ambient='constant', or render with Mitsuba"
        )
    lights = rig.lights[rig.lights.direction[:, 1] > 0]
    above = Rig(rig.ambient, lights, rig.error, floor=True)
    return closed_form(above, still_scene(azimuth), still_camera(azimuth, width))


def still_scene(azimuth: float) -> SolidsOnFloor:
    """Solids that turn with the eye, so that they look the same from everywhere."""
    ball = Ball(_about_y(-0.65, 0.5, 0.1, azimuth), 0.5)
    turn = np.pi - azimuth + np.deg2rad(30)
    box = Box(_about_y(0.65, 0.4, -0.1, azimuth), (0.4, 0.4, 0.4), turn)
    return SolidsOnFloor((ball, box), np.full((2, 3), _REFLECTANCE), np.full(3, _REFLECTANCE))


def still_camera(azimuth: float, width: int = _COLUMNS) -> Camera:
    """Eye that looks down at the scene."""
    up = np.deg2rad(_ELEVATION)
    height = _LOOKED_AT + _DISTANCE * np.sin(up)
    eye = _about_y(0, height, _DISTANCE * np.cos(up), azimuth)
    return Camera(eye, (0.0, _LOOKED_AT, 0.0), _FOV, width, round(width * 2 / 3))


def _about_y(x: float, y: float, z: float, azimuth: float) -> tuple[float, float, float]:
    """Position after a turn that brings the eye from +z to an azimuth."""
    cos, sin = -float(np.cos(azimuth)), float(np.sin(azimuth))
    return cos * x + sin * z, y, cos * z - sin * x
