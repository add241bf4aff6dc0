"""From a map, or from a measured probe, to a rig."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native, kernels
from envlights._check import amount, check_choice, count, reals
from envlights.detect import detect
from envlights.envmap import EnvMap, as_envmap
from envlights.rig import FitReport, Lights, Rig, StopReason

#: Faces of the probe that is fitted (Madsen et al. 2003, section 3.1) and normals that judge it.
FITTED_NORMALS = 320
JUDGING_NORMALS = 5120

#: Where the lights of `fit` may start.
STARTS = ("greedy", "detect", "even")
#: What a fit may use beside the lights.
AMBIENTS = ("constant", "none")
_NO_START = np.zeros((0, 3))

#: Normals, weights and irradiance.
_Samples = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]

#: Lights of a fit that is not told how many, and of one that is told an error.
LIGHTS = 4
MOST_LIGHTS = 32

#: Steps after which the solver gives up on a start; real maps take 5 to 20.
MAX_STEPS = 100


def fit(
    env: EnvMap | ArrayLike,
    lights: int | None = None,
    *,
    error: float | None = None,
    ambient: str = "constant",
    start: str | Rig = "greedy",
) -> Rig:
    """Ambient and a few directional lights that light a white probe as `env` does.

    A white Lambertian probe is rendered under the map at 320 normals. Variable projection with
    non-negative radiances then finds the lights, adding one at a time where it explains most of
    what is left. The error is measured at 5120 other normals.

    Parameters
    ----------
    env : EnvMap or array_like, shape (height, 2 * height, 3)
        The map; an array is taken as `EnvMap` takes it.
    lights : int, optional
        How many directional lights at most, 0 or more. Fewer come back where fewer do as well.
        Left out: 4, or up to 32 where an `error` is asked for.
    error : float, optional
        Relative RMS error that is good enough: the fewest lights that reach it come back, which
        may be none. `report` holds the error for each number that was tried, and says so where
        `lights` were not enough.
    ambient : {"constant", "none"}
        "constant": beside the lights, an environment of one radiance. "none": lights alone.
    start : {"greedy", "detect", "even"} or Rig
        "greedy": each light starts where it explains most of what is left, and again while that
        pays. The others start the lights at given places, from where they go downhill, and add
        those beyond greedily: "detect" at the bright places that `detect` finds, so that each
        stays with its lamp; "even" at points spread over the sphere (Madsen et al. 2003, section
        3.2), which often get stuck; a rig at its own lights, as for the next frame of a video.

    Returns
    -------
    Rig
        Ambient radiance and lights, none negative, with the error and a report.

    Raises
    ------
    EnvLightsError
        If `env` is no map, `lights` no count, `error` no share, or `ambient` or `start` not known.

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
    most = _most_lights(lights, error)
    check_choice("ambient", ambient, AMBIENTS)
    if not isinstance(start, Rig):
        check_choice("start", start, STARTS)
    env = as_envmap(env)
    started = perf_counter()
    fitted, judging = _normals(FITTED_NORMALS), _normals(JUDGING_NORMALS)
    (seen, judged), sources = _both_sides(env, fitted, judging)
    rendered = perf_counter()
    first = _first_directions(env, most, start)
    found = perf_counter()
    goal = None if error is None else ((judging.directions, judging.weights, judged), error)
    problem = fitted.directions, fitted.weights, seen
    answers = _answers(*problem, most, ambient == "constant", first, goal)
    solved = perf_counter()
    errors = [_error(answer, judging.directions, judging.weights, judged) for answer in answers]
    seconds = {
        "probe": rendered - started,
        "start": found - rendered,
        "fit": solved - found,
        "error": perf_counter() - solved,
    }
    measured_on = f"{JUDGING_NORMALS} normals that were not fitted"
    skipped = _skipped(env, sources, len(answers) - 1, most, error)
    rig = _rig(answers, errors, seconds, measured_on, skipped, env.notes)
    if error is not None and rig.error > error:
        report = replace(rig.report, stop_reason=StopReason.ERROR_NOT_REACHED)
        return replace(rig, report=report)
    return rig


def fit_probe(
    normals: ArrayLike,
    irradiance: ArrayLike,
    lights: int = 4,
    *,
    weights: ArrayLike | None = None,
    ambient: str = "constant",
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
    lights : int
        How many directional lights, 0 or more.
    weights : array_like, shape (n,), optional
        Weight of each normal, such as the solid angle it stands for. All alike when left out.
    ambient : {"constant", "none"}
        As for `fit`.

    Returns
    -------
    Rig
        Ambient radiance and lights, none negative, with the error and a report.

    Raises
    ------
    EnvLightsError
        If shapes do not fit, a value is not finite, a normal is no unit vector, or there are fewer
        equations than the 3 + 5 `lights` unknowns.

    Examples
    --------
    >>> from envlights import kernels
    >>> normals, solid_angles = kernels.icosphere(320)
    >>> probe = kernels.rig_irradiance(normals, [0.1, 0.1, 0.1], [[0, 0.6, 0.8]], [[3, 2, 1]])
    >>> rig = fit_probe(normals, probe, lights=1)
    >>> rig.lights.direction.round(6), rig.lights.irradiance.round(6)
    (array([[0. , 0.6, 0.8]]), array([[3., 2., 1.]]))
    """
    count("lights", lights)
    normals, irradiance = reals("normals", normals, 2), reals("irradiance", irradiance, 2)
    check_choice("ambient", ambient, AMBIENTS)
    weights = np.ones(len(normals)) if weights is None else reals("weights", weights, 1)
    started = perf_counter()
    answers = _answers(normals, weights, irradiance, lights, ambient == "constant", _NO_START)
    solved = perf_counter()
    errors = [_error(answer, normals, weights, irradiance) for answer in answers]
    seconds = {"fit": solved - started, "error": perf_counter() - solved}
    measured_on = f"the {len(normals)} fitted normals"
    return _rig(answers, errors, seconds, measured_on, (), ())


class _Normals(NamedTuple):
    """Normals in opposite pairs: the second half of them mirrors the first."""

    directions: NDArray[np.float64]
    weights: NDArray[np.float64]

    @property
    def front(self) -> NDArray[np.float64]:
        """One normal of each pair."""
        return self.directions[: len(self.directions) // 2]


@cache
def _normals(count: int) -> _Normals:
    """The faces of the fitted probe, or even points between them that judge."""
    if count == FITTED_NORMALS:
        faces, solid_angles = kernels.icosphere(count)
        # No face looks along the horizon of this axis, so just one of each pair is in front of it.
        is_front = faces @ (0.8, 0.5, 0.33) > 0
        front, weights = faces[is_front], solid_angles[is_front]
    else:
        front = kernels.uniform_sphere(kernels.hammersley(count // 2) * (0.5, 1.0))
        weights = np.full(count // 2, 4 * np.pi / count)
    return _Normals(np.concatenate([front, -front]), np.concatenate([weights, weights]))


def _both_sides(env: EnvMap, *normals: _Normals) -> tuple[list[NDArray[np.float64]], int]:
    """Irradiance at each set of normals, of which only the front halves are rendered.

    A normal and its opposite see the whole sphere between them, so that
    ``E(n) - E(-n) = n . F`` with the map's vector flux F; the axes tell F in the same way.
    """
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    fronts = [*(some.front for some in normals), axes]
    rendered, sources = kernels.working_irradiance(
        env.radiance, np.concatenate(fronts), border_sampled=env.registration == "border-sampled"
    )
    ends = np.cumsum([len(front) for front in fronts])
    flux = rendered[-6:-3] - rendered[-3:]
    seen = [
        np.concatenate([part, np.maximum(part - some.front @ flux, 0)])
        for some, part in zip(normals, np.split(rendered, ends[:-1]), strict=False)
    ]
    return seen, sources


def _most_lights(lights: int | None, error: float | None) -> int:
    """How many lights there may be."""
    if error is not None:
        amount("error", error, most=1.0)
    if lights is None:
        return LIGHTS if error is None else MOST_LIGHTS
    return count("lights", lights)


def _first_directions(env: EnvMap, lights: int, start: str | Rig) -> NDArray[np.float64]:
    """Where the first lights start, brightest first."""
    if isinstance(start, Rig):
        return start.lights.direction
    if start == "greedy" or lights == 0:
        return _NO_START
    if start == "even":
        # Half a step in, so that none stands on a pole.
        return kernels.uniform_sphere(kernels.hammersley(lights) + np.array([0.5 / lights, 0.0]))
    return detect(env, max_lights=lights).direction


def _answers(
    normals: NDArray[np.float64],
    weights: NDArray[np.float64],
    irradiance: NDArray[np.float64],
    lights: int,
    has_ambient: bool,
    start: NDArray[np.float64],
    goal: tuple[_Samples, float] | None = None,
) -> list[Any]:
    """Best answers of the kernel with 0, 1, ... lights, on irradiance brought to about 1.

    The sums are of fourth powers: a map in candela per square metre of the sun would overflow them.
    """
    brightest = float(np.abs(irradiance).max(initial=0.0))
    scale = brightest if 0 < brightest < np.inf else 1.0
    if goal is not None:
        (judges, judges_weights, judged), error = goal
        goal = (judges, judges_weights, judged / scale), error
    fitted = normals, weights, irradiance / scale
    answers = _native.fit_lights(fitted, start, has_ambient, lights, MAX_STEPS, goal)
    return [
        (np.array(ambient) * scale, directions, strength * scale, *rest)
        for ambient, directions, strength, *rest in answers
    ]


def _error(
    answer: tuple[Any, ...],
    normals: NDArray[np.float64],
    weights: NDArray[np.float64],
    irradiance: NDArray[np.float64],
) -> float:
    ambient, directions, strength, *_ = answer
    seen = kernels.rig_irradiance(normals, ambient, directions, strength)
    return kernels.relative_rms(seen, irradiance, weights)


def _skipped(
    env: EnvMap, sources: int, used: int, lights: int, error: float | None
) -> tuple[str, ...]:
    notes = []
    if env.width > kernels.WORKING_COLUMNS:
        notes.append(
            f"{env.width}x{env.height} pixels were rendered as a working map of at most"
            f" {kernels.WORKING_COLUMNS} columns and {sources} point sources, which puts a floor of"
            " about 1e-4 under the error"
        )
    if used < lights:
        why = "they would not lower the error" if error is None else "fewer are good enough"
        notes.append(f"{lights - used} of {lights} lights: {why}")
    return tuple(notes)


def _rig(
    answers: list[Any],
    errors: list[float],
    seconds: dict[str, float],
    measured_on: str,
    skipped: tuple[str, ...],
    notes: tuple[str, ...],
) -> Rig:
    ambient, directions, irradiance, _, _, stop = answers[-1]
    is_black = not ambient.any() and not len(directions) and errors[-1] == 0
    report = FitReport(
        errors=tuple(errors),
        steps=sum(answer[4] for answer in answers),
        stop_reason=StopReason.NOTHING_TO_FIT if is_black else StopReason[stop],
        seconds=seconds,
        measured_on=measured_on,
        skipped=skipped,
    )
    return Rig(ambient, Lights(directions, irradiance), errors[-1], report, notes)
