"""The kernel's answer, as a rig with its report."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._native import FitAnswer
from envlights.fitting.asked import Asked
from envlights.lights import Lights, brightest_first
from envlights.report import FitReport, StopReason
from envlights.rig import Rig


def rig_of(
    answer: FitAnswer,
    asked: Asked,
    *,
    scale: float = 1.0,
    notes: tuple[str, ...] = (),
    floor: bool = False,
    **told: Any,
) -> Rig:
    """The rig of an `answer` whose irradiance is in units of `scale`.

    Its report holds what the answer knows, and what is `told` beside it.
    """
    irradiance = answer.irradiance * scale
    # Sort once, in the final units: rounding in other units could exchange lights that are alike.
    order = brightest_first(irradiance)
    ambient = answer.ambient * scale
    report = FitReport(
        errors=dict(answer.errors),
        steps=answer.steps,
        stop_reason=_stop_reason(answer, asked),
        channel_errors=tuple(answer.channel_errors),
        max_error=answer.max_error,
        condition=answer.condition,
        direction_errors=_sorted(answer.direction_errors, order),
        irradiance_errors=_sorted_rgb(answer.irradiance_errors, order, scale),
        direction_tolerances=_sorted(answer.tolerances, order),
        fixed=tuple(order.argsort()[: len(asked.fixed)].tolist()) if len(asked.fixed) else (),
        **told,
    )
    radii = np.array(answer.angular_radii)
    return Rig(
        ambient if len(ambient) > 1 else ambient.sum(axis=0),
        Lights.unchecked(answer.directions[order], irradiance[order], radii[order]),
        answer.error,
        report,
        notes,
        floor,
    )


def _sorted(figures: list[float], order: NDArray[np.intp]) -> tuple[float, ...]:
    """A figure for each light, if there are any, in the `order` of the lights."""
    return tuple(figures[light] for light in order) if figures else ()


def _sorted_rgb(
    figures: list[list[float]], order: NDArray[np.intp], scale: float
) -> tuple[tuple[float, float, float], ...]:
    """The same for three figures of each light, in units of `scale`."""
    if not figures:
        return ()
    return tuple((red * scale, g * scale, b * scale) for red, g, b in (figures[i] for i in order))


def _stop_reason(answer: FitAnswer, asked: Asked) -> StopReason:
    """Why there are no more lights, given the errors that were asked for."""
    if answer.error == 0 and not answer.ambient.any() and not answer.irradiance.any():
        return StopReason.NOTHING_TO_FIT
    if asked.has_goal and not asked.is_reached(answer.error, answer.shadow_error):
        return StopReason.ERROR_NOT_REACHED
    return StopReason[answer.stop]
