"""A rig as emitters of Mitsuba."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights import kernels
from envlights._native import EnvLightsError
from envlights.envmap import EnvMap
from envlights.lights import Lights
from envlights.rig import Rig

#: Rows of the map for an ambient term of harmonics, which change slowly over the sphere.
_ROWS = 64
#: Rows of a map for discs: as many as give the smallest a radius of so many, within limits.
_DISC_ROWS, _LEAST_DISC_ROWS, _MOST_DISC_ROWS = 8, 256, 1024
#: Rounding makes a black part of a sky negative by less than this share of the brightest part.
_ROUNDING = 1e-6


def emitters(mi: Any, rig: Rig) -> list[tuple[float, dict[str, Any]]]:
    """Sets of emitters with a weight each; the light of the rig is their weighted sum.

    No renderer has negative light. If the harmonics of the ambient term are negative somewhere, a
    second set holds that part with the weight -1, because light is linear.
    """
    is_point = rig.lights.angular_radius == 0
    points = _directional(_some(rig.lights, is_point))
    lights = {f"light_{j}": light for j, light in enumerate(points)}
    if is_point.all() and rig.ambient.ndim == 1:
        return [(1.0, {**lights, "ambient": _constant(rig.ambient)})]
    # A scene of Mitsuba has one environment: discs and ambient term share a map.
    discs = _discs(_some(rig.lights, ~is_point))
    sky = _radiance(rig.ambient, *discs.shape[:2])
    added, taken = discs + np.maximum(sky, 0), np.maximum(-sky, 0)
    sets = [(1.0, {**lights, "ambient": _map(mi, added)})]
    if taken.max() > _ROUNDING * added.max():
        sets.append((-1.0, {"ambient": _map(mi, taken)}))
    return sets


def environment(mi: Any, env: EnvMap) -> dict[str, Any]:
    """A map as an emitter; its cells are so fine that Mitsuba's interpolation hardly blurs it."""
    if env.registration != "cell-centred":
        raise EnvLightsError(f"the map must be cell-centred to be rendered; got {env.registration}")
    times = -(-_MOST_DISC_ROWS // env.height)
    return _map(mi, _between_rows(env.radiance.repeat(times, axis=0).repeat(times, axis=1)))


def _some(lights: Lights, which: NDArray[np.bool_]) -> Lights:
    arrays = lights.direction, lights.irradiance, lights.angular_radius
    return Lights(*(array[which] for array in arrays))


def _directional(lights: Lights) -> list[dict[str, Any]]:
    """Lights with Mitsuba's direction, the one in which light travels; ours is the opposite."""
    return [
        {"type": "directional", "direction": (-direction).tolist(), "irradiance": _rgb(irradiance)}
        for direction, irradiance in zip(lights.direction, lights.irradiance, strict=True)
    ]


def _discs(lights: Lights) -> NDArray[np.float64]:
    """A map of the lights with a size as Mitsuba reads it, (rows + 1, 2 * rows, 3).

    Of what Mitsuba has for a disc at infinity, a map is the most accurate. A far sphere as an area
    light has the same noise, but it was off by 0.4 % at a radius of 0.27 degrees and by half at
    89.5, and it hides the lights behind it.
    """
    if not len(lights):
        return np.zeros((_ROWS, 2 * _ROWS, 3))
    rows = int(_DISC_ROWS * np.pi / lights.angular_radius.min())
    cells = lights.to_map(min(max(rows, _LEAST_DISC_ROWS), _MOST_DISC_ROWS)).radiance
    return _between_rows(cells)


def _between_rows(cells: NDArray[np.float32]) -> NDArray[np.float64]:
    """A map of cells as Mitsuba reads it: its rows lie on the edges of ours, two on the poles."""
    edges = np.concatenate([cells[:1], cells, cells[-1:]]).astype(np.float64)
    return (edges[1:] + edges[:-1]) / 2


def _constant(radiance: NDArray[np.float64]) -> dict[str, Any]:
    return {"type": "constant", "radiance": _rgb(radiance)}


def _map(mi: Any, radiance: NDArray[np.float64]) -> dict[str, Any]:
    return {"type": "envmap", "bitmap": mi.Bitmap(radiance.astype(np.float32))}


def _radiance(ambient: NDArray[np.float64], rows: int, columns: int) -> NDArray[np.float64]:
    """A map of an ambient term as Mitsuba reads it, with the first and last row on the poles."""
    if ambient.ndim == 1:
        return np.broadcast_to(ambient, (rows, columns, 3))
    u = (np.arange(columns) + 0.5) / columns
    v = np.arange(rows) / (rows - 1)
    uv = np.stack(np.meshgrid(u, v), axis=-1)
    seen = kernels.harmonic_radiance(kernels.uv_to_direction(uv.reshape(-1, 2))) @ ambient
    return seen.reshape(rows, columns, 3)


def _rgb(values: NDArray[np.float64]) -> dict[str, Any]:
    return {"type": "rgb", "value": values.tolist()}
