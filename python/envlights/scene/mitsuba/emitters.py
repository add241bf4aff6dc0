"""Sets of Mitsuba emitters whose weighted sum is a rig."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights import kernels
from envlights._native import EnvLightsError
from envlights.environment.envmap import EnvMap
from envlights.export.formats.mitsuba import (
    add_weights,
    constant,
    directional,
    discs_on_poles,
    envmap,
    largest_irradiance,
    sharp_rows_on_poles,
)
from envlights.rigs.rig import Rig

#: Rows of the map for an ambient term of harmonics, which change slowly over the sphere.
_ROWS = 64
#: Bound on negative rounding errors of a black sky, relative to its brightest part.
_ROUNDING = 1e-6


def emitters(rig: Rig) -> list[tuple[float, dict[str, Any]]]:
    """Sets of emitters with a weight each; the light of the rig is their weighted sum.

    No renderer has negative light. If the harmonics of the ambient term are negative somewhere, a
    second set holds that part with the weight -1, because light is linear.
    """
    lights, discs = directional(rig.lights), discs_on_poles(rig.lights)
    if discs is None and rig.ambient.ndim == 1:
        around = largest_irradiance(None, rig.ambient)
        return [(1.0, add_weights({**lights, "ambient": constant(rig.ambient)}, around))]
    # A scene of Mitsuba has one environment: discs and ambient term share a map.
    discs = np.zeros((_ROWS, 2 * _ROWS, 3)) if discs is None else discs
    sky = _radiance(rig.ambient, *discs.shape[:2])
    added, taken = discs + np.maximum(sky, 0), np.maximum(-sky, 0)
    around = largest_irradiance(added, None)
    sets = [(1.0, add_weights({**lights, "ambient": envmap(added)}, around))]
    if taken.max() > _ROUNDING * added.max():
        sets.append((-1.0, {"ambient": envmap(taken)}))
    return sets


def environment(env: EnvMap) -> dict[str, Any]:
    """A map as an emitter; its cells are so fine that Mitsuba's interpolation hardly blurs it."""
    if env.registration != "cell-centred":
        raise EnvLightsError(f"the map must be cell-centred to be rendered; got {env.registration}")
    return envmap(sharp_rows_on_poles(env))


def _radiance(ambient: NDArray[np.float64], rows: int, columns: int) -> NDArray[np.float64]:
    """A map of an ambient term as Mitsuba reads it, with the first and last row on the poles."""
    if ambient.ndim == 1:
        return np.broadcast_to(ambient, (rows, columns, 3))
    u = (np.arange(columns) + 0.5) / columns
    v = np.arange(rows) / (rows - 1)
    uv = np.stack(np.meshgrid(u, v), axis=-1)
    seen = kernels.harmonic_radiance(kernels.uv_to_direction(uv.reshape(-1, 2))) @ ambient
    return seen.reshape(rows, columns, 3)
