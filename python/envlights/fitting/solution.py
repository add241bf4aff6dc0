"""The kernel's solutions, and the rig of the one that is worth its lights."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._native import FitAnswer
from envlights.fitting.normals import Samples
from envlights.lights import Lights, brightest_first
from envlights.report import FitReport, StopReason
from envlights.rig import Rig

#: Steps after which the solver gives up on a start; real maps take 5 to 30.
MAX_STEPS = 100

#: A light that lowers the error by less than this share of it does not pay for itself.
NO_GAIN = 1e-3


class Solutions(NamedTuple):
    """A solution for each number of lights, on irradiance divided by `scale`."""

    found: list[FitAnswer]
    scale: float


def solutions(
    fitted: Samples,
    judging: Samples,
    error: float | None,
    lights: int,
    ambient: int,
    fixed: NDArray[np.float64],
    first: NDArray[np.float64],
) -> Solutions:
    """Solutions with more and more lights, up to `lights` or to the `error` that is wanted.

    Of the directions of each, the `fixed` ones come first. The kernel sums fourth powers of
    irradiance, which would overflow for a map in candela per square metre of the sun; so irradiance
    is brought to about 1.
    """
    brightest = float(np.abs(fitted.irradiance).max(initial=0.0))
    scale = brightest if 0 < brightest < np.inf else 1.0
    found = _native.fit_lights(
        fitted.divided_by(scale),
        (judging.divided_by(scale), error),
        ambient,
        (np.concatenate([fixed, first]), len(fixed)),
        lights,
        MAX_STEPS,
    )
    return Solutions(found, scale)


def rig_of(solutions: Solutions, judging: Samples, fixed: int, first: int) -> Rig:
    """The rig of the solution that is worth its lights.

    That is the last, unless one with fewer lights has the same error but for `NO_GAIN`; it has at
    least the `fixed` lights and those that came `first`.
    """
    errors = {each.lights: each.error for each in solutions.found}
    last = solutions.found[-1].lights
    enough = min(errors.values()) * (1 + NO_GAIN)
    worth = [n for n, error in errors.items() if error <= enough and n >= min(fixed + first, last)]
    used = min(worth, default=last)
    best = next(each for each in solutions.found if each.lights == used)
    irradiance = best.irradiance * solutions.scale
    # Sort once, in the final units: rounding in other units could exchange lights that are alike.
    order = brightest_first(irradiance)
    lights = Lights(best.directions[order], irradiance[order])
    ambient = best.ambient * solutions.scale
    ambient = ambient if len(ambient) > 1 else ambient.sum(axis=0)
    rig = Rig(ambient, lights, errors[used])
    channel_errors, max_error = _differences(rig, judging, solutions.scale)
    condition, direction_errors, errors_rgb = best.uncertainty()
    irradiance_errors = np.reshape(errors_rgb, (-1, 3))[order] * solutions.scale
    report = FitReport(
        errors=errors,
        steps=best.steps,
        stop_reason=StopReason[best.stop],
        channel_errors=channel_errors,
        max_error=max_error,
        condition=condition,
        direction_errors=tuple(np.array(direction_errors)[order].tolist()),
        irradiance_errors=tuple(map(tuple, irradiance_errors.tolist())),
        fixed=tuple(np.argsort(order)[:fixed].tolist()),
    )
    return replace(rig, report=report)


def _differences(rig: Rig, judging: Samples, scale: float) -> tuple[tuple[float, ...], float]:
    """Relative RMS error of each channel, and the greatest difference over the RMS irradiance.

    Squares are taken in units of `scale`, so that none overflows.
    """
    wanted = judging.irradiance / scale
    difference = rig.probe(judging.normals) / scale - wanted
    squared_error, square = (
        np.einsum("n,nc,nc->c", judging.weights, values, values) for values in (difference, wanted)
    )
    channel_errors = np.sqrt(squared_error / np.where(square > 0, square, 1.0))
    rms = np.sqrt(square.sum() / judging.weights.sum() / 3) or 1.0
    return tuple(channel_errors.tolist()), float(np.abs(difference).max() / rms)


def stop_reason(rig: Rig, error: float | None) -> StopReason:
    """Why there are no more lights, given the `error` that was asked for."""
    if not rig.ambient.any() and not rig.lights.irradiance.any() and rig.error == 0:
        return StopReason.NOTHING_TO_FIT
    if error is not None and rig.error > error:
        return StopReason.ERROR_NOT_REACHED
    return rig.report.stop_reason
