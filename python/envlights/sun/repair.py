"""Repair of a map by the disc of its sun."""

from __future__ import annotations

from typing import Any

import numpy as np

from envlights._native import EnvLightsError
from envlights.environment.envmap import EnvMap
from envlights.environment.fill import Fill
from envlights.kernels.sphere import direction_to_uv
from envlights.rigs.lights import Lights
from envlights.sun.choice import is_of_map, sun_of
from envlights.sun.disc_pixels import add_disc
from envlights.sun.sun_split import parts_of
from envlights.sun.wording import HOLDS_SUN


def repair_with_sun(
    env: EnvMap, sun: Any, irradiance: float | None, ratio: float | None, fill: Fill
) -> EnvMap:
    """Sky and disc of a sun in one map; without a sun, the repair without one.

    See `EnvMap.repaired`.
    """
    found = sun_of(env, sun)
    if is_of_map(found):
        noted = env.with_radiance(env.radiance, (*env.notes, HOLDS_SUN))
        return noted.repaired(irradiance=irradiance, ratio=ratio, fill=fill)
    lights, remainder = parts_of(env, found, irradiance, ratio, fill)
    if not len(lights):
        return remainder.repaired(irradiance=irradiance, ratio=ratio, fill=fill)
    _check_seen(remainder, lights)
    (note,) = lights.notes
    notes = (*env.notes, f"added as a disc: {note}")
    return remainder.with_radiance(add_disc(remainder, lights), notes)


def _check_seen(env: EnvMap, lights: Lights) -> None:
    """Refuse a sun in the unseen part, which stays black."""
    if env.coverage is None:
        return
    ((u, v),) = direction_to_uv(lights.direction)
    row = min(int(v * env.height), env.height - 1)
    if not np.asarray(env.coverage)[row, int(u * env.width) % env.width]:
        raise EnvLightsError(
            "sun must be in the part that the map shows, because the other part stays black;"
            " `with_sun` makes it a light"
        )
