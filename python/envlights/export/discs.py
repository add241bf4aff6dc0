"""Discs drawn into the map, for targets whose lights have no size, or only small ones."""

from __future__ import annotations

from typing import Any

import numpy as np

from envlights.environment.envmap import EnvMap
from envlights.export.scene import Discs, Scene

#: Rows in the radius of the smallest disc, and limits on the rows of the map. With 64 rows,
#: Radiance loses 0.9 % of a disc of 46 degrees at its rim.
_DISC_ROWS, _LEAST_ROWS, MOST_ROWS = 8, 256, 1024


def split_by_size(lights: Discs, least: float) -> tuple[Discs, Discs]:
    """Discs with an angular radius below `least` in radians, and all others."""
    is_wide = lights.angular_radius >= least
    return lights[~is_wide], lights[is_wide]


def with_discs(scene: Scene, discs: Discs) -> Scene:
    """Scene with all lights removed, and `discs` drawn into its map."""
    others = scene._replace(lights=discs[:0])
    if not len(discs):
        return others
    rows = rows_for(discs)
    around: Any = scene.constant
    if scene.environment is not None:
        # Subdivide each pixel by a whole number.
        times = -(-rows // scene.environment.height)
        rows = times * scene.environment.height
        around = scene.environment.radiance.repeat(times, axis=0).repeat(times, axis=1)
    drawn = discs.to_map(rows).radiance + around
    return others._replace(ambient=None, environment=EnvMap(drawn.astype(np.float32)))


def rows_for(discs: Discs) -> int:
    """Number of map rows in which the smallest disc is still a disc."""
    rows = int(_DISC_ROWS * np.pi / discs.angular_radius.min())
    return min(max(rows, _LEAST_ROWS), MOST_ROWS)
