"""Conversion of an argument `sun` to a `Sun`: found in the map, by direction, or as given."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import describe
from envlights._native import EnvLightsError
from envlights.environment.envmap import EnvMap
from envlights.kernels.angles import elevations, place_of
from envlights.sun.almanac import SunAt
from envlights.sun.find import find_sun
from envlights.sun.result import Sun

#: Name that requests a search by `find_sun`.
AUTO = "auto"
#: Cosine of the largest angle, 5 degrees, at which a given direction matches the sun of a map.
_SAME = math.cos(math.radians(5))
#: Accepted types of the argument `sun` in public functions.
AnySun = str | ArrayLike | SunAt | Sun


def sun_of(env: EnvMap, sun: AnySun) -> Sun:
    """Sun of a map for an argument; raises an error if the argument fits no sun."""
    if isinstance(sun, Sun):
        return _of_map(env, sun)
    if isinstance(sun, SunAt):
        if sun.elevation <= 0:
            raise _below_horizon(sun.elevation)
        if sun.direction is None:
            return find_sun(env, elevation=math.degrees(sun.elevation))
        return _towards(env, sun.direction)
    if isinstance(sun, str) and sun == AUTO:
        return find_sun(env)
    return _towards(env, _direction(sun))


def is_of_map(sun: Sun) -> bool:
    """True if the map shows the sun with its true radiance."""
    return sun.answer == "sun" and "map" in sun.evidence


def _towards(env: EnvMap, direction: NDArray[np.float64]) -> Sun:
    """Sun in a given direction; the map's own sun if it matches."""
    if env.clip_level is None:
        own = find_sun(env)
        if "map" in own.evidence and own.direction is not None:
            if own.direction @ direction < _SAME:
                raise EnvLightsError(
                    f"sun must be the one that the map holds, {own.in_short()}; got"
                    f" {place_of(direction)}; `split` removes it"
                )
            return replace(own, answer="sun")
    return find_sun(env, direction=direction)


def _of_map(env: EnvMap, sun: Sun) -> Sun:
    """The given `Sun`; raises an error if it cannot belong to the map."""
    if sun.direction is not None and (sun.elevation or 0) <= 0:
        raise _below_horizon(sun.elevation or 0)
    if sun.units != env.units:
        raise EnvLightsError(
            f"sun must have the units of the map, {env.units!r}; got {sun.units!r}; find it in the"
            " calibrated map"
        )
    if sun.plateau is not None and sun.plateau.shape != env.radiance.shape[:2]:
        raise EnvLightsError(
            f"sun must be that of this map, of {env.radiance.shape[:2]} pixels; its plateau has"
            f" {sun.plateau.shape}"
        )
    return sun


def _direction(sun: Any) -> NDArray[np.float64]:
    """Unit vector above the horizon; raises an error for other directions."""
    try:
        vector = np.asarray(sun)
    except ValueError:
        vector = np.zeros(0)
    length = 0.0
    if vector.shape == (3,) and vector.dtype.kind in "fiu":
        length = float(np.linalg.norm(vector.astype(np.float64)))
    if not (length > 0 and math.isfinite(length)):
        raise EnvLightsError(
            "sun must be 'auto', a direction of three finite numbers that are not all 0, a SunAt or"
            f" a Sun; got {describe(vector.tolist() if vector.shape == (3,) else sun)}"
        )
    direction = vector.astype(np.float64) / length
    if direction[1] <= 0:
        raise _below_horizon(float(elevations(direction[None])[0]))
    return direction


def _below_horizon(elevation: float) -> EnvLightsError:
    degrees = math.degrees(elevation)
    return EnvLightsError(f"sun must be above the horizon; got an elevation of {degrees:.3g}°")
