"""Sun of an unclipped map: the brightest detected light, if the surrounding sky agrees."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights.detection.detect import detect
from envlights.detection.lights import DetectedLights
from envlights.environment.envmap import EnvMap
from envlights.kernels.angles import SUN_RADIUS
from envlights.kernels.image import LUMINANCE
from envlights.sun.direction import spot_position
from envlights.sun.questions import PERHAPS, SUN, points_of
from envlights.sun.result import Sun
from envlights.sun.sky_image import sky_image

#: Largest radius of a blurred sun, in degrees, and smallest ratio of its irradiance to that of the
#: sky.
_WIDEST, _LEAST_RATIO = 2.5, 0.5
#: Largest radius of a disc of solar size with its blur, in degrees and in pixels, and smallest
#: fraction of all light for it to dominate. Suns among clouds have a fraction of 0.5 and 6 to 7
#: points; lamps in dark rooms and squares get 4 points.
_SUN_SIZE, _SUN_PIXELS, _DOMINANT = 1.1, 1.5, 0.4
#: Clipped fraction of the upper half of the map from which the sky is examined.
_CLIPPED = 0.004

#: Note on a map that already contains its sun.
_OWN_SUN = "the map is not clipped and holds its own sun"
_OWN_LAMP = "the map holds a light of the size of the sun, but its surroundings are not like a sky"
NO_SUN = "no pixel is clipped, and no light of the map is like a sun"


def sun_of_float_map(env: EnvMap) -> Sun:
    """Sun of a map without clipped pixels: one of its lights, or none."""
    lights = detect(env, max_lights=4)
    if not _is_compact(env, lights):
        return Sun("no", notes=(NO_SUN,), units=env.units)
    points = _points(env, lights.direction[0])
    count = sum(points.values())
    # A disc of solar size with half of the light does not need a clear sky.
    is_dominant = _is_dominant(env, lights)
    if count < SUN and not is_dominant:
        return Sun("no", points, notes=(NO_SUN,), units=env.units)
    is_sun = count >= (PERHAPS if is_dominant else SUN)
    return Sun(
        "sun" if is_sun else "perhaps",
        points,
        lights.direction[0],
        0.5 * np.pi / env.height,
        lights.irradiance[0],
        angular_radius=SUN_RADIUS,
        evidence=("map",),
        notes=(_OWN_SUN if is_sun else _OWN_LAMP,),
        units=env.units,
    )


def _is_compact(env: EnvMap, lights: DetectedLights) -> bool:
    """True if the first light is small, above the horizon, and much brighter than the rest."""
    if not len(lights) or lights.direction[0, 1] <= 0:
        return False
    if lights.angular_radius[0] > np.radians(_WIDEST):
        return False
    first, *others = lights.irradiance @ LUMINANCE
    sky = float(env.probe([[0.0, 1.0, 0.0]], fill="black")[0] @ LUMINANCE)
    sky -= first * lights.direction[0, 1]
    return bool(first > _LEAST_RATIO * max(sky, 0) and first > 2 * max(others, default=0.0))


def _is_dominant(env: EnvMap, lights: DetectedLights) -> bool:
    """True if the first light has the size of the sun and a large fraction of all light."""
    radius = np.degrees(lights.angular_radius[0])
    is_small = radius <= max(_SUN_SIZE, _SUN_PIXELS * 180 / env.height)
    return bool(is_small and lights.flux_fraction[0] > _DOMINANT)


def _points(env: EnvMap, direction: NDArray[np.float64]) -> dict[str, bool]:
    """Answers on the sky around a light, for the map clipped as a picture would be."""
    radiance = env.cells()
    luminance = _native.luminance(radiance)
    upper = luminance[: len(luminance) // 2]
    weight = np.sin((np.arange(len(upper)) + 0.5) / len(luminance) * np.pi)
    order = np.argsort(upper, axis=None, kind="stable")
    above = np.cumsum(np.repeat(weight, upper.shape[1])[order])
    at = np.searchsorted(above, (1 - _CLIPPED) * above[-1])
    clip_level = float(upper.ravel()[order[min(at, len(order) - 1)]])
    if clip_level <= 0:
        return {}
    image = sky_image(np.minimum(radiance, np.float32(clip_level)), clip_level)
    return points_of(image, None, spot_position(image, direction))
