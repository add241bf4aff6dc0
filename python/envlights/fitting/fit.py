"""From a map, or from a measured probe, to a rig."""

from __future__ import annotations

from dataclasses import replace
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native
from envlights._check import amount, check_choice, count, reals
from envlights._native import EnvLightsError
from envlights.detection.detect import detect
from envlights.envmap import EnvMap, seen_through
from envlights.fitting.normals import Samples, fitted_and_judging, upper_fitted_and_judging
from envlights.fitting.solution import rig_of, solutions, stop_reason
from envlights.kernels import sphere
from envlights.kernels.probe import WORKING_COLUMNS
from envlights.lights import Lights
from envlights.rig import Rig

#: The starts of `fit` that have names.
STARTS = ("greedy", "detect", "even")
#: Environments beside the lights, and the number of their coefficients in each channel.
AMBIENTS = {"constant": 1, "none": 0, "sh2": 9}
#: Surfaces whose irradiance is fitted.
NORMALS = ("sphere", "upper")

#: Lights when neither `lights` nor `error` is given, and at most when only `error` is.
LIGHTS = 4
MOST_LIGHTS = 32

_NOWHERE = np.zeros((0, 3))


def fit(
    env: EnvMap | ArrayLike,
    lights: int | None = None,
    *,
    error: float | None = None,
    ambient: str = "constant",
    start: str | Rig | Lights = "greedy",
    fixed: ArrayLike | Lights | None = None,
    normals: str = "sphere",
) -> Rig:
    """Ambient and a few directional lights that light a white probe as `env` does.

    A white Lambertian probe is rendered under the map at 320 normals. The lights are found by
    variable projection with non-negative radiances: lights are added one at a time where the
    residual is largest (forward selection), other sets start from evenly spread directions, some
    of these exchange lights, and the best sets are refined from perturbed starts. The error is
    measured at 5120 other normals.

    Parameters
    ----------
    env : EnvMap or array_like, shape (height, 2 * height, 3)
        The map; an array is taken as `EnvMap` takes it.
    lights : int, optional
        How many directional lights at most, 0 or more. Fewer come back where more would not lower
        the error. Left out: 4, or as many as `fixed` or `start` have, or up to 32 where an `error`
        is asked for.
    error : float, optional
        Relative RMS error that is good enough: the fewest lights that reach it come back, which
        may be none. `report` holds the error for each number that was tried, and says whether
        `lights` were enough.
    ambient : {"constant", "none", "sh2"}
        "constant": beside the lights, an environment of one radiance. "none": lights alone. "sh2":
        an environment of nine spherical harmonics, the form that real-time engines take; its
        irradiance is nowhere negative.
    start : {"greedy", "detect", "even"}, Rig or Lights
        "greedy": the whole search. All others descend from given directions, without the search,
        and add further lights where the residual is largest. "detect": from the bright places that
        `detect` finds, so that each light stays with its lamp. "even": from points spread over the
        sphere (Madsen et al. 2003, section 3.2); this often ends in a local minimum. A rig, or
        lights: from theirs, as for the next frame of a video. Only directions are taken from it, so
        give `lights` and `ambient` for every frame. Lights are matched by their directions: their
        order is that of the brightness in this frame.
    fixed : array_like, shape (k, 3), or Lights, optional
        Unit vectors towards lights that stay where they are; only their radiances are fitted. They
        count among `lights`, and are returned even if black. `report.fixed` holds their rows among
        the lights of the rig.
    normals : {"sphere", "upper"}
        Which surfaces count, in the fit and in the error: all, or those that face up, for objects
        that stand on a floor.

    Returns
    -------
    Rig
        Ambient radiance and lights, none negative, with the error and a report.

    Raises
    ------
    EnvLightsError
        If `env` is not a map, `lights` not a count or fewer than `fixed`, `error` not a share, a
        `fixed` direction not a unit vector, or `ambient`, `start` or `normals` not known.

    See Also
    --------
    fit_probe : the same fit on probe values from elsewhere.

    References
    ----------
    C. B. Madsen, M. K. D. Sørensen, M. Vittrup: "Estimating Positions and Radiances of a Small
    Number of Light Sources for Real-Time Image-Based Lighting", Eurographics 2003; section 3.
    Variable projection: Golub and Pereyra 1973.

    Examples
    --------
    A sun at the zenith over a grey world:

    >>> import envlights as el
    >>> world = el.synthetic.scene(
    ...     64,
    ...     background=(0.5, 0.5, 0.5),
    ...     shapes=[el.synthetic.Disc((0, 1, 0), 2.0, (500, 500, 500))],
    ... )
    >>> rig = el.fit(world.radiance, lights=1)
    >>> rig.lights.direction.round(3) + 0.0
    array([[0., 1., 0.]])
    >>> rig.error < 0.01
    True
    """
    check_choice("ambient", ambient, tuple(AMBIENTS))
    check_choice("normals", normals, NORMALS)
    fixed_directions = _fixed(fixed)
    most = _most_lights(lights, error, start, len(fixed_directions))
    clock = _Clock()
    samples = upper_fitted_and_judging if normals == "upper" else fitted_and_judging
    world, (fitted, judging, sources) = seen_through(env, samples)
    clock.lap("probe")
    first = _first_directions(start, most - len(fixed_directions), len(fitted.normals), world)
    clock.lap("start")
    found = solutions(fitted, judging, error, most, AMBIENTS[ambient], fixed_directions, first)
    clock.lap("fit")
    rig = rig_of(found, judging, len(fixed_directions), len(first))
    clock.lap("report")
    which = "upward normals" if normals == "upper" else "normals"
    measured_on = f"{len(judging.normals)} {which} that were not fitted"
    skipped = (*_working_map(world, sources), *_channels(fitted))
    return replace(_reported(rig, most, error, clock, measured_on, skipped), notes=world.notes)


def fit_probe(
    normals: ArrayLike,
    irradiance: ArrayLike,
    lights: int | None = None,
    *,
    weights: ArrayLike | None = None,
    ambient: str = "constant",
    start: str | Rig | Lights = "greedy",
    fixed: ArrayLike | Lights | None = None,
) -> Rig:
    """Ambient and at most `lights` directional lights from probe values measured elsewhere.

    The same fit as `fit`, on irradiance that was measured or rendered by another program. Without a
    map the rig cannot be judged at other normals: its error is the one at `normals`, which is too
    low where they are few.

    Parameters
    ----------
    normals : array_like, shape (n, 3)
        Unit normals, in the frame of `EnvMap`.
    irradiance : array_like, shape (n, 3)
        RGB irradiance at each. For the radiance of a white Lambertian probe, give pi times it.
    lights : int, optional
        How many directional lights, 0 or more. Left out: 4, or as many as `fixed` or `start` have.
    weights : array_like, shape (n,), optional
        Weight of each normal, such as the solid angle it stands for. All alike when left out.
    ambient : {"constant", "none", "sh2"}
        As for `fit`.
    start : {"greedy", "even"}, Rig or Lights
        As for `fit`.
    fixed : array_like, shape (k, 3), or Lights, optional
        As for `fit`.

    Returns
    -------
    Rig
        Ambient radiance and lights, none negative, with the error and a report.

    Raises
    ------
    EnvLightsError
        If shapes do not fit, a value is not finite, a normal is not a unit vector, a weight is
        negative or all are 0, or there are fewer equations than unknowns: 5 for each light, and 3
        for "constant" or 27 for "sh2".

    Examples
    --------
    >>> from envlights import kernels
    >>> normals, solid_angles = kernels.icosphere(320)
    >>> probe = kernels.rig_irradiance(normals, [0.1, 0.1, 0.1], [[0, 0.6, 0.8]], [[3, 2, 1]])
    >>> rig = fit_probe(normals, probe, lights=1)
    >>> rig.lights.direction.round(6) + 0.0, rig.lights.irradiance.round(6)
    (array([[0. , 0.6, 0.8]]), array([[3., 2., 1.]]))
    """
    check_choice("ambient", ambient, tuple(AMBIENTS))
    fixed_directions = _fixed(fixed)
    most = _most_lights(lights, None, start, len(fixed_directions))
    normals, irradiance = reals("normals", normals, 2), reals("irradiance", irradiance, 2)
    weights = np.ones(len(normals)) if weights is None else reals("weights", weights, 1)
    if len(weights) and not weights.any():
        raise EnvLightsError("weights must not all be 0")
    samples = Samples(normals, weights, irradiance)
    clock = _Clock()
    first = _first_directions(start, most - len(fixed_directions), len(normals), None)
    found = solutions(samples, samples, None, most, AMBIENTS[ambient], fixed_directions, first)
    clock.lap("fit")
    rig = rig_of(found, samples, len(fixed_directions), len(first))
    clock.lap("report")
    measured_on = f"the {len(normals)} fitted normals"
    return _reported(rig, most, None, clock, measured_on, _channels(samples))


class _Clock:
    """Wall time of each stage."""

    def __init__(self) -> None:
        self.laps: dict[str, float] = {}
        self._last = perf_counter()

    def lap(self, stage: str) -> None:
        """Note the time since the last lap under `stage`."""
        now = perf_counter()
        self.laps[stage] = now - self._last
        self._last = now


def _reported(
    rig: Rig,
    most: int,
    error: float | None,
    clock: _Clock,
    measured_on: str,
    skipped: tuple[str, ...],
) -> Rig:
    """`rig` with times, normals, and what was skipped in its report."""
    report = replace(
        rig.report,
        seconds=clock.laps,
        measured_on=measured_on,
        skipped=(*skipped, *_counts(rig, most, error)),
        stop_reason=stop_reason(rig, error),
    )
    return replace(rig, report=report)


def _fixed(fixed: ArrayLike | Lights | None) -> NDArray[np.float64]:
    """Directions of the lights that stay where they are."""
    if fixed is None:
        return _NOWHERE
    if isinstance(fixed, Lights):
        return fixed.direction
    directions = reals("fixed", fixed, 2)
    sphere.direction_to_uv(directions)  # refuses a vector that is not of length 1
    return directions


def _most_lights(
    lights: int | None, error: float | None, start: str | Rig | Lights, fixed: int
) -> int:
    """How many lights there may be, of which `fixed` are fixed."""
    if error is not None:
        amount("error", error, most=1.0)
    if lights is not None:
        if count("lights", lights) < fixed:
            raise EnvLightsError(f"lights must be at least the {fixed} fixed ones; got {lights}")
        return lights
    if error is not None:
        return max(MOST_LIGHTS, fixed)
    given = _given(start)
    started = fixed + (0 if given is None else len(given))
    return started or LIGHTS


def _given(start: str | Rig | Lights) -> Lights | None:
    """The lights of a start that is a rig or lights."""
    if isinstance(start, Rig):
        return start.lights
    return start if isinstance(start, Lights) else None


def _first_directions(
    start: str | Rig | Lights, lights: int, normals: int, env: EnvMap | None
) -> NDArray[np.float64]:
    """Where the first of at most `lights` lights start, brightest first."""
    given = _given(start)
    if given is not None:
        return given.direction[:lights]
    check_choice("start", start, STARTS if env is not None else ("greedy", "even"))
    if start == "greedy" or lights == 0:
        return _NOWHERE
    if start == "even":
        return _native.even_sphere(min(lights, normals))  # the kernel refuses more lights
    assert env is not None
    return detect(env, max_lights=lights).direction


def _working_map(env: EnvMap, sources: int) -> tuple[str, ...]:
    if env.width <= WORKING_COLUMNS:
        return ()
    return (
        f"{env.width}x{env.height} pixels were rendered as a working map of at most"
        f" {WORKING_COLUMNS} columns, its brightest cells ({sources}) as points: this puts"
        " a floor of about 1e-4 under the error",
    )


def _channels(samples: Samples) -> tuple[str, ...]:
    """A note where channels are black or equal, and so were not fitted one by one."""
    channels = {channel.tobytes() for channel in samples.irradiance.T}
    fitted = len(channels) - any(not channel.any() for channel in samples.irradiance.T)
    return () if fitted == 3 else (f"{3 - fitted} of 3 channels: black, or the same as another",)


def _counts(rig: Rig, most: int, error: float | None) -> tuple[str, ...]:
    """Why there are fewer lights than there may be."""
    used, tried = len(rig.lights), max(rig.report.errors)
    if used >= most:
        return ()
    reached = error is not None and rig.error <= error and used == tried
    why = "fewer are good enough" if reached else "they would not lower the error"
    untried = f"; more than {tried} were not tried" if tried < most else ""
    return (f"{most - used} of {most} lights: {why}{untried}",)
