"""Scene content for all exporters: lights, and a constant or a map around them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from envlights._common.blocks import in_blocks
from envlights._common.check import describe
from envlights._native import EnvLightsError
from envlights.environment.envmap import EnvMap
from envlights.environment.picture_files import is_picture_source
from envlights.environment.reading import AnyMap, as_envmap
from envlights.export.capabilities import ROWS
from envlights.export.panels import Panel, distant_and_panels
from envlights.export.targets import TARGETS, target_named
from envlights.kernels.ambient import ambient_rows, mean_ambient
from envlights.kernels.sphere import pixel_solid_angles

#: Targets that support cards as planes in space.
PANELS = tuple(target.name for target in TARGETS if target.shows.cards)


class Discs(Protocol):
    """Protocol of discs and points at infinity, brightest first, such as `Lights`."""

    @property
    def direction(self) -> NDArray[np.float64]:
        """Unit vectors towards the lights, (n, 3)."""

    @property
    def irradiance(self) -> NDArray[np.float64]:
        """Irradiance at normal incidence, (n, 3)."""

    @property
    def angular_radius(self) -> NDArray[np.float64]:
        """Angular radius in radians, (n,)."""

    @property
    def units(self) -> str:
        """Unit of the radiance."""

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on estimates."""

    def __len__(self) -> int: ...

    def __getitem__(self, which: Any, /) -> Any:
        """Lights of a slice or a mask."""

    def to_map(self, height: int, /) -> EnvMap:
        """Map of the lights in a black sky."""


class AnyLights(Protocol):
    """Protocol of lights of any kind: given, detected or removed."""

    def discs(self) -> Discs:
        """Discs of the same flux and solid angle."""


class HasLights(Protocol):
    """Protocol of a rig or cards."""

    @property
    def lights(self) -> AnyLights:
        """Lights without the ambient term."""


#: Exportable types: `Lights`, `Rig` and `Cards`.
Exportable = AnyLights | HasLights


class Scene(NamedTuple):
    """Content of an exported scene, in our frame, and in the units of the target."""

    lights: Discs
    """Discs and points, brightest first; irradiance at normal incidence."""

    ambient: NDArray[np.float64] | None
    """Radiance of a constant environment, (3,); None if there is none, or a map instead."""

    environment: EnvMap | None
    """Cell-centred map that replaces the constant."""

    statement: str
    """Sentence for the file about units and estimates.

    One line without control characters; each writer quotes it by the syntax of its format."""

    term: NDArray[np.float64]
    """Ambient term of the rig, (3,) or harmonics, (9, 3); zeros if a map replaces it."""

    floor: bool
    """True if a floor hides the ambient term from below."""

    panels: tuple[Panel, ...] = ()
    """Cards as planes in space, which are not in `lights`."""

    @property
    def has_map(self) -> bool:
        """True if a map replaces the ambient term."""
        return self.environment is not None and not self.term.any()

    @property
    def constant(self) -> NDArray[np.float64]:
        """Radiance of a constant environment, (3,); zeros without one."""
        return np.zeros(3) if self.ambient is None else self.ambient


def scene_of(rig: Exportable, environment: AnyMap | None = None, *, target: str) -> Scene:
    """Parts of a rig, or of lights alone, in the units of a target.

    Parameters
    ----------
    rig : Rig, Lights or Cards
        Detected lights become discs of the same flux and solid angle. Cards become panels if the
        target is in `PANELS`, and discs otherwise.
    environment : EnvMap or array_like, optional
        Map that replaces the ambient term; an array has the units of the lights.
    target : str
        Name of the target.

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
        term, floor = np.asarray(getattr(rig, "ambient", np.zeros(3))), getattr(rig, "floor", False)
        (ambient, env), units = _surroundings(term, floor), lights.units
    else:
        ambient, env, term, floor = None, _environment(lights, environment), np.zeros(3), False
        units = env.units
    statement = statement_of(lights, units, target)
    factor = target_named(target).units.factor_of(units)
    panels: tuple[Panel, ...] = ()
    if target in PANELS:
        lights, panels = distant_and_panels(rig, env, factor)
    return _times(Scene(lights, ambient, env, statement, term, floor, panels), factor)


def statement_of(lights: Discs, units: str, target: str) -> str:
    """Sentence for the file of a target: units, and the notes of the lights."""
    return "; ".join([target_named(target).units.statement(units), *lights.notes])


def _environment(lights: Discs, environment: AnyMap) -> EnvMap:
    """Cell-centred map around the lights; raises an error if its units differ from theirs."""
    if not isinstance(environment, EnvMap) and not is_picture_source(environment):
        array: Any = environment
        return EnvMap(array, units=lights.units)
    env = as_envmap(environment)
    if len(lights) and env.units != lights.units:
        raise EnvLightsError(
            f"the environment must have the units of the lights, {lights.units!r}; got"
            f" {env.units!r}; calibrate both, or make both of one map"
        )
    return EnvMap(env.cells(), units=env.units) if env.is_border_sampled else env


def _surroundings(
    term: NDArray[np.float64], floor: bool
) -> tuple[NDArray[np.float64] | None, EnvMap | None]:
    """Radiance of a constant ambient term, or a small map for other ambient terms."""
    if not term.any():
        return None, None
    if term.ndim == 1 and not floor:
        return term, None
    return None, EnvMap(in_blocks((ROWS, 2 * ROWS, 3), ambient_rows(term, ROWS, floor)))


def _times(scene: Scene, factor: float) -> Scene:
    """Scene with all radiometric values multiplied by `factor`."""
    if factor == 1:
        return scene
    lights: Any = scene.lights
    ambient, env = scene.ambient, scene.environment
    return scene._replace(
        lights=replace(lights, irradiance=factor * lights.irradiance),
        ambient=None if ambient is None else factor * ambient,
        environment=None if env is None else EnvMap(np.float32(factor) * env.radiance),
        term=factor * scene.term,
    )


def at_most(scene: Scene, count: int | None) -> Scene:
    """Scene with its `count` brightest lights; all others become ambient light.

    Averaged over all normals, a light gives a quarter of its irradiance, as a constant radiance of
    1 / (4 pi) of it does.
    """
    surplus = scene.lights[len(scene.lights) if count is None else count :]
    if not len(surplus):
        return scene
    added, lights = surplus.irradiance.sum(axis=0) / (4 * np.pi), scene.lights[:count]
    if scene.environment is None:
        return scene._replace(lights=lights, ambient=added + scene.constant)
    radiance = scene.environment.radiance + added.astype(np.float32)
    return scene._replace(lights=lights, environment=EnvMap(radiance))


def mean_radiance(scene: Scene) -> NDArray[np.float64]:
    """Mean radiance of a map or of the ambient term, (3,), ignoring a floor."""
    if not scene.has_map or scene.environment is None:
        return mean_ambient(scene.term)
    radiance = scene.environment.cells()
    rows = pixel_solid_angles(len(radiance), 2).sum(axis=1) / (4 * np.pi)
    mean: NDArray[np.float64] = rows @ radiance.mean(axis=1, dtype=np.float64)
    return mean


def check_rig(rig: Exportable) -> AnyLights:
    """Lights of a rig, or the given lights; raises an error for other values."""
    lights: Any = getattr(rig, "lights", rig)
    if not hasattr(lights, "discs"):
        raise EnvLightsError(f"only a rig or lights can be exported; got {describe(rig)}")
    return lights  # type: ignore[no-any-return]
