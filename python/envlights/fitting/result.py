"""Rig and report from the result of a kernel."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.units import OWN_SCALE
from envlights._native import FitAnswer
from envlights.fitting.request import Request
from envlights.rigs.lights import Lights, brightest_first
from envlights.rigs.report import FitReport, StopReason
from envlights.rigs.rig import Rig


def rig_of(
    answer: FitAnswer,
    request: Request,
    *,
    scale: float = 1.0,
    notes: tuple[str, ...] = (),
    units: str = OWN_SCALE,
    floor: bool = False,
    has_max_radius: bool = False,
    **report_fields: Any,
) -> Rig:
    """Rig from a kernel result, whose irradiance is in units of `scale`.

    `report_fields` are the fields of the report that the answer does not hold.
    """
    irradiance = answer.irradiance * scale
    # Sort in final units, because rounding could swap nearly equal lights in other units.
    order = brightest_first(irradiance)
    ambient = answer.ambient * scale
    report = FitReport(
        search_errors=dict(answer.errors),
        steps=answer.steps,
        stop_reason=_stop_reason(answer, request),
        channel_errors=tuple(answer.channel_errors),
        objective_error=answer.objective_error,
        points_error=answer.points_error,
        fitted_points_error=answer.fitted_points_error,
        condition=answer.condition,
        direction_errors=_reorder(answer.direction_errors, order),
        irradiance_errors=_reorder_rgb(answer.irradiance_errors, order, scale),
        direction_tolerances=_reorder(answer.tolerances, order),
        at_max_radius=_rows(answer.at_bound, order) if has_max_radius else (),
        fixed=tuple(order.argsort()[: len(request.fixed)].tolist()) if len(request.fixed) else (),
        **_on_demand(answer),
        **report_fields,
    )
    radii = np.array(answer.angular_radii)
    return Rig(
        ambient if len(ambient) > 1 else ambient.sum(axis=0),
        Lights.unchecked(answer.directions[order], irradiance[order], radii[order], units),
        answer.error,
        report,
        notes,
        floor,
    )


def _on_demand(answer: FitAnswer) -> dict[str, Any]:
    """Report fields that take as long to compute as a fit, as functions of the reduced map."""

    def gloss_bands() -> tuple[tuple[float, ...], ...]:
        return tuple(map(tuple, answer.bands))

    return {"max_error": lambda: answer.max_error, "gloss_bands": gloss_bands}


def _rows(lights: list[int], order: NDArray[np.intp]) -> tuple[int, ...]:
    return tuple(sorted(order.argsort()[lights].tolist()))


def _reorder(values: list[float], order: NDArray[np.intp]) -> tuple[float, ...]:
    """Per-light values in the new `order` of the lights; empty if there are none."""
    return tuple(values[light] for light in order) if values else ()


def _reorder_rgb(
    values: list[list[float]], order: NDArray[np.intp], scale: float
) -> tuple[tuple[float, float, float], ...]:
    """Per-light RGB values times `scale`, in the new `order` of the lights."""
    if not values:
        return ()
    return tuple((red * scale, g * scale, b * scale) for red, g, b in (values[i] for i in order))


def _stop_reason(answer: FitAnswer, request: Request) -> StopReason:
    """Reason why the fit stopped, considering the requested errors."""
    if answer.error == 0 and not answer.ambient.any() and not answer.irradiance.any():
        return StopReason.NOTHING_TO_FIT
    if request.has_goal and not request.is_reached(answer):
        return StopReason.ERROR_NOT_REACHED
    return StopReason[answer.stop]
