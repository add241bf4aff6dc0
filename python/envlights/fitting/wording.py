"""Sentences for reports and notes of a fit."""

from __future__ import annotations

from envlights._common.words import percent
from envlights._native import FitAnswer
from envlights.fitting.request import Request
from envlights.kernels.probe import WORKING_COLUMNS


def measured_on(count: int | str, floor: bool) -> str:
    """Normals at which the error was measured, as text."""
    return f"{count} normals over a floor" if floor else f"{count} normals"


def working_map(width: int, points: int, rendering_error: float) -> tuple[str, ...]:
    """Note on a map of this width that was reduced for the fit."""
    if width <= WORKING_COLUMNS:
        return ()
    cells = f", {points} bright cell{'' if points == 1 else 's'} kept exact" if points else ""
    return (
        f"fitted on the map reduced to {WORKING_COLUMNS} columns{cells}"
        f" (adds about {_power(rendering_error)} to the error)",
    )


def channels(answer: FitAnswer) -> tuple[str, ...]:
    """Note on channels that are skipped because they are black or equal to another."""
    skipped = 3 - answer.channels
    return (f"{skipped} of 3 channels skipped: black or equal to another",) if skipped else ()


def fewer_lights(answer: FitAnswer, request: Request, rendering_error: float) -> str:
    """Reason why fewer lights are used than allowed; empty if all are used."""
    used, most = answer.lights, request.lights
    if used >= most:
        return ""
    if request.is_reached(answer):
        why = "the requested error is reached"
    elif answer.error <= rendering_error:
        why = f"the error is already {_below(rendering_error)}"
    else:
        why = "more would not lower the error"
    lights = "light" if most == 1 else "lights"
    return f"{used} of at most {most} {lights} used: {why}"


def clipping(fraction: float) -> tuple[str, ...]:
    """Note on clipped pixels with this fraction of the flux; empty if there are none."""
    if not fraction:
        return ()
    return (
        f"clipped pixels hold {percent(fraction, 2)} of the map's flux,"
        " so the lights there are a lower bound",
    )


def _below(rendering_error: float) -> str:
    if not rendering_error:
        return "0"
    return f"below {_power(rendering_error)}, the accuracy of the fit"


def _power(value: float) -> str:
    """Small number with one digit, such as 1e-4."""
    digits, exponent = f"{value:.0e}".split("e")
    return f"{digits}e{int(exponent)}"
