"""Images of solids on a floor under a rig, in closed form; only camera rays are traced."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from envlights import kernels
from envlights.kernels.solids import Stage
from envlights.rigs.rig import Rig
from envlights.scene.camera import NOTHING, Camera, Sight, first_surfaces
from envlights.scene.mitsuba.path_traced import SolidsOnFloor

#: Function that computes the irradiance of visible surfaces under a rig, (n, 3).
Shading = Callable[[Rig, SolidsOnFloor, Sight], NDArray[np.float64]]


def shade(rig: Rig, scene: SolidsOnFloor, sight: Sight) -> NDArray[np.float64]:
    """Irradiance with shadows and the light that floor and solids reflect, (n, 3)."""
    lights = rig.lights
    return kernels.reflected_irradiance(
        Stage(scene.solids, *sight),
        rig.ambient,
        lights.direction,
        lights.irradiance,
        lights.angular_radius,
        albedo=scene.albedo,
        floor_albedo=scene.floor_albedo,
        floor=rig.floor,
    )


def shade_directly(rig: Rig, scene: SolidsOnFloor, sight: Sight) -> NDArray[np.float64]:
    """Irradiance with shadows of lights and ambient term, but no reflected light, (n, 3)."""
    lights = rig.lights
    hidden = _hidden_fractions(rig, scene, sight, lights.angular_radius)
    strengths = np.concatenate([[np.pi * rig.ambient], lights.irradiance])
    received: NDArray[np.float64] = rig.probe(sight.normals) - hidden @ strengths
    return received.clip(0)


def shade_with_hard_shadows(rig: Rig, scene: SolidsOnFloor, sight: Sight) -> NDArray[np.float64]:
    """Irradiance with shadows of lights as points, but not of the ambient term, (n, 3)."""
    lights = rig.lights
    hidden = _hidden_fractions(rig, scene, sight, np.zeros(len(lights)))[:, 1:]
    received: NDArray[np.float64] = rig.probe(sight.normals) - hidden @ lights.irradiance
    return received.clip(0)


def shade_without_shadows(rig: Rig, scene: SolidsOnFloor, sight: Sight) -> NDArray[np.float64]:
    """Irradiance without shadows, (n, 3)."""
    return rig.probe(sight.normals)


def _hidden_fractions(
    rig: Rig, scene: SolidsOnFloor, sight: Sight, radii: NDArray[np.float64]
) -> NDArray[np.float64]:
    stage = Stage(scene.solids, *sight)
    return kernels.hidden_fractions(stage, rig.lights.direction, radii, floor=rig.floor)


def closed_form(
    rig: Rig,
    scene: SolidsOnFloor,
    camera: Camera,
    per_side: int = 3,
    shading: Shading = shade,
) -> NDArray[np.float64]:
    """Mean radiance over a grid of points per pixel, (height, width, 3); the sky is black."""
    sight = first_surfaces(camera.rays(per_side), scene.solids)
    hits = np.flatnonzero(sight.own != NOTHING)
    lit = Sight(sight.points[hits], sight.normals[hits], sight.own[hits])
    radiance = np.zeros_like(sight.points)
    radiance[hits] = scene.albedo_at(lit.points, lit.own) / np.pi * shading(rig, scene, lit)
    return camera.pixels(radiance, per_side)
