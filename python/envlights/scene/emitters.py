"""A rig as emitters of Mitsuba."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights import kernels
from envlights.rig import Rig

#: Rows of the map for an ambient term of harmonics, which change slowly over the sphere.
_ROWS = 64
#: Rounding makes a black part of a sky negative by less than this share of the brightest part.
_ROUNDING = 1e-6


def emitters(mi: Any, rig: Rig) -> list[tuple[float, dict[str, Any]]]:
    """Sets of emitters with a weight each; the light of the rig is their weighted sum.

    No renderer has negative light. If the harmonics of the ambient term are negative somewhere, a
    second set holds that part with the weight -1, because light is linear.
    """
    lights = {f"light_{j}": light for j, light in enumerate(_directional(rig))}
    if rig.ambient.ndim == 1:
        return [(1.0, {**lights, "ambient": _constant(rig.ambient)})]
    radiance = _radiance(rig.ambient)
    added, taken = np.maximum(radiance, 0), np.maximum(-radiance, 0)
    sets = [(1.0, {**lights, "ambient": _map(mi, added)})]
    if taken.max() > _ROUNDING * added.max():
        sets.append((-1.0, {"ambient": _map(mi, taken)}))
    return sets


def _directional(rig: Rig) -> list[dict[str, Any]]:
    """Lights with Mitsuba's direction, the one in which light travels; ours is the opposite."""
    return [
        {"type": "directional", "direction": (-direction).tolist(), "irradiance": _rgb(irradiance)}
        for direction, irradiance in zip(rig.lights.direction, rig.lights.irradiance, strict=True)
    ]


def _constant(radiance: NDArray[np.float64]) -> dict[str, Any]:
    return {"type": "constant", "radiance": _rgb(radiance)}


def _map(mi: Any, radiance: NDArray[np.float64]) -> dict[str, Any]:
    return {"type": "envmap", "bitmap": mi.Bitmap(radiance.astype(np.float32))}


def _radiance(coefficients: NDArray[np.float64]) -> NDArray[np.float64]:
    """A map of the harmonics as Mitsuba reads it, with the first and last row on the poles."""
    u = (np.arange(2 * _ROWS) + 0.5) / (2 * _ROWS)
    v = np.arange(_ROWS) / (_ROWS - 1)
    uv = np.stack(np.meshgrid(u, v), axis=-1)
    seen = kernels.harmonic_radiance(kernels.uv_to_direction(uv.reshape(-1, 2))) @ coefficients
    return seen.reshape(*uv.shape[:2], 3)


def _rgb(values: NDArray[np.float64]) -> dict[str, Any]:
    return {"type": "rgb", "value": values.tolist()}
