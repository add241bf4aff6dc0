"""Checked request of a fit: number of lights, accepted errors, start and fixed directions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native
from envlights._common.check import amount, check_choice, count, reals
from envlights._native import GLOSS_DEGREE, EnvLightsError, FitAnswer
from envlights.detection.detect import detect
from envlights.environment.envmap import EnvMap
from envlights.environment.fill import Fill
from envlights.export.capabilities import Capabilities
from envlights.fitting.reduction import above_horizon
from envlights.kernels import gloss, sphere
from envlights.rigs.lights import Lights
from envlights.rigs.report import SHOWN_ROUGHNESS
from envlights.rigs.rig import Rig

#: Limit on the steps of a descent.
MAX_STEPS = 100


class FitOptions(NamedTuple):
    """Options of a fit, as the kernels take them."""

    ambient: int
    """Number of ambient coefficients in each channel: 0, 1 or 9."""
    start: NDArray[np.float64]
    """Initial directions of the first lights; fixed directions come first."""
    fixed: int
    """Number of fixed directions."""
    lights: int
    """Largest number of lights."""
    error: float | None = None
    """Relative RMS error at which the fit may stop."""
    shadow_error: float | None = None
    """Relative RMS error with shadows at which the fit may stop."""
    gloss_error: float | None = None
    """Relative RMS error of a glossy object at which the fit may stop."""
    gloss_factors: Sequence[float] = ()
    """Factors of the glossy object by degree."""
    sizes: str | None = None
    """Objective for lights with sizes; None for points."""
    max_radius: float | None = None
    """Largest angular radius of a light in radians; None for 75 degrees."""
    max_steps: int = MAX_STEPS
    """Limit on the steps of a descent."""
    floor: bool = False
    """True if a floor hides the light from below the horizon."""
    error_floor: float = 0.0
    """Error below which no light is added."""
    is_plain: bool = False
    """True for forward selection with eight plain starts, for comparison in benchmarks."""


@dataclass(frozen=True)
class FitArguments:
    """Arguments of `fit` as given; for defaults see its signature."""

    lights: int | None
    error: float | None
    shadow_error: float | None
    gloss_error: float | None
    roughness: float
    sizes: bool
    max_radius: float | None
    objective: str
    ambient: str | None
    start: str | Rig | Lights
    fixed: ArrayLike | Lights | None
    floor: bool
    fill: Fill
    target: str | Iterable[str] | None


#: Names of starts; the first two need a map.
STARTS = ("greedy", "detect", "even")
STARTS_WITHOUT_MAP = ("greedy", "even")

#: Default number of lights, and limit if only `error` is given.
LIGHTS = 4
MOST_LIGHTS = 32

#: Limit on the number of even start directions, which is the limit of the kernel for a map.
MOST_EVEN_STARTS = 10240

#: Relative difference below which errors count as equal, so that the simpler ambient term is
#: preferred.
SAME_ERROR = 1e-3

_NO_DIRECTIONS = np.zeros((0, 3))


class Request(NamedTuple):
    """Checked arguments of a fit."""

    lights: int
    """Largest number of lights, including fixed ones."""
    error: float | None
    """Largest accepted relative RMS error."""
    shadow_error: float | None
    """Largest accepted relative RMS error with shadows."""
    gloss_error: float | None
    """Largest accepted relative RMS error of metal of this `roughness`."""
    roughness: float
    """Roughness of the metal."""
    fixed: NDArray[np.float64]
    """Directions of fixed lights, (k, 3)."""
    start_directions: NDArray[np.float64]
    """Start directions of the first free lights, brightest first, (n, 3)."""
    start: str
    """Start for free lights without a start direction: one of `STARTS`."""

    @property
    def has_goal(self) -> bool:
        """True if an accepted error was given."""
        return any(most is not None for most in (self.error, self.shadow_error, self.gloss_error))

    @property
    def gloss_factors(self) -> list[float]:
        """Factors of the metal by degree; empty unless a gloss error was requested."""
        if self.gloss_error is None:
            return []
        factors: list[float] = gloss.factors(self.roughness, "metal", GLOSS_DEGREE).tolist()
        return factors

    def first_directions(self, most: int) -> NDArray[np.float64]:
        """Start directions for free lights without a map, at most `most`."""
        free = self.lights - len(self.fixed)
        if len(self.start_directions):
            return self.start_directions[:free]
        # Stay within the limit `most` of the kernel.
        return _native.even_sphere(min(free, most)) if self.start == "even" else _NO_DIRECTIONS

    @property
    def needs_map(self) -> bool:
        """True if the start needs the pixels of the whole map."""
        return self.start == "detect" and self.lights > len(self.fixed)

    def first_directions_under(self, env: EnvMap | None, has_floor: bool) -> NDArray[np.float64]:
        """Start directions for free lights under a map; over a floor, above the horizon."""
        free = self.lights - len(self.fixed)
        if env is not None and self.needs_map:
            return detect(above_horizon(env) if has_floor else env, max_lights=free).direction
        if self.start == "even" and has_floor:
            # Points are sorted by height, so the first half is above the horizon.
            count = min(free, MOST_EVEN_STARTS)
            return _native.even_sphere(2 * count)[:count]
        return self.first_directions(MOST_EVEN_STARTS)

    def is_reached(self, answer: FitAnswer) -> bool:
        """True if all requested errors are reached, and there is at least one."""
        limits = (
            (self.error, answer.error),
            (self.shadow_error, answer.shadow_error),
            (self.gloss_error, self._gloss_error_of(answer)),
        )
        return self.has_goal and all(most is None or value <= most for most, value in limits)

    def _gloss_error_of(self, answer: FitAnswer) -> float:
        """Gloss error for the requested metal; 0 if not requested."""
        if self.gloss_error is None:
            return 0.0
        return gloss.error(answer.bands, self.roughness) or 0.0

    def best_of(self, answers: Mapping[str, FitAnswer], accuracy: float) -> str:
        """Ambient term with the fewest lights for the requested errors, or the smallest error.

        `answers` hold the simplest first, which wins if several are equal. Errors below the
        `accuracy` are equal.
        """
        reached = {name: one.lights for name, one in answers.items() if self.is_reached(one)}
        if reached:
            return min(reached, key=lambda name: reached[name])
        least = min(answer.error for answer in answers.values())
        enough = max(least * (1 + SAME_ERROR), accuracy)
        return next(name for name, answer in answers.items() if answer.error <= enough)

    def check_above_horizon(self) -> None:
        """Raise an error for lights that a floor would hide."""
        for name, towards in (("fixed", self.fixed), ("start", self.start_directions)):
            below = np.flatnonzero(towards[:, 1] < 0)
            if len(below):
                raise EnvLightsError(
                    f"{name} must have no light below the horizon where there is a floor;"
                    f" the direction {below[0]} has y = {towards[below[0], 1]:.3g}"
                )


def request_for(arguments: FitArguments, most_lights: int | None = None) -> Request:
    """Checked request of a fit to a map; see `request_of`."""
    return request_of(
        arguments.lights,
        arguments.error,
        arguments.start,
        arguments.fixed,
        shadow_error=arguments.shadow_error,
        gloss_error=arguments.gloss_error,
        roughness=arguments.roughness,
        most_lights=most_lights,
    )


def request_of(
    lights: int | None,
    error: float | None,
    start: str | Rig | Lights,
    fixed: ArrayLike | Lights | None,
    starts: tuple[str, ...] = STARTS,
    shadow_error: float | None = None,
    gloss_error: float | None = None,
    roughness: float = SHOWN_ROUGHNESS,
    most_lights: int | None = None,
) -> Request:
    """Check the arguments of a fit; `starts` are the allowed names for `start`.

    `most_lights` is the limit of a target, if it has one.
    """
    fixed_directions, start_directions = _fixed(fixed), _NO_DIRECTIONS
    if isinstance(start, Rig | Lights):
        start_directions = (start.lights if isinstance(start, Rig) else start).direction
        start = "greedy"
    check_choice("start", start, starts)
    goals = {"error": error, "shadow_error": shadow_error, "gloss_error": gloss_error}
    for name, value in goals.items():
        if value is not None and amount(name, value, most=1.0) == 1:
            raise EnvLightsError(
                f"{name} must be below 1 (1 is 100 %, the error without any light); got {value}"
            )
    roughness = gloss.checked_roughness(roughness)
    has_goal = any(value is not None for value in goals.values())
    placed = len(fixed_directions) + len(start_directions)
    most = _most_lights(lights, has_goal, len(fixed_directions), placed)
    if most_lights is not None and most > most_lights:
        if lights is not None or placed > most_lights:
            raise EnvLightsError(
                f"the target shows at most {most_lights} lights; got {max(most, placed)}"
            )
        most = most_lights
    return Request(
        most,
        error,
        shadow_error,
        gloss_error,
        roughness,
        fixed_directions,
        start_directions,
        start,
    )


def _fixed(fixed: ArrayLike | Lights | None) -> NDArray[np.float64]:
    """Directions of fixed lights as an array, after checks."""
    if fixed is None:
        return _NO_DIRECTIONS
    if isinstance(fixed, Lights):
        return fixed.direction
    directions = reals("fixed", fixed, 2)
    sphere.direction_to_uv(directions)  # raises an error for a vector whose length is not 1
    return directions


def _most_lights(lights: int | None, has_goal: bool, fixed: int, placed: int) -> int:
    """Limit on the number of lights; `placed` have directions, `fixed` do not move."""
    if lights is not None:
        if count("lights", lights) < fixed:
            raise EnvLightsError(f"lights must be at least the {fixed} fixed ones; got {lights}")
        return int(lights)
    if has_goal:
        return max(MOST_LIGHTS, fixed)
    return placed or LIGHTS


def check_radius(max_radius: float | None, sizes: bool) -> None:
    """Raise an error for a largest radius that is impossible, or given for points."""
    if max_radius is None:
        return
    amount("max_radius", max_radius, most=np.pi / 2)
    if max_radius == 0:
        raise EnvLightsError(
            "max_radius must be above 0 radians; got 0. Use sizes=False for points"
        )
    if not sizes:
        raise EnvLightsError(
            f"max_radius must not be set for points; got {max_radius:.3g} radians and sizes=False."
            " Leave out one of them"
        )


#: Number of coefficients per channel for each ambient term, simplest first.
AMBIENTS = {"none": 0, "constant": 1, "sh2": 9}
#: Name for the best ambient term.
AUTO = "auto"


def ambient_for(ambient: str | None, has_target: bool, shows: Capabilities) -> str:
    """Checked name of an ambient term, or the default for a target program."""
    if ambient is None:
        return AUTO if has_target and shows.harmonics == "exact" else "constant"
    check_choice("ambient", ambient, (*AMBIENTS, AUTO))
    if ambient == "sh2" and shows.harmonics == "none":
        raise EnvLightsError("ambient must not be 'sh2' for a target that shows no harmonics")
    return ambient


def ambient_names(floor: bool, shows: Capabilities) -> tuple[str, ...]:
    """Ambient terms that "auto" compares, simplest first."""
    return tuple(name for name in shows.ambients() if not (floor and name == "sh2"))


def check_over_floor(ambient: str, request: Request, shows: Capabilities) -> None:
    """Raise an error for arguments that a floor makes impossible."""
    if not shows.floor:
        raise EnvLightsError(
            "floor must be False for a target that shows no light from above alone"
        )
    if ambient == "sh2":
        raise EnvLightsError(
            "ambient must be 'none' or 'constant' or 'auto' where there is a floor, because"
            " harmonics cannot be fitted over one; got 'sh2'"
        )
    request.check_above_horizon()
