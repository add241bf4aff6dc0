"""A ball and a box on a floor, rendered under a map or under a rig."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from envlights.environment.envmap import EnvMap
from envlights.rigs.rig import Rig
from envlights.scene.mitsuba.path_traced import Still, diffuse, render
from envlights.scene.mitsuba.renderer import mitsuba

#: Reflectance of all surfaces.
REFLECTANCE = 0.7
#: Number of times that light bounces.
_BOUNCES = 3
#: Columns and rows of an image for measurements; pictures have more.
SIZE = (120, 80)


class Camera(NamedTuple):
    """Eye that looks down at the scene."""

    elevation: float = 26.0
    """Elevation in degrees."""

    distance: float = 4.6
    """Distance from the point at which it looks."""

    looked_at: float = 0.3
    """Height of that point."""

    fov: float = 32.0
    """Width of the image in degrees."""


#: Camera of all images.
CAMERA = Camera()


def still_life(
    light: EnvMap | Rig,
    azimuth: float,
    samples: int,
    seed: int,
    bounces: int = _BOUNCES,
    width: int = SIZE[0],
) -> Still:
    """Render the scene, seen from an azimuth in radians.

    `samples` are the paths through each pixel for each light, half of them for each of the two
    images; a map gets four times as many. One of `bounces` is the direct light alone.
    """
    with mitsuba() as mi:
        return render(mi, light, _shapes(mi, azimuth, size_of(width)), samples, seed, bounces)


def size_of(width: int) -> tuple[int, int]:
    """Columns and rows of an image of that width."""
    return width, round(width * SIZE[1] / SIZE[0])


def _shapes(mi: Any, azimuth: float, size: tuple[int, int]) -> dict[str, Any]:
    """A ball and a box on a floor that fills the image, and the sensor.

    They turn with the eye, so that they look the same from everywhere.
    """
    turned = mi.ScalarTransform4f().rotate([0, 1, 0], 180 - np.rad2deg(azimuth))
    place = mi.ScalarTransform4f()
    white = diffuse(np.full(3, REFLECTANCE))
    up = np.deg2rad(CAMERA.elevation)
    distance = CAMERA.distance
    eye = [0, CAMERA.looked_at + distance * np.sin(up), distance * np.cos(up)]
    looked = place.look_at(eye, [0, CAMERA.looked_at, 0], [0, 1, 0])
    film = {
        "type": "hdrfilm",
        "width": size[0],
        "height": size[1],
        "pixel_format": "rgb",
        "rfilter": {"type": "box"},
    }
    box = place.translate([0.65, 0.4, -0.1]).rotate([0, 1, 0], 30).scale(0.4)
    ball = place.translate([-0.65, 0.5, 0.1]).scale(0.5)
    return {
        "floor": {
            "type": "rectangle",
            "to_world": place.scale(40).rotate([1, 0, 0], -90),
            "bsdf": white,
        },
        "ball": {"type": "sphere", "to_world": turned @ ball, "bsdf": white},
        "box": {"type": "cube", "to_world": turned @ box, "bsdf": white},
        "eye": {
            "type": "perspective",
            "fov": CAMERA.fov,
            "to_world": turned @ looked,
            "film": film,
            "sampler": {"type": "multijitter"},
        },
    }
