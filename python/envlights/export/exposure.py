"""Exposure of programs whose pixels end at 1: robot simulators."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import amount
from envlights.environment.reading import AnyMap
from envlights.export.scene import Discs, Exportable, Scene, at_most, mean_radiance, scene_of
from envlights.export.targets import target_named
from envlights.kernels.sampling import icosphere

#: Normals at which the brightest white surface is searched.
_NORMALS = 5120


def with_exposure(
    target: str, rig: Exportable, environment: AnyMap | None, scale: float | None
) -> tuple[Scene, float]:
    """Brightest lights and a constant, for a target without maps, and the scale of its pixels."""
    scene = scene_of(rig, environment, target=target)
    constant = scene._replace(ambient=mean_radiance(scene), environment=None)
    scene = at_most(constant, target_named(target).shows.lights)
    if scale is not None:
        return scene, amount("scale", scale)
    return scene, _largest_scale(scene.lights, np.pi * scene.constant)


def _largest_scale(lights: Discs, ambient: NDArray[np.float64]) -> float:
    """Scale at which the brightest channel of the brightest white surface is 1."""
    towards = lights.direction
    normals = np.concatenate([towards, icosphere(_NORMALS)[0]])
    lit = np.maximum(normals @ towards.T, 0) @ lights.irradiance + ambient
    return float(1 / (lit.max() or 1.0))
