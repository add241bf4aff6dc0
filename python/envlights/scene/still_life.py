"""A ball and a box on a floor, rendered under a map or under a rig."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights.envmap import EnvMap
from envlights.rig import Rig
from envlights.scene.emitters import emitters, environment
from envlights.scene.renderer import mitsuba

#: Reflectance of all surfaces.
REFLECTANCE = 0.7
#: Number of times that light bounces.
_BOUNCES = 3
#: Columns and rows of an image.
SIZE = (120, 80)
#: Paths under a map for each under a light: a map has more noise than a light alone.
_MAP_PATHS = 4


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


class Still(NamedTuple):
    """An image, twice, with independent noise."""

    one: NDArray[np.float64]
    """Radiance, (height, width, 3)."""

    two: NDArray[np.float64]
    """Radiance from independent paths, (height, width, 3)."""

    def error(self, truth: Still) -> float:
        """Relative RMS difference from `truth`, without the noise of either.

        Noise cancels on average in the product of two differences from independent paths.
        """
        difference = float(((self.one - truth.one) * (self.two - truth.two)).sum())
        size = float((truth.one * truth.two).sum())
        return float(np.sqrt(max(difference, 0.0) / size)) if size > 0 else 0.0

    @property
    def image(self) -> NDArray[np.float64]:
        """The mean of both."""
        return (self.one + self.two) / 2

    @property
    def noise(self) -> float:
        """Relative standard error of the mean: the norm of the noise over that of the image."""
        size = np.linalg.norm(self.image)
        return float(np.linalg.norm(self.one - self.two) / 2 / size) if size else 0.0


def still_life(
    light: EnvMap | Rig, azimuth: float, samples: int, seed: int, bounces: int = _BOUNCES
) -> Still:
    """Render the scene, seen from an azimuth in radians.

    Lights and ambient term are rendered one at a time and added, because Mitsuba picks one emitter
    at random for each path, and that pick is most of the noise of many emitters. `samples` are the
    paths through each pixel for each light, half of them for each of the two images. One of
    `bounces` is the direct light alone.
    """
    seeds = iter(np.random.SeedSequence(seed).generate_state(2 * (2 + _lights(light))))
    images = np.zeros((2, SIZE[1], SIZE[0], 3))
    with mitsuba() as mi:
        shapes = _shapes(mi, azimuth)
        paths = mi.load_dict({"type": "path", "max_depth": 1 + bounces})
        for weight, lit, effort in _parts(light):
            scene = mi.load_dict({"type": "scene", **shapes, **lit}, optimize=False)
            for image in images:
                spp, own = effort * -(-samples // 2), int(next(seeds))
                image += weight * np.array(mi.render(scene, integrator=paths, spp=spp, seed=own))
    return Still(*images)


def _lights(light: EnvMap | Rig) -> int:
    return len(light.lights) if isinstance(light, Rig) else 0


def _parts(light: EnvMap | Rig) -> list[tuple[float, dict[str, Any], int]]:
    """Weight, emitters and effort of each render."""
    if isinstance(light, EnvMap):
        return [(1.0, {"map": environment(light)}, _MAP_PATHS)]
    dark, lights = np.zeros(3), light.lights
    rigs = [Rig(dark, lights[j : j + 1], 0.0) for j in range(len(lights))]
    rigs.append(Rig(light.ambient, lights[:0], 0.0))
    return [(weight, lit, 1) for rig in rigs for weight, lit in emitters(rig)]


def _shapes(mi: Any, azimuth: float) -> dict[str, Any]:
    """A ball and a box on a floor that fills the image, and the sensor.

    They turn with the eye, so that they look the same from everywhere.
    """
    turned = mi.ScalarTransform4f().rotate([0, 1, 0], 180 - np.rad2deg(azimuth))
    place = mi.ScalarTransform4f()
    white = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [REFLECTANCE] * 3}}
    up = np.deg2rad(CAMERA.elevation)
    distance = CAMERA.distance
    eye = [0, CAMERA.looked_at + distance * np.sin(up), distance * np.cos(up)]
    looked = place.look_at(eye, [0, CAMERA.looked_at, 0], [0, 1, 0])
    film = {
        "type": "hdrfilm",
        "width": SIZE[0],
        "height": SIZE[1],
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
