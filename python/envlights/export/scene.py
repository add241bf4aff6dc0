"""Parts of a rig that every exporter writes: lights, and a constant or a map around them."""

from __future__ import annotations

import re
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.blocks import in_blocks
from envlights._common.check import describe
from envlights._common.printable import printable
from envlights._common.units import PHOTOMETRIC
from envlights._native import EnvLightsError
from envlights.cards import Cards
from envlights.environment.decoders.source import is_source
from envlights.environment.envmap import EnvMap, as_envmap
from envlights.export.panels import Panel, distant_and_panels
from envlights.export.units import UNITS
from envlights.kernels.ambient import ambient_rows
from envlights.kernels.sphere import pixel_solid_angles
from envlights.rigs.capabilities import HARMONIC_MEAN, ROWS
from envlights.rigs.lights import Lights
from envlights.rigs.rig import Rig

#: Lights that cast shadows, the brightest, in renderers that draw the scene again for each of them.
CASTERS = 3

#: Targets that show cards as planes in space.
PANELS = ("gltf", "three", "usd", "mitsuba", "blender", "pbrt")


class Scene(NamedTuple):
    """Content of an exported scene, in the frame and units of envlights."""

    lights: Lights
    """Discs and points, brightest first; irradiance at normal incidence."""

    ambient: NDArray[np.float64] | None
    """Radiance of a constant environment, (3,); None if there is none, or if there is a map."""

    environment: EnvMap | None
    """Cell-centred map that replaces the constant."""

    statement: str
    """Sentence for the file on the units of all numbers, and on estimates among them."""

    panels: tuple[Panel, ...] = ()
    """Cards as planes in space; the `lights` are without them."""


def scene_of(
    rig: Rig | Lights | Cards, environment: EnvMap | ArrayLike | None = None, *, target: str
) -> Scene:
    """Parts of a rig, or of lights alone, in the units of a target.

    Parameters
    ----------
    rig : Rig, Lights or Cards
        Detected lights become discs of the same flux and solid angle. Cards become panels if the
        target is in `PANELS`, and discs otherwise.
    environment : EnvMap or array_like, optional
        Map that replaces the ambient term; an array has the units of the lights.
    target : str
        Name in `units.UNITS`.

    Returns
    -------
    Scene
        Harmonics, and the upper half of an ambient term over a floor, become a small map.

    Raises
    ------
    EnvLightsError
        If `rig` is no rig, or the environment has other units than the lights.
    """
    lights = check_rig(rig).discs()
    if environment is None:
        (ambient, env), units = _ambient_of(rig), lights.units
    else:
        env = _environment(lights, environment)
        ambient, units = None, env.units
    statement = statement_of(lights, units, target)
    factor = UNITS[target].factor if units == PHOTOMETRIC else 1.0
    panels: tuple[Panel, ...] = ()
    if target in PANELS:
        lights, panels = distant_and_panels(rig, env, factor)
    return _times(Scene(lights, ambient, env, statement, panels), factor)


def statement_of(lights: Lights, units: str, target: str) -> str:
    """Sentence for the file of a target: units, and the notes of the lights."""
    return "; ".join([UNITS[target].statement(units), *map(_plain, lights.notes)])


def _plain(note: str) -> str:
    """Note for the comments and strings of any format: without quotes, escapes and line breaks."""
    text = printable(note).replace('"', "'").replace("\\", "/").replace("*/", "* /")
    return re.sub("--+", "-", text)


def _environment(lights: Lights, environment: EnvMap | ArrayLike) -> EnvMap:
    """Cell-centred map around the lights, or a refusal if its scale is not theirs."""
    if not isinstance(environment, EnvMap) and not is_source(environment):
        return EnvMap(environment, units=lights.units)
    env = as_envmap(environment)
    if len(lights) and env.units != lights.units:
        raise EnvLightsError(
            f"the environment must have the units of the lights, {lights.units!r}; got"
            f" {env.units!r}; calibrate both, or make both of one map"
        )
    return EnvMap(env.cells(), units=env.units) if env.is_border_sampled else env


def _ambient_of(rig: Rig | Lights | Cards) -> tuple[NDArray[np.float64] | None, EnvMap | None]:
    """Radiance of a constant ambient term, or a small map of another one."""
    ambient, floor = getattr(rig, "ambient", np.zeros(3)), getattr(rig, "floor", False)
    if not np.any(ambient):
        return None, None
    if ambient.ndim == 1 and not floor:
        return ambient, None
    return None, EnvMap(in_blocks((ROWS, 2 * ROWS, 3), ambient_rows(ambient, ROWS, floor)))


def _times(scene: Scene, factor: float) -> Scene:
    """Scene with all numbers times `factor`."""
    if factor == 1:
        return scene
    lights, ambient, env, *_ = scene
    dimmed = Lights(lights.direction, factor * lights.irradiance, lights.angular_radius)
    return scene._replace(
        lights=dimmed,
        ambient=None if ambient is None else factor * ambient,
        environment=None if env is None else EnvMap(np.float32(factor) * env.radiance),
    )


def at_most(scene: Scene, count: int) -> Scene:
    """Scene with its `count` brightest lights; the others become part of the ambient term.

    Averaged over all normals, a light gives a quarter of its irradiance, as a constant radiance of
    1 / (4 pi) of it does.
    """
    surplus = scene.lights[count:]
    if not len(surplus):
        return scene
    added, lights = surplus.irradiance.sum(axis=0) / (4 * np.pi), scene.lights[:count]
    if scene.environment is None:
        ambient = added if scene.ambient is None else added + scene.ambient
        return scene._replace(lights=lights, ambient=ambient)
    radiance = scene.environment.radiance + added.astype(np.float32)
    return scene._replace(lights=lights, environment=EnvMap(radiance))


def mean_radiance(rig: Any, environment: EnvMap | None) -> NDArray[np.float64]:
    """Mean radiance of a map, or of the ambient term of a rig, (3,); that over a floor is whole."""
    if environment is None:
        ambient = np.asarray(getattr(rig, "ambient", np.zeros(3)))
        return HARMONIC_MEAN * ambient[0] if ambient.ndim == 2 else ambient
    radiance = environment.cells()
    rows = pixel_solid_angles(len(radiance), 2).sum(axis=1) / (4 * np.pi)
    mean: NDArray[np.float64] = rows @ radiance.mean(axis=1, dtype=np.float64)
    return mean


def check_rig(rig: Rig | Lights | Cards) -> Lights:
    """Lights of a rig, or lights themselves; a refusal of anything else."""
    lights: Any = getattr(rig, "lights", rig)
    if not hasattr(lights, "discs"):
        raise EnvLightsError(f"only a rig or lights can be exported; got {describe(rig)}")
    return lights  # type: ignore[no-any-return]
