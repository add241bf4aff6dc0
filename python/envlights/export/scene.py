"""The parts of a rig that every exporter writes: lights, and a constant or a map around them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._blocks import in_blocks
from envlights._check import shown
from envlights._native import EnvLightsError
from envlights.ambient import ambient_rows
from envlights.envmap import EnvMap, as_envmap
from envlights.lights import Lights
from envlights.rig import Rig

#: Rows of the map for an ambient term that is not constant; it changes slowly over the sphere.
ROWS = 128


class Scene(NamedTuple):
    """What a target is told, in our frame and units."""

    lights: Lights
    """Discs and points, brightest first; irradiance at normal incidence."""

    ambient: NDArray[np.float64] | None
    """Radiance of a constant environment, (3,); None where there is none, or a map."""

    environment: EnvMap | None
    """A map in place of the constant, its pixels cell-centred."""


def scene_of(given: Rig | Lights, environment: EnvMap | ArrayLike | None = None) -> Scene:
    """The parts of a rig, or of lights alone.

    Parameters
    ----------
    given : Rig or Lights
        Detected lights become discs of the same flux and solid angle.
    environment : EnvMap or array_like, optional
        Stands in place of the ambient term.

    Returns
    -------
    Scene
        Harmonics, and the upper half of an ambient term over a floor, become a small map.
    """
    lights = check_rig(given).discs()
    if environment is not None:
        given_map = as_envmap(environment)
        is_cells = given_map.registration == "cell-centred"
        return Scene(lights, None, given_map if is_cells else EnvMap(given_map.cells()))
    ambient, floor = getattr(given, "ambient", np.zeros(3)), getattr(given, "floor", False)
    if not np.any(ambient):
        return Scene(lights, None, None)
    if ambient.ndim == 2 or floor:
        rows = ambient_rows(ambient, ROWS, floor)
        return Scene(lights, None, EnvMap(in_blocks((ROWS, 2 * ROWS, 3), rows)))
    return Scene(lights, ambient, None)


def check_rig(given: Rig | Lights) -> Lights:
    """The lights of a rig, or lights themselves; a refusal of anything else."""
    lights: Any = getattr(given, "lights", given)
    if not hasattr(lights, "discs"):
        raise EnvLightsError(f"a rig or lights can be exported; got {shown(given)}")
    return lights  # type: ignore[no-any-return]
