"""From a map, or from a measured probe, to a rig."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from time import perf_counter
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native, kernels
from envlights._check import amount, check_choice, count, reals
from envlights._native import EnvLightsError, FitAnswer
from envlights.detect import detect
from envlights.envmap import EnvMap, seen_through
from envlights.normals import Samples, fitted_and_judging
from envlights.report import FitReport, StopReason
from envlights.rig import LUMINANCE, Lights, Rig

#: Where the lights of `fit` may start.
STARTS = ("greedy", "detect", "even")
#: What a fit may use beside the lights, and its coefficients in each channel.
AMBIENTS = {"constant": 1, "none": 0, "sh2": 9}
#: Which normals count.
NORMALS = ("sphere", "upper")

#: Lights of a fit that is not told how many, and of one that is told an error.
LIGHTS = 4
MOST_LIGHTS = 32

#: Steps after which the solver gives up on a start; real maps take 5 to 30.
MAX_STEPS = 100

#: A light that lowers the error by less than this share of it does not pay for itself.
NO_GAIN = 1e-3

_NOWHERE = np.zeros((0, 3))


def fit(
    env: EnvMap | ArrayLike,
    lights: int | None = None,
    *,
    error: float | None = None,
    ambient: str = "constant",
    start: str | Rig = "greedy",
    fixed: ArrayLike | None = None,
    normals: str = "sphere",
) -> Rig:
    """Ambient and a few directional lights that light a white probe as `env` does.

    A white Lambertian probe is rendered under the map at 320 normals. Variable projection with
    non-negative radiances then finds the lights: downhill from where each explains most of what is
    left, from even starts, and again with lights exchanged while that pays. The error is measured
    at 5120 other normals.

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
        may be none. `report` holds the error for each number that was tried, and says so where
        `lights` were not enough.
    ambient : {"constant", "none", "sh2"}
        "constant": beside the lights, an environment of one radiance. "none": lights alone. "sh2":
        an environment of nine spherical harmonics, the form that real-time engines take; its
        irradiance is nowhere negative.
    start : {"greedy", "detect", "even"} or Rig
        "greedy": wherever the search finds them. The others start the lights at given places, from
        where they go downhill, and add those beyond greedily: "detect" at the bright places that
        `detect` finds, so that each stays with its lamp; "even" at points spread over the sphere
        (Madsen et al. 2003, section 3.2), which often get stuck; a rig at its own lights, as for
        the next frame of a video, which takes a fraction of the time.
    fixed : array_like, shape (k, 3), optional
        Unit vectors towards lights that stay where they are and get only their radiances; they are
        the first of `lights`, and come back even where black.
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
        If `env` is no map, `lights` no count or fewer than `fixed`, `error` no share, a `fixed`
        direction no unit vector, or `ambient`, `start` or `normals` not known.

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
    held = _fixed(fixed)
    most = _most_lights(lights, error, start, held)
    clock = _Clock()
    world, (fitted, judging, sources) = seen_through(env, fitted_and_judging)
    if normals == "upper":
        fitted, judging = fitted.upper(), judging.upper()
    clock.lap("probe")
    first = _first_directions(start, most - len(held), world)
    clock.lap("start")
    answers = _answers(fitted, judging, error, most, AMBIENTS[ambient], held, first)
    clock.lap("fit")
    rig = _rig(answers, judging, len(held) + len(first))
    clock.lap("report")
    tried = max(rig.report.errors)
    skipped = (*_working_map(world, sources), *_channels(fitted), *_counts(rig, tried, most, error))
    report = replace(
        rig.report,
        seconds=clock.laps,
        measured_on=f"{len(judging.normals)} normals that were not fitted",
        skipped=skipped,
        stop_reason=_stop_reason(rig, error),
    )
    return replace(rig, report=report, notes=world.notes)


def fit_probe(
    normals: ArrayLike,
    irradiance: ArrayLike,
    lights: int | None = None,
    *,
    weights: ArrayLike | None = None,
    ambient: str = "constant",
    start: str | Rig = "greedy",
    fixed: ArrayLike | None = None,
) -> Rig:
    """Ambient and at most `lights` directional lights from probe values measured elsewhere.

    The fit of `fit`, on irradiance that was measured, or rendered by another program. There is no
    map to judge the rig at other normals: its error is the one at `normals`, and flatters it where
    they are few.

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
    start : {"greedy", "even"} or Rig
        As for `fit`.
    fixed : array_like, shape (k, 3), optional
        As for `fit`.

    Returns
    -------
    Rig
        Ambient radiance and lights, none negative, with the error and a report.

    Raises
    ------
    EnvLightsError
        If shapes do not fit, a value is not finite, a normal is no unit vector, or there are fewer
        equations than unknowns: 5 a light and 3 or, for "sh2", 27.

    Examples
    --------
    >>> from envlights import kernels
    >>> normals, solid_angles = kernels.icosphere(320)
    >>> probe = kernels.rig_irradiance(normals, [0.1, 0.1, 0.1], [[0, 0.6, 0.8]], [[3, 2, 1]])
    >>> rig = fit_probe(normals, probe, lights=1)
    >>> rig.lights.direction.round(6), rig.lights.irradiance.round(6)
    (array([[0. , 0.6, 0.8]]), array([[3., 2., 1.]]))
    """
    check_choice("ambient", ambient, tuple(AMBIENTS))
    held = _fixed(fixed)
    most = _most_lights(lights, None, start, held)
    normals, irradiance = reals("normals", normals, 2), reals("irradiance", irradiance, 2)
    weights = np.ones(len(normals)) if weights is None else reals("weights", weights, 1)
    samples = Samples(normals, weights, irradiance)
    clock = _Clock()
    first = _first_directions(start, most - len(held), None)
    answers = _answers(samples, samples, None, most, AMBIENTS[ambient], held, first)
    clock.lap("fit")
    rig = _rig(answers, samples, len(held) + len(first))
    clock.lap("report")
    tried = max(rig.report.errors)
    report = replace(
        rig.report,
        seconds=clock.laps,
        measured_on=f"the {len(normals)} fitted normals",
        skipped=(*_channels(samples), *_counts(rig, tried, most, None)),
        stop_reason=_stop_reason(rig, None),
    )
    return replace(rig, report=report)


class _Clock:
    """Wall time of one stage after the other."""

    def __init__(self) -> None:
        self.laps: dict[str, float] = {}
        self._last = perf_counter()

    def lap(self, stage: str) -> None:
        """The time since the last lap went into `stage`."""
        now = perf_counter()
        self.laps[stage] = now - self._last
        self._last = now


def _fixed(fixed: ArrayLike | None) -> NDArray[np.float64]:
    """Directions that are held."""
    if fixed is None:
        return _NOWHERE
    directions = reals("fixed", fixed, 2)
    kernels.direction_to_uv(directions)  # refuses what is no unit vector
    return directions


def _most_lights(
    lights: int | None, error: float | None, start: str | Rig, held: NDArray[np.float64]
) -> int:
    """How many lights there may be."""
    if error is not None:
        amount("error", error, most=1.0)
    if lights is not None:
        if count("lights", lights) < len(held):
            raise EnvLightsError(
                f"lights must be at least the {len(held)} fixed ones; got {lights}"
            )
        return lights
    if error is not None:
        return max(MOST_LIGHTS, len(held))
    started = len(held) + (len(start.lights) if isinstance(start, Rig) else 0)
    return started or LIGHTS


def _first_directions(start: str | Rig, lights: int, env: EnvMap | None) -> NDArray[np.float64]:
    """Where the first of so many lights start, brightest first."""
    if isinstance(start, Rig):
        return start.lights.direction[:lights]
    check_choice("start", start, STARTS if env is not None else ("greedy", "even"))
    if start == "greedy" or lights == 0:
        return _NOWHERE
    if start == "even":
        # Half a step in, so that none stands on a pole.
        return kernels.uniform_sphere(kernels.hammersley(lights) + np.array([0.5 / lights, 0.0]))
    assert env is not None
    return detect(env, max_lights=lights).direction


class _Answer(NamedTuple):
    """An answer of the kernel in the units of the probe, its lights brightest first."""

    lights: int
    ambient: NDArray[np.float64]
    direction: NDArray[np.float64]
    irradiance: NDArray[np.float64]
    condition: float
    direction_errors: NDArray[np.float64]
    irradiance_errors: NDArray[np.float64]
    error: float
    steps: int
    stop: str

    @classmethod
    def of(cls, raw: FitAnswer, scale: float) -> _Answer:
        """`raw`, which was found on irradiance divided by `scale`."""
        order = np.argsort(-(raw.irradiance @ LUMINANCE), kind="stable")  # as `Lights` has it
        return cls(
            raw.lights,
            raw.ambient * scale,
            raw.directions[order],
            raw.irradiance[order] * scale,
            raw.condition,
            np.array(raw.direction_errors)[order],
            np.reshape(raw.irradiance_errors, (-1, 3))[order] * scale,
            raw.error,
            raw.steps,
            raw.stop,
        )

    def probe(self, normals: NDArray[np.float64]) -> NDArray[np.float64]:
        """Irradiance under the lights."""
        return _native.rig_irradiance(normals, self.ambient, self.direction, self.irradiance)


def _answers(
    samples: Samples,
    judging: Samples,
    error: float | None,
    lights: int,
    ambient: int,
    held: NDArray[np.float64],
    first: NDArray[np.float64],
) -> list[_Answer]:
    """Answers of the kernel with more and more lights, on irradiance brought to about 1.

    The sums are of fourth powers: a map in candela per square metre of the sun would overflow them.
    """
    brightest = float(np.abs(samples.irradiance).max(initial=0.0))
    scale = brightest if 0 < brightest < np.inf else 1.0
    answers = _native.fit_lights(
        samples.scaled(1 / scale),
        (judging.scaled(1 / scale), error),
        ambient,
        (np.concatenate([held, first]), len(held)),
        lights,
        MAX_STEPS,
    )
    return [_Answer.of(answer, scale) for answer in answers]


def _rig(answers: list[_Answer], judging: Samples, started: int) -> Rig:
    """The rig of the answer that is worth its lights.

    It is the last, unless one with fewer lights, but no fewer than had a start, does as well.
    """
    errors = {answer.lights: answer.error for answer in answers}
    last = answers[-1].lights
    enough = min(errors.values()) * (1 + NO_GAIN)
    worth = [n for n, error in errors.items() if error <= enough and n >= min(started, last)]
    used = min(worth, default=last)
    best = next(answer for answer in answers if answer.lights == used)
    ambient = best.ambient if len(best.ambient) == AMBIENTS["sh2"] else best.ambient.sum(axis=0)
    lights = Lights(best.direction, best.irradiance)
    return Rig(ambient, lights, errors[used], _report(best, errors, judging))


def _report(best: _Answer, errors: Mapping[int, float], judging: Samples) -> FitReport:
    """What the numbers say of the answer."""
    difference = best.probe(judging.normals) - judging.irradiance
    weights = judging.weights[:, None]
    left = np.sum(weights * difference**2, axis=0)
    whole = np.sum(weights * judging.irradiance**2, axis=0)
    rms = np.sqrt(whole.sum() / judging.weights.sum() / 3) or 1.0
    return FitReport(
        errors=errors,
        steps=best.steps,
        stop_reason=StopReason[best.stop],
        channel_errors=tuple(np.sqrt(left / np.where(whole > 0, whole, 1.0)).tolist()),
        max_error=float(np.abs(difference).max() / rms),
        condition=best.condition,
        direction_errors=tuple(best.direction_errors.tolist()),
        irradiance_errors=tuple(map(tuple, best.irradiance_errors.tolist())),
    )


def _stop_reason(rig: Rig, error: float | None) -> StopReason:
    if not rig.ambient.any() and not rig.lights.irradiance.any() and rig.error == 0:
        return StopReason.NOTHING_TO_FIT
    if error is not None and rig.error > error:
        return StopReason.ERROR_NOT_REACHED
    return rig.report.stop_reason


def _working_map(env: EnvMap, sources: int) -> tuple[str, ...]:
    if env.width <= kernels.WORKING_COLUMNS:
        return ()
    return (
        f"{env.width}x{env.height} pixels were rendered as a working map of at most"
        f" {kernels.WORKING_COLUMNS} columns and {sources} point sources, which puts a floor of"
        " about 1e-4 under the error",
    )


def _channels(samples: Samples) -> tuple[str, ...]:
    """What a grey or a black channel saved."""
    channels = {channel.tobytes() for channel in samples.irradiance.T}
    fitted = len(channels) - any(not channel.any() for channel in samples.irradiance.T)
    return () if fitted == 3 else (f"{3 - fitted} of 3 channels: black, or the same as another",)


def _counts(rig: Rig, tried: int, most: int, error: float | None) -> tuple[str, ...]:
    """Why there are fewer lights than there may be."""
    used = len(rig.lights)
    if used >= most:
        return ()
    reached = error is not None and rig.error <= error and used == tried
    why = "fewer are good enough" if reached else "they would not lower the error"
    untried = f"; more than {tried} were not tried" if tried < most else ""
    return (f"{most - used} of {most} lights: {why}{untried}",)
