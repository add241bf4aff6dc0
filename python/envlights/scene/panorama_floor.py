"""Floor of a panorama: its reflectance, and its picture from another position."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights.environment.envmap import EnvMap
from envlights.kernels.probe import working_irradiance
from envlights.kernels.sphere import samples_at
from envlights.scene.camera import Ray
from envlights.scene.mitsuba.path_traced import Texture

#: Degrees below the horizon between which the floor is measured: further up stand things, further
#: down is the tripod.
_FLOOR_ELEVATIONS = (20.0, 80.0)
#: Bounds of a mean reflectance. A map whose floor is lit by light that the camera did not see gives
#: values above 1.
_LEAST_ALBEDO, _MOST_ALBEDO = 0.02, 0.8
#: Height of the camera of the panorama above its floor, and radius of the dome on which the map
#: lies beyond that floor, in metres.
CAMERA_HEIGHT, DOME_RADIUS = 1.6, 12.0


def floor_albedo(env: EnvMap) -> NDArray[np.float64]:
    """Mean reflectance of the floor of a map, (3,), clipped to 0.02 .. 0.8."""
    return measured_floor_albedo(env).clip(_LEAST_ALBEDO, _MOST_ALBEDO)


def measured_floor_albedo(env: EnvMap) -> NDArray[np.float64]:
    """Mean radiance of the floor of a map times pi, over the irradiance that it receives, (3,)."""
    elevations = 90 - (np.arange(env.height) + 0.5) * 180 / env.height
    near, far = _FLOOR_ELEVATIONS
    rows = (-elevations > near) & (-elevations < far)
    weights = np.cos(np.deg2rad(elevations[rows]))
    mean = weights @ env.radiance[rows].mean(axis=1, dtype=np.float64) / weights.sum()
    albedo: NDArray[np.float64] = np.pi * mean / floor_irradiance(env)
    return albedo


def floor_texture(
    env: EnvMap, pixels: int = 1024, half_width: float = 10.0, height: float = CAMERA_HEIGHT
) -> Texture:
    """Reflectance of the floor around the camera of a map, each channel at most 0.8."""
    along = half_width * (2 * (np.arange(pixels) + 0.5) / pixels - 1)
    x, z = np.meshgrid(along, along)
    seen = radiance_at(env, np.stack([x, np.full_like(x, -height), z], axis=-1).reshape(-1, 3))
    albedo = np.minimum(np.pi * seen / floor_irradiance(env), _MOST_ALBEDO)
    return Texture(albedo.reshape(pixels, pixels, 3), half_width)


def background(
    env: EnvMap, rays: Ray, height: float = CAMERA_HEIGHT, dome: float = DOME_RADIUS
) -> NDArray[np.float64]:
    """Radiance of the panorama along rays, (n, 3): a flat floor in a dome around the origin.

    Objects on the floor appear as if they were painted on it.
    """
    origin, directions = rays
    sinking = -directions[:, 1]
    distances = np.where(sinking > 0, origin[1] / np.maximum(sinking, 1e-300), np.inf)
    floor = origin + np.where(np.isfinite(distances), distances, 0)[:, None] * directions
    is_floor = np.isfinite(distances) & (np.hypot(floor[:, 0], floor[:, 2]) < dome)
    along = directions @ origin
    leave = np.sqrt(np.maximum(along**2 - origin @ origin + dome**2, 0)) - along
    points = np.where(is_floor[:, None], floor, origin + leave[:, None] * directions)
    return radiance_at(env, points - [0, height, 0])


def radiance_at(env: EnvMap, directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Radiance of a cell-centred map in directions of any length, (n, 3), by bilinear filtering."""
    lengths = np.linalg.norm(directions, axis=1, keepdims=True)
    return samples_at(env.radiance, directions / lengths)


def floor_irradiance(env: EnvMap) -> NDArray[np.float64]:
    """Irradiance of a floor under the upper half of a map, (3,), above 0."""
    upper = env.radiance.copy()
    upper[env.height // 2 :] = 0
    (received,), _ = working_irradiance(upper, [[0, 1, 0]], border_sampled=env.is_border_sampled)
    irradiance: NDArray[np.float64] = np.maximum(received, np.finfo(float).tiny)
    return irradiance
