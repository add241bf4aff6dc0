"""Solids in a panorama, with their shadows on its floor, in closed form and path-traced."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights.environment.envmap import EnvMap
from envlights.rigs.rig import Rig
from envlights.scene.camera import FLOOR, NOTHING, Camera, Sight, first_surfaces
from envlights.scene.closed_form import Shading, shade
from envlights.scene.mitsuba.path_traced import SolidsOnFloor, Still, path_traced
from envlights.scene.panorama_floor import DOME_RADIUS, background, radiance_at

#: Points of a pixel along each side.
_PER_SIDE = 3


class _Image(NamedTuple):
    """Image in closed form; a pixel is the mean of its rays."""

    view: NDArray[np.float64]
    """Radiance in front of the panorama, (height, width, 3)."""

    uniform: NDArray[np.float64]
    """Radiance with a floor of the mean reflectance, (height, width, 3)."""

    panorama: NDArray[np.float64]
    """Radiance of the panorama alone, (height, width, 3)."""

    floor: NDArray[np.float64]
    """Fraction of the rays that meet the floor within the dome, (height, width, 1)."""

    away: NDArray[np.float64]
    """Fraction of the rays that hit the panorama beyond the floor, (height, width, 1)."""


def view_image(
    env: EnvMap,
    rig: Rig,
    scene: SolidsOnFloor,
    camera: Camera,
    per_side: int = _PER_SIDE,
    shading: Shading = shade,
) -> NDArray[np.float64]:
    """Radiance of solids in a panorama under a rig, in closed form, (height, width, 3)."""
    return _image(env, rig, scene, camera, per_side, shading).view


def true_view(
    env: EnvMap, rig: Rig, scene: SolidsOnFloor, camera: Camera, samples: int = 64, seed: int = 0
) -> Still:
    """Radiance of solids in a panorama, path-traced under the map itself.

    The renderer sees a floor of the mean reflectance under the whole map. The picture of the floor
    is multiplied by the ratio to that floor without solids. The rig is used in one place alone: in
    pixels at outlines, where it tells the floor from the solids.
    """
    image = _image(env, rig, scene, camera, _PER_SIDE, shade)
    bare = scene.floor_albedo / np.pi * env.probe([[0.0, 1.0, 0.0]])[0]
    halves = path_traced(env, scene, camera, samples, seed)
    return Still(*(_before_panorama(half, image, bare) for half in halves))


def _before_panorama(
    traced: NDArray[np.float64], image: _Image, bare: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Replace the uniform floor of a path-traced image by the panorama."""
    ratio = traced / np.maximum(bare, np.finfo(float).tiny)
    outlines = traced + image.view - image.uniform
    covered = np.where(image.floor == 1, image.panorama * ratio, outlines)
    radiance: NDArray[np.float64] = np.where(image.away == 1, image.panorama, covered)
    return radiance


def _image(
    env: EnvMap, rig: Rig, scene: SolidsOnFloor, camera: Camera, per_side: int, shading: Shading
) -> _Image:
    rays = camera.rays(per_side)
    sight = first_surfaces(rays, scene.solids)
    panorama = background(env, rays)
    distant = np.hypot(sight.points[:, 0], sight.points[:, 2]) >= DOME_RADIUS
    floor = (sight.own == FLOOR) & ~distant
    away = (sight.own == NOTHING) | ((sight.own == FLOOR) & distant)
    received = np.zeros_like(sight.points)
    lit = np.flatnonzero(sight.own != NOTHING)
    received[lit] = shading(
        rig, scene, Sight(sight.points[lit], sight.normals[lit], sight.own[lit])
    )
    uniform = scene.albedo_at(sight.points, np.maximum(sight.own, FLOOR)) / np.pi * received
    uniform[sight.own == NOTHING] = radiance_at(env, rays.directions[sight.own == NOTHING])
    ratio = received / np.maximum(rig.probe([[0.0, 1.0, 0.0]])[0], np.finfo(float).tiny)
    view = np.where(floor[:, None], ratio * panorama, uniform)
    view = np.where(away[:, None], panorama, view)
    parts = view, uniform, panorama, floor[:, None], away[:, None]
    return _Image(*(camera.pixels(part.astype(np.float64), per_side) for part in parts))
