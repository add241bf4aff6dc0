"""A ball and a box on a floor, rendered under a map or under a rig."""

from __future__ import annotations

from typing import Any

import numpy as np

from envlights.envmap import EnvMap
from envlights.rig import Rig
from envlights.scene.path_traced import Still, diffuse, render
from envlights.scene.renderer import mitsuba

#: Reflectance of all surfaces, and how often light bounces.
_REFLECTANCE, _BOUNCES = 0.7, 3
#: Columns and rows of an image.
_SIZE = (120, 80)
#: Elevation of the eye in degrees, its distance, and the height at which it looks.
_ELEVATION, _DISTANCE, _LOOKED_AT = 26.0, 4.6, 0.3


def still_life(
    light: EnvMap | Rig, azimuth: float, samples: int, seed: int, bounces: int = _BOUNCES
) -> Still:
    """Render the scene, seen from an azimuth in radians.

    `samples` are the paths through each pixel for each light, half of them for each of the two
    images; a map gets four times as many. One of `bounces` is the direct light alone.
    """
    with mitsuba() as mi:
        return render(mi, light, _shapes(mi, azimuth), samples, seed, bounces)


def _shapes(mi: Any, azimuth: float) -> dict[str, Any]:
    """A ball and a box on a floor that fills the image, and the sensor.

    They turn with the eye, so that they look the same from everywhere.
    """
    turned = mi.ScalarTransform4f().rotate([0, 1, 0], 180 - np.rad2deg(azimuth))
    place = mi.ScalarTransform4f()
    white = diffuse(np.full(3, _REFLECTANCE))
    up = np.deg2rad(_ELEVATION)
    eye = [0, _LOOKED_AT + _DISTANCE * np.sin(up), _DISTANCE * np.cos(up)]
    looked = place.look_at(eye, [0, _LOOKED_AT, 0], [0, 1, 0])
    film = {
        "type": "hdrfilm",
        "width": _SIZE[0],
        "height": _SIZE[1],
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
            "fov": 32,
            "to_world": turned @ looked,
            "film": film,
            "sampler": {"type": "multijitter"},
        },
    }
