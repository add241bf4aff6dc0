"""What a report says in words: where the error was measured, and what was not computed."""

from __future__ import annotations

from envlights._native import FitAnswer
from envlights.envmap import EnvMap
from envlights.fitting.asked import Asked
from envlights.kernels.probe import WORKING_COLUMNS


def measured_on(count: int, floor: bool) -> str:
    """The normals on which the error was measured."""
    return f"{count} normals over a floor" if floor else f"{count} normals"


def working_map(env: EnvMap, points: int, rendering_error: float) -> tuple[str, ...]:
    """A note where the map was reduced."""
    if env.width <= WORKING_COLUMNS:
        return ()
    return (
        f"{env.width}x{env.height} pixels were rendered as a working map of at most"
        f" {WORKING_COLUMNS} columns, its brightest cells ({points}) as points, whose own error is"
        f" about {rendering_error:.0e}",
    )


def channels(answer: FitAnswer) -> tuple[str, ...]:
    """A note where channels are black or equal, and so were not fitted one by one."""
    left_out = 3 - answer.channels
    return (f"{left_out} of 3 channels: black, or the same as another",) if left_out else ()


def fewer_lights(answer: FitAnswer, wanted: Asked, rendering_error: float) -> tuple[str, ...]:
    """Why there are fewer lights than there may be."""
    used, most = answer.lights, wanted.lights
    if used >= most:
        return ()
    tried = max(lights for lights, _ in answer.errors)
    if wanted.is_reached(answer.error, answer.shadow_error):
        why = "fewer are good enough"
    elif answer.error <= rendering_error:
        why = f"the error is below that of rendering, {rendering_error:.0e}"
    else:
        why = "they would not lower the error"
    untried = f"; more than {tried} were not tried" if tried < most else ""
    return (f"{most - used} of {most} lights: {why}{untried}",)


def clipping(env: EnvMap) -> tuple[str, ...]:
    """What a rig of this map rests on, where some of it was cut off; empty where none was.

    Maps without a white are not looked through: that would take a third of the time of a fit.
    `EnvMap.clipped_flux_share` does so when it is asked.
    """
    share = 0.0 if env.white is None else env.clipped_flux_share
    if not share:
        return ()
    lost = f"{100 * share:.2g} % of the map's flux lies in clipped pixels"
    return (f"{lost}: the lights there are a lower bound",)
