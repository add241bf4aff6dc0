"""What a caller of a fit asks for: how many lights, how good, from where, and which stay."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native
from envlights._blocks import in_blocks
from envlights._check import amount, check_choice, count, reals
from envlights._native import EnvLightsError
from envlights.detection.detect import detect
from envlights.envmap import EnvMap
from envlights.kernels import sphere
from envlights.lights import Lights
from envlights.rig import Rig

#: The starts that have names, with a map and without.
STARTS = ("greedy", "detect", "even")
STARTS_WITHOUT_MAP = ("greedy", "even")

#: Lights when neither `lights` nor `error` is given, and at most when only `error` is.
LIGHTS = 4
MOST_LIGHTS = 32

#: Even starts that are placed at most: the kernel refuses as many lights under a map.
MOST_STARTED = 10240

_NOWHERE = np.zeros((0, 3))


class Asked(NamedTuple):
    """The lights that are asked for."""

    lights: int
    """How many at most, the fixed ones among them."""
    error: float | None
    """Relative RMS error that is good enough."""
    shadow_error: float | None
    """The same where things stand in the way."""
    fixed: NDArray[np.float64]
    """Directions of lights that stay where they are."""
    given: NDArray[np.float64]
    """Directions from which the first of the others start, brightest first."""
    start: str
    """Where they start if none is given: one of `STARTS`."""

    @property
    def has_goal(self) -> bool:
        """Whether an error was asked for."""
        return self.error is not None or self.shadow_error is not None

    def first_directions(self, most: int) -> NDArray[np.float64]:
        """Where the first lights that may move start without a map; at most `most` of them."""
        others = self.lights - len(self.fixed)
        if len(self.given):
            return self.given[:others]
        # The kernel refuses more than `most` lights; there is no need to place them before.
        return _native.even_sphere(min(others, most)) if self.start == "even" else _NOWHERE

    def first_directions_under(self, env: EnvMap, has_floor: bool) -> NDArray[np.float64]:
        """The same under a map, and none below the horizon where it `has_floor`."""
        others = self.lights - len(self.fixed)
        if self.start == "detect" and others:
            return detect(above_horizon(env) if has_floor else env, max_lights=others).direction
        if self.start == "even" and has_floor:
            # The points come from the top down.
            count = min(others, MOST_STARTED)
            return _native.even_sphere(2 * count)[:count]
        return self.first_directions(MOST_STARTED)

    def is_reached(self, error: float, shadow_error: float) -> bool:
        """Whether these are good enough, where any error was asked for."""
        wanted = ((self.error, error), (self.shadow_error, shadow_error))
        return any(most is not None for most, _ in wanted) and all(
            most is None or seen <= most for most, seen in wanted
        )

    def check_above_horizon(self) -> None:
        """Refuse lights that a floor would hide."""
        for name, towards in (("fixed", self.fixed), ("start", self.given)):
            below = np.flatnonzero(towards[:, 1] < 0)
            if len(below):
                raise EnvLightsError(
                    f"{name} must have no light below the horizon where there is a floor;"
                    f" the direction {below[0]} has y = {towards[below[0], 1]:.3g}"
                )


def asked(
    lights: int | None,
    error: float | None,
    start: str | Rig | Lights,
    fixed: ArrayLike | Lights | None,
    starts: tuple[str, ...] = STARTS,
    shadow_error: float | None = None,
) -> Asked:
    """The arguments of a fit, checked; `starts` are the names that `start` may have."""
    fixed_directions, given = _fixed(fixed), _NOWHERE
    if isinstance(start, Rig | Lights):
        given = (start.lights if isinstance(start, Rig) else start).direction
        start = "greedy"
    check_choice("start", start, starts)
    started = len(fixed_directions) + len(given)
    for name, wanted in (("error", error), ("shadow_error", shadow_error)):
        if wanted is not None:
            amount(name, wanted, most=1.0)
    has_goal = error is not None or shadow_error is not None
    most = _most_lights(lights, has_goal, len(fixed_directions), started)
    return Asked(most, error, shadow_error, fixed_directions, given, start)


def _fixed(fixed: ArrayLike | Lights | None) -> NDArray[np.float64]:
    """Directions of the lights that stay where they are."""
    if fixed is None:
        return _NOWHERE
    if isinstance(fixed, Lights):
        return fixed.direction
    directions = reals("fixed", fixed, 2)
    sphere.direction_to_uv(directions)  # refuses a vector that is not of length 1
    return directions


def _most_lights(lights: int | None, has_goal: bool, fixed: int, started: int) -> int:
    """How many lights there may be, of which `fixed` are fixed and `started` have a start."""
    if lights is not None:
        if count("lights", lights) < fixed:
            raise EnvLightsError(f"lights must be at least the {fixed} fixed ones; got {lights}")
        return int(lights)
    if has_goal:
        return max(MOST_LIGHTS, fixed)
    return started or LIGHTS


def above_horizon(env: EnvMap) -> EnvMap:
    """`env`, black where its pixels look down."""
    is_border_sampled = env.registration == "border-sampled"
    # One column tells the heights of all rows.
    towards = sphere.pixel_directions(env.height, 2, border_sampled=is_border_sampled)[:, :1]
    radiance = in_blocks(
        env.radiance.shape,
        lambda rows: np.where(towards[rows, :, 1:2] < 0, np.float32(0), env.radiance[rows]),
    )
    return EnvMap(radiance, registration=env.registration, white=env.white)
