"""What the kernel of the fit answers, and the rig that it makes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._native import FitAnswer
from envlights.fitting.normals import Samples
from envlights.kernels.image import LUMINANCE
from envlights.lights import Lights
from envlights.report import FitReport, StopReason
from envlights.rig import Rig

#: Steps after which the solver gives up on a start; real maps take 5 to 30.
MAX_STEPS = 100

#: A light that lowers the error by less than this share of it does not pay for itself.
NO_GAIN = 1e-3


class Answer(NamedTuple):
    """An answer of the kernel in the units of the probe, its lights brightest first."""

    ambient: NDArray[np.float64]
    direction: NDArray[np.float64]
    irradiance: NDArray[np.float64]
    condition: float
    direction_errors: NDArray[np.float64]
    irradiance_errors: NDArray[np.float64]
    fixed: tuple[int, ...]
    steps: int
    stop: str

    @classmethod
    def of(cls, raw: FitAnswer, scale: float, held: int) -> Answer:
        """`raw`, found on irradiance divided by `scale`; its first `held` lights were fixed."""
        direction, irradiance = raw.directions, raw.irradiance
        order = np.argsort(-(irradiance @ LUMINANCE), kind="stable")  # as `Lights` has it
        condition, direction_errors, irradiance_errors = raw.uncertainty()
        return cls(
            raw.ambient * scale,
            direction[order],
            irradiance[order] * scale,
            condition,
            np.array(direction_errors)[order],
            np.reshape(irradiance_errors, (-1, 3))[order] * scale,
            tuple(np.argsort(order)[:held].tolist()),
            raw.steps,
            raw.stop,
        )

    def probe(self, normals: NDArray[np.float64]) -> NDArray[np.float64]:
        """Irradiance under the lights."""
        return _native.rig_irradiance(normals, self.ambient, self.direction, self.irradiance)


class Answers(NamedTuple):
    """What the kernel found on irradiance divided by `scale`, with more and more lights."""

    found: list[FitAnswer]
    scale: float


def answers(
    samples: Samples,
    judging: Samples,
    error: float | None,
    lights: int,
    ambient: int,
    held: NDArray[np.float64],
    first: NDArray[np.float64],
) -> Answers:
    """Answers of the kernel with more and more lights, on irradiance brought to about 1.

    The sums are of fourth powers: a map in candela per square metre of the sun would overflow them.
    """
    brightest = float(np.abs(samples.irradiance).max(initial=0.0))
    scale = brightest if 0 < brightest < np.inf else 1.0
    found = _native.fit_lights(
        samples.divided_by(scale),
        (judging.divided_by(scale), error),
        ambient,
        (np.concatenate([held, first]), len(held)),
        lights,
        MAX_STEPS,
    )
    return Answers(found, scale)


def rig_of(answers: Answers, judging: Samples, held: int, first: int) -> Rig:
    """The rig of the answer that is worth its lights.

    It is the last, unless one with fewer lights does as well, but no fewer than were `held` or
    came `first`.
    """
    errors = {answer.lights: answer.error for answer in answers.found}
    last = answers.found[-1].lights
    enough = min(errors.values()) * (1 + NO_GAIN)
    worth = [n for n, error in errors.items() if error <= enough and n >= min(held + first, last)]
    used = min(worth, default=last)
    raw = next(answer for answer in answers.found if answer.lights == used)
    best = Answer.of(raw, answers.scale, held)
    ambient = best.ambient if len(best.ambient) > 1 else best.ambient.sum(axis=0)
    lights = Lights(best.direction, best.irradiance)
    return Rig(ambient, lights, errors[used], _report(best, errors, judging, answers.scale))


def _report(best: Answer, errors: Mapping[int, float], judging: Samples, scale: float) -> FitReport:
    """What the numbers say of the answer; squares in units of `scale`, for any brightness."""
    wanted = judging.irradiance / scale
    difference = best.probe(judging.normals) / scale - wanted
    left, whole = (
        np.einsum("n,nc,nc->c", judging.weights, values, values) for values in (difference, wanted)
    )
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
        fixed=best.fixed,
    )


def stop_reason(rig: Rig, error: float | None) -> StopReason:
    """Why there are no more lights, seen from the `error` that was asked for."""
    if not rig.ambient.any() and not rig.lights.irradiance.any() and rig.error == 0:
        return StopReason.NOTHING_TO_FIT
    if error is not None and rig.error > error:
        return StopReason.ERROR_NOT_REACHED
    return rig.report.stop_reason
