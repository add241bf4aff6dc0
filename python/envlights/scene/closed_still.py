"""The still life of `still_life.py` under a rig, in closed form: without a renderer and noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights._native import EnvLightsError
from envlights.kernels.solids import Ball, Box
from envlights.rigs.rig import Rig
from envlights.scene.camera import Camera
from envlights.scene.closed_form import closed_form
from envlights.scene.mitsuba.path_traced import SolidsOnFloor
from envlights.scene.mitsuba.still_life import CAMERA, REFLECTANCE, SIZE, size_of


def closed_still(rig: Rig, azimuth: float, width: int = SIZE[0]) -> NDArray[np.float64]:
    """Radiance of a ball and a box on a floor, seen from an azimuth in radians, as an image.

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
    return closed_form(
        Rig(rig.ambient, lights, rig.error, floor=True), _scene(azimuth), _camera(azimuth, width)
    )


def _scene(azimuth: float) -> SolidsOnFloor:
    """Solids that turn with the eye."""
    ball = Ball(_place(-0.65, 0.5, 0.1, azimuth), 0.5)
    turn = np.pi - azimuth + np.deg2rad(30)
    box = Box(_place(0.65, 0.4, -0.1, azimuth), (0.4, 0.4, 0.4), turn)
    return SolidsOnFloor((ball, box), np.full((2, 3), REFLECTANCE), np.full(3, REFLECTANCE))


def _camera(azimuth: float, width: int) -> Camera:
    up, distance = np.deg2rad(CAMERA.elevation), CAMERA.distance
    height = CAMERA.looked_at + distance * np.sin(up)
    eye = _place(0, height, distance * np.cos(up), azimuth)
    return Camera(eye, (0.0, CAMERA.looked_at, 0.0), CAMERA.fov, *size_of(width))


def _place(x: float, y: float, z: float, azimuth: float) -> tuple[float, float, float]:
    """Position after a turn that brings the eye from +z to an azimuth."""
    cos, sin = -float(np.cos(azimuth)), float(np.sin(azimuth))
    return cos * x + sin * z, y, cos * z - sin * x
