"""The still life of `still_life.py` under a rig, in closed form: without a renderer and noise."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import kernels
from envlights._native import EnvLightsError
from envlights.occluders import Ball, Box, Stage
from envlights.rig import Rig
from envlights.scene.still_life import CAMERA, REFLECTANCE, SIZE

#: Samples along each side of a pixel.
_SAMPLES = 3


class _Rays(NamedTuple):
    """Rays from one eye."""

    eye: NDArray[np.float64]
    """Origin of all rays, (3,)."""

    towards: NDArray[np.float64]
    """Unit directions, (n, 3)."""


class _Hit(NamedTuple):
    """First point of each ray on a surface."""

    length: NDArray[np.float64]
    """Distance from the eye, (n,); infinite without a hit."""

    normal: NDArray[np.float64]
    """Unit normal, (n, 3)."""


def closed_still(rig: Rig, azimuth: float) -> NDArray[np.float64]:
    """Radiance of a ball and a box on a floor, seen from an azimuth in radians, (height, width, 3).

    Direct light and its shadows are exact. Light between surfaces is that of the model of
    `kernels.reflected_irradiance`. Lights below the horizon are behind the floor.
    """
    if rig.ambient.ndim == 2:
        raise EnvLightsError(
            "the closed form needs a rig with a constant ambient term; this one has harmonics,"
            " (9, 3); fit with ambient='constant', or render with Mitsuba"
        )
    lights = rig.lights[rig.lights.direction[:, 1] > 0]
    white = [REFLECTANCE] * 3
    stage = _stage(azimuth)
    irradiance = kernels.reflected_irradiance(
        stage,
        rig.ambient,
        lights.direction,
        lights.irradiance,
        lights.angular_radius,
        albedo=[white] * len(stage.solids),
        floor_albedo=white,
    )
    width, height = SIZE
    samples = irradiance.reshape(height, _SAMPLES, width, _SAMPLES, 3)
    return np.asarray(REFLECTANCE / np.pi * samples.mean(axis=(1, 3)))


def _stage(azimuth: float) -> Stage:
    """Solids, and the visible point of each sample of the image, row after row."""
    angle = np.pi - azimuth
    ball = Ball(_place([-0.65, 0.5, 0.1], angle), 0.5)
    box = Box(_place([0.65, 0.4, -0.1], angle), (0.4, 0.4, 0.4), angle + np.deg2rad(30))
    rays = _rays(angle)
    hits = _hit_floor(rays), _hit_ball(rays, ball), _hit_box(rays, box)
    lengths = np.array([hit.length for hit in hits])
    first = lengths.argmin(axis=0)
    each = np.arange(len(first))
    points = rays.eye + lengths[first, each, None] * rays.towards
    normals = np.array([hit.normal for hit in hits])[first, each]
    return Stage((ball, box), points, normals, first - 1)


def _about_y(vector: ArrayLike, angle: float) -> NDArray[np.float64]:
    """Rotate vectors, (..., 3), about +y, from +z to +x."""
    x, y, z = np.moveaxis(np.asarray(vector, np.float64), -1, 0)
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack([cos * x + sin * z, y, cos * z - sin * x], axis=-1)


def _place(centre: ArrayLike, angle: float) -> tuple[float, float, float]:
    """Centre of a solid that turns with the eye."""
    x, y, z = _about_y(centre, angle).tolist()
    return x, y, z


def _rays(angle: float) -> _Rays:
    """Rays through all samples of the image."""
    up = np.deg2rad(CAMERA.elevation)
    width, height = SIZE
    half = np.tan(np.deg2rad(CAMERA.fov) / 2)
    across = half * (2 * (np.arange(width * _SAMPLES) + 0.5) / (width * _SAMPLES) - 1)
    down = half * height / width * (2 * (np.arange(height * _SAMPLES) + 0.5))
    down = down / (height * _SAMPLES) - half * height / width
    x, y = np.meshgrid(across, -down)
    # The eye is on the side of +z, above the floor, and looks down.
    towards = np.stack(
        [x, y * np.cos(up) - np.sin(up), -y * np.sin(up) - np.cos(up)], axis=-1
    ).reshape(-1, 3)
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    distance = CAMERA.distance
    eye = [0.0, CAMERA.looked_at + distance * np.sin(up), distance * np.cos(up)]
    return _Rays(_about_y(eye, angle), _about_y(towards, angle))


def _hit_floor(rays: _Rays) -> _Hit:
    with np.errstate(divide="ignore"):
        length = -rays.eye[1] / rays.towards[:, 1]
    normal = np.broadcast_to([0.0, 1.0, 0.0], rays.towards.shape)
    return _Hit(np.where(length > 0, length, np.inf), normal)


def _hit_ball(rays: _Rays, ball: Ball) -> _Hit:
    away = np.array(ball.centre) - rays.eye
    along = rays.towards @ away
    within = ball.radius**2 - (away @ away - along**2)
    length = np.where(within > 0, along - np.sqrt(np.maximum(within, 0)), np.inf)
    points = np.where(within > 0, length, 0)[:, None] * rays.towards - away
    return _Hit(length, points / np.maximum(np.linalg.norm(points, axis=1), 1e-300)[:, None])


def _hit_box(rays: _Rays, box: Box) -> _Hit:
    """Entry into the last of the half-spaces of the faces, if it is before the first exit."""
    normals, distances = box.planes()
    slopes = rays.towards @ normals.T
    with np.errstate(divide="ignore"):
        lengths = (distances - normals @ rays.eye) / slopes
    entries = np.where(slopes < 0, lengths, -np.inf)
    exits = np.where(slopes > 0, lengths, np.inf).min(axis=1)
    face = entries.argmax(axis=1)
    entry = entries.max(axis=1)
    return _Hit(np.where((entry < exits) & (entry > 0), entry, np.inf), normals[face])
