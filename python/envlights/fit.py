"""From a map, or from a measured probe, to a rig."""

from __future__ import annotations

from functools import cache
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native, kernels
from envlights._check import check_choice, count, reals
from envlights.detect import detect
from envlights.envmap import EnvMap, as_envmap
from envlights.rig import FitReport, Lights, Rig, StopReason

#: Faces of the probe that is fitted (Madsen et al. 2003, section 3.1) and normals that judge it.
FITTED_NORMALS = 320
JUDGING_NORMALS = 5120

#: Where the lights of `fit` may start.
STARTS = ("greedy", "detect")
_NO_START = np.zeros((0, 3))

#: Steps after which the solver gives up on a start; real maps take 5 to 20.
MAX_STEPS = 100


def fit(env: EnvMap | ArrayLike, lights: int = 4, *, start: str = "greedy") -> Rig:
    """Ambient and at most `lights` directional lights that light a white probe as `env` does.

    A white Lambertian probe is rendered under the map at 320 normals. Variable projection with
    non-negative radiances then finds the lights, adding one at a time where it explains most of
    what is left. The error is measured at 5120 other normals.

    Parameters
    ----------
    env : EnvMap or array_like, shape (height, 2 * height, 3)
        The map; an array is taken as `EnvMap` takes it.
    lights : int
        How many directional lights, 0 or more. Fewer come back where fewer do as well.
    start : {"greedy", "detect"}
        "greedy": each light starts where it explains most of what is left, and again while that
        pays. "detect": the lights start at the bright places that `detect` finds, and go downhill
        from there, so that each stays with its lamp; those beyond are greedy. The error is
        rarely lower.

    Returns
    -------
    Rig
        Ambient radiance and lights, none negative, with the error and a report.

    Raises
    ------
    EnvLightsError
        If `env` is no map, `lights` no count or `start` not known.

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
    count("lights", lights)
    check_choice("start", start, STARTS)
    env = as_envmap(env)
    started = perf_counter()
    fitted, judging = _normals(FITTED_NORMALS), _normals(JUDGING_NORMALS)
    (seen, judged), sources = _both_sides(env, fitted, judging)
    rendered = perf_counter()
    first = _first_directions(env, lights, start)
    found = perf_counter()
    answers = _answers(fitted.directions, fitted.weights, seen, lights, first)
    solved = perf_counter()
    errors = [_error(answer, judging.directions, judging.weights, judged) for answer in answers]
    seconds = {
        "probe": rendered - started,
        "start": found - rendered,
        "fit": solved - found,
        "error": perf_counter() - solved,
    }
    measured_on = f"{JUDGING_NORMALS} normals that were not fitted"
    skipped = _skipped(env, sources, len(answers) - 1, lights)
    return _rig(answers, errors, seconds, measured_on, skipped, env.notes)


def fit_probe(
    normals: ArrayLike,
    irradiance: ArrayLike,
    lights: int = 4,
    *,
    weights: ArrayLike | None = None,
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
    weights = np.ones(len(normals)) if weights is None else reals("weights", weights, 1)
    started = perf_counter()
    answers = _answers(normals, weights, irradiance, lights, _NO_START)
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


def _first_directions(env: EnvMap, lights: int, start: str) -> NDArray[np.float64]:
    """Where the first lights start, brightest first."""
    if start == "greedy" or lights == 0:
        return _NO_START
    return detect(env, max_lights=lights).direction


def _answers(
    normals: NDArray[np.float64],
    weights: NDArray[np.float64],
    irradiance: NDArray[np.float64],
    lights: int,
    start: NDArray[np.float64],
) -> list[Any]:
    """Best answers of the kernel with 0, 1, ... lights, on irradiance brought to about 1.

    The sums are of fourth powers: a map in candela per square metre of the sun would overflow them.
    """
    brightest = float(np.abs(irradiance).max(initial=0.0))
    scale = brightest if 0 < brightest < np.inf else 1.0
    answers = _native.fit_lights(normals, weights, irradiance / scale, start, lights, MAX_STEPS)
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


def _skipped(env: EnvMap, sources: int, used: int, lights: int) -> tuple[str, ...]:
    notes = []
    if env.width > kernels.WORKING_COLUMNS:
        notes.append(
            f"{env.width}x{env.height} pixels were rendered as a working map of at most"
            f" {kernels.WORKING_COLUMNS} columns and {sources} point sources, which puts a floor of"
            " about 1e-4 under the error"
        )
    if used < lights:
        notes.append(f"{lights - used} of {lights} lights: they would not lower the error")
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
