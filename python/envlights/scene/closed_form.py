"""Images of solids on a floor under a rig, in closed form: no rays but those of the camera."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights.rig import Rig
from envlights.scene.camera import NOTHING, Camera, Sight, first_surfaces
from envlights.scene.path_traced import SolidsOnFloor


class Stage(NamedTuple):
    """Points of surfaces among solids, as the compiled kernel reads them."""

    solids: list[Any]
    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    own: NDArray[np.int64]


class Lighting(NamedTuple):
    """A rig and the reflectances of a scene, as the compiled kernel reads them."""

    directions: NDArray[np.float64]
    radii: NDArray[np.float64]
    irradiance: NDArray[np.float64]
    ambient: NDArray[np.float64]
    albedo: NDArray[np.float64]
    floor_albedo: NDArray[np.float64]
    floor: bool


#: Irradiance of surfaces under a rig, (n, 3).
Shading = Callable[[Rig, SolidsOnFloor, Sight], NDArray[np.float64]]


def shade(rig: Rig, scene: SolidsOnFloor, sight: Sight) -> NDArray[np.float64]:
    """Irradiance with shadows and the light that floor and solids reflect, (n, 3)."""
    lights = rig.lights
    lighting = Lighting(
        lights.direction,
        lights.angular_radius,
        lights.irradiance,
        rig.ambient,
        scene.albedo,
        scene.floor_albedo,
        rig.floor,
    )
    return _native.reflected_irradiance(Stage(scene.solids, *sight), lighting)


def shade_directly(rig: Rig, scene: SolidsOnFloor, sight: Sight) -> NDArray[np.float64]:
    """Irradiance with shadows of lights and ambient term, without reflected light, (n, 3)."""
    lights = rig.lights
    stage = Stage(scene.solids, *sight)
    hidden = _native.hidden_shares(stage, lights.direction, lights.angular_radius, rig.floor)
    strengths = np.concatenate([[np.pi * rig.ambient], lights.irradiance])
    return rig.probe(sight.normals) - hidden @ strengths


def shade_with_hard_shadows(rig: Rig, scene: SolidsOnFloor, sight: Sight) -> NDArray[np.float64]:
    """Irradiance with shadows of lights as points, and none of the ambient term, (n, 3)."""
    lights = rig.lights
    stage, points = Stage(scene.solids, *sight), np.zeros(len(lights))
    hidden = _native.hidden_shares(stage, lights.direction, points, rig.floor)[:, 1:]
    return np.maximum(rig.probe(sight.normals) - hidden @ lights.irradiance, 0)


def closed_form(
    rig: Rig,
    scene: SolidsOnFloor,
    camera: Camera,
    per_side: int = 3,
    shading: Shading = shade,
) -> NDArray[np.float64]:
    """Radiance of each pixel, (height, width, 3), the mean of a grid of points; sky is black."""
    sight = first_surfaces(camera.rays(per_side), scene.solids)
    hits = np.flatnonzero(sight.own != NOTHING)
    lit = Sight(sight.points[hits], sight.normals[hits], sight.own[hits])
    radiance = np.zeros_like(sight.points)
    radiance[hits] = scene.albedo_at(lit.points, lit.own) / np.pi * shading(rig, scene, lit)
    return camera.pixels(radiance, per_side)
