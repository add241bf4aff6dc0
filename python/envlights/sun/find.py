"""Search for the sun of a map."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import amount, named_arguments, unit_vector
from envlights._common.notes import warnings
from envlights._native import EnvLightsError
from envlights.environment.envmap import EnvMap
from envlights.environment.reading import AnyMap, as_envmap
from envlights.kernels.angles import SUN_RADIUS
from envlights.kernels.image import LUMINANCE
from envlights.kernels.sphere import pixel_directions, pixel_solid_angles
from envlights.sun.brightness import (
    INTERVAL,
    VEILED_INTERVAL,
    WIDE_INTERVAL,
    WIDE_VEILED_INTERVAL,
    sun_irradiance,
)
from envlights.sun.direction import SunPosition, fit_about, spot_position, sun_position
from envlights.sun.float_map import sun_of_float_map
from envlights.sun.parts import Part, best_part, part_at
from envlights.sun.plateau import plateau_of
from envlights.sun.questions import PERHAPS, SUN, points_of, veils_of
from envlights.sun.result import Sun
from envlights.sun.sky_image import SkyImage, sky_image
from envlights.sun.spots import single_spot

#: Angle in degrees around a sun within which all light belongs to the sun.
_NEAR = 3.0

#: Notes on the answers.
_SUN_OR_MOON = "sun or moon: a picture does not say which"
_NO_PART = "no clipped part above the horizon is like a sun"
_NO_GROUND = "too little unclipped ground: the irradiance is from the sky alone"
_MAY_BE_DIM = "cloud, haze or thick air may dim the sun to a small part of the estimate"
_UNSEEN = "parts of the sphere are not seen and count as black"


@named_arguments()
def find_sun(
    env: AnyMap, *, direction: ArrayLike | None = None, elevation: float | None = None
) -> Sun:
    """Find the sun of a map: its direction, its irradiance, and the certainty of the answer.

    The disc of the sun is smaller than most pixels, and an 8-bit picture is white for degrees
    around it. The clipped part, the symmetry of the sky and a fit of the sky give the direction,
    the ground and the sky the irradiance. Eight questions decide if it is a sun.

    Parameters
    ----------
    env : EnvMap, path or array_like, shape (height, 2 * height, 3)
        The map.
    direction : array_like, shape (3,), optional
        Known direction of the sun, of any length. The answer is then "sun", without questions.
    elevation : float, optional
        Known elevation of the sun in degrees, above 0. The picture then gives the azimuth.

    Returns
    -------
    Sun
        `answer` is "sun" with 7 or 8 points of 8, "perhaps" with 5 or 6, else "no". A sun of one
        pixel needs all 8 to be "sun". For a map that is not clipped, the sun is one of its detected
        lights, or the answer is "no".

    Raises
    ------
    EnvLightsError
        If `env` is not a map, both `direction` and `elevation` are given, the direction is zero or
        not finite, or the sun is not above the horizon.

    Notes
    -----
    ``docs/lab/sun.md`` has the questions, the accuracy on pictures of HDR maps, and the failures.
    `Sun.lights` is the disc as a light, and `Sun.sky` the radiance of the sky behind it.

    Examples
    --------
    >>> import envlights as el
    >>> sun = el.find_sun(np.full((64, 128, 3), 0.5), direction=[0, 3, 4])
    >>> sun.answer, sun.direction, sun.evidence
    ('sun', array([0. , 0.6, 0.8]), ('given',))
    """
    if direction is not None and elevation is not None:
        raise EnvLightsError("give direction or elevation, not both")
    given = None if direction is None else _direction(direction)
    height = None if elevation is None else _elevation(elevation)
    world = as_envmap(env)
    sun = _sun_of(world, height) if given is None else _given_sun(world, given)
    return replace(sun, notes=(*sun.notes, *warnings(world.notes)))


def _sun_of(world: EnvMap, height: float | None) -> Sun:
    """Sun of a map without a given direction."""
    if world.clip_level is None or not world.clipped_fraction:
        own = sun_of_float_map(world)
        # Floats made from a clipped picture do not contain the radiance of the sun.
        if own.answer != "no" or not world.clipped_fraction:
            return own
    radiance, clip_level = world.cells(), _level(world)
    image = sky_image(radiance, clip_level)
    spot = single_spot(image, radiance, clip_level) if height is None else None
    if spot is not None:
        return _answer(world, image, _Search(None, spot_position(image, spot)))
    part = best_part(image)
    if part is None:
        return Sun("no", notes=(_NO_PART,), units=world.units)
    return _answer(world, image, _Search(part, sun_position(image, part, height)))


class _Search(NamedTuple):
    """Clipped region that may hold the sun, and the estimated direction of the sun."""

    part: Part | None
    position: SunPosition


def _answer(world: EnvMap, image: SkyImage, found: _Search) -> Sun:
    """Sun of a clipped map, with the answer by the number of questions that it passes."""
    points = points_of(image, *found)
    count = sum(points.values())
    if count < PERHAPS:
        return Sun("no", points, notes=(f"{count} of {len(points)} points",), units=world.units)
    # A spot gets three of the points automatically, so it needs all of the others.
    answer = "sun" if count >= (SUN if found.part is not None else len(points)) else "perhaps"
    return _with_irradiance(world, image, found, answer, points)


def _given_sun(world: EnvMap, direction: NDArray[np.float64]) -> Sun:
    """Sun in a given direction."""
    clip_level = _level(world)
    if clip_level <= 0:
        raise EnvLightsError("the map is black, so the irradiance of its sun is not known")
    image = sky_image(world.cells(), clip_level)
    is_clipped = world._pixels.found_clip_level is not None
    part = part_at(image, direction) if is_clipped else None
    position = SunPosition(direction, 0.0, ("given",), fit_about(image, direction))
    return _with_irradiance(world, image, _Search(part, position), "sun", {})


def _with_irradiance(
    world: EnvMap,
    image: SkyImage,
    found: _Search,
    answer: str,
    points: dict[str, bool],
) -> Sun:
    """Sun with irradiance and clipped region filled in."""
    part, position = found
    clip_level = _level(world)
    relative, is_measured = sun_irradiance(image, float(position.direction[1]))
    notes = [] if "given" in position.evidence else [_SUN_OR_MOON]
    notes += [] if is_measured else [_NO_GROUND]
    notes += [] if world.coverage is None else [_UNSEEN]
    veils = veils_of(image, position) + [f"the answer is {answer!r}"] * (answer != "sun")
    notes += [f"{_MAY_BE_DIM} ({', '.join(veils)})"] if veils else []
    notes += _contradiction(world, position.direction, clip_level * relative)
    plateau = None
    if part is not None:
        # Without evidence from the sky, the fit is no better than the clip level.
        usable = position.fit is not None and "sky" in position.evidence
        fit = position.fit.fit if usable and position.fit is not None else None
        plateau = plateau_of(world.radiance, world.is_border_sampled, clip_level, part.mask, fit)
    return Sun(
        answer,
        points,
        position.direction,
        float(np.radians(position.uncertainty)),
        clip_level * relative,
        VEILED_INTERVAL if veils else INTERVAL,
        WIDE_VEILED_INTERVAL if veils else WIDE_INTERVAL,
        SUN_RADIUS,
        0.0 if part is None else float(np.radians(part.radius)),
        position.evidence,
        tuple(notes),
        plateau,
        units=world.units,
    )


def _level(world: EnvMap) -> float:
    """Clip level of the reduced image, or its largest sample."""
    return world._pixels.found_clip_level or float(world.radiance.max())


def _contradiction(
    world: EnvMap, direction: NDArray[np.float64], irradiance: NDArray[np.float64]
) -> list[str]:
    """Note if the estimate far exceeds the light in a map that is not clipped."""
    if world.clipped_fraction:
        return []
    cells = world.cells()
    near = pixel_directions(*cells.shape[:2]) @ direction > np.cos(np.radians(_NEAR))
    light = (cells @ LUMINANCE * pixel_solid_angles(*cells.shape[:2]))[near].sum()
    times = float(irradiance @ LUMINANCE) / max(float(light), 1e-12)
    if times * WIDE_INTERVAL[0] < 1:
        return []
    return [
        f"the estimate is {times:.3g} times the light within {_NEAR:g} degrees of the sun, which"
        " the map, because it is not clipped, shows; `split` takes that light"
    ]


def _direction(values: ArrayLike) -> NDArray[np.float64]:
    """Unit vector of a given direction; raises an error below the horizon."""
    unit = unit_vector("direction", values)
    if unit[1] <= 0:
        raise EnvLightsError(
            f"direction must be above the horizon, with y > 0; got {unit.tolist()}"
        )
    return unit


def _elevation(value: float) -> float:
    """Given elevation in degrees; raises an error for impossible values."""
    degrees = amount("elevation", value, 0.0, 90.0)
    if degrees == 0:
        raise EnvLightsError("elevation must be above 0 degrees, where the sun shines; got 0")
    return degrees
