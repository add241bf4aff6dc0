"""Fields of a report in JSON, which holds no infinity."""

from __future__ import annotations

import enum
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from envlights._check import amount, check_choice
from envlights._native import EnvLightsError


class StopReason(enum.Enum):
    """Reason why the solver stopped; the value is its text."""

    NOT_FITTED = "not fitted"
    CONVERGED = "converged: the error no longer falls"
    EXACT = "exact: the lights reproduce the irradiance"
    OUT_OF_STEPS = "stopped at the step limit; a better set of lights may exist"
    ERROR_NOT_REACHED = "the requested error was not reached; allow more lights"
    RAN_AWAY = "stopped because the next step is not finite; the lights are those before it"
    NOTHING_TO_FIT = "the map is black, so there is no light to fit"

    @property
    def is_success(self) -> bool:
        """True if more steps would change nothing."""
        successes = (StopReason.CONVERGED, StopReason.EXACT, StopReason.NOTHING_TO_FIT)
        return self in successes


def finite(value: float) -> float | str:
    """`value`, or a word for infinity."""
    return value if np.isfinite(value) else "infinite"


def number(value: float | str) -> float:
    """Number of a file, with "infinite" for infinity."""
    return np.inf if value == "infinite" else amount("report", value)


def optional(name: str, value: float | None) -> float | None:
    """Number of a file, or None."""
    return None if value is None else amount(name, value)


def rgb(values: list[float | str]) -> tuple[float, float, float]:
    """Three numbers of a file."""
    red, green, blue = (number(value) for value in values)
    return red, green, blue


def bands(values: Sequence[Sequence[float]]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Energies by degree of a map and of a difference, or a refusal."""
    rows = [tuple(amount("gloss_bands", value) for value in row) for row in values]
    if len(rows) != 2 or len(rows[0]) != len(rows[1]):
        raise EnvLightsError("gloss_bands must be two lists of the same length")
    return rows[0], rows[1]


def percent(share: float) -> str:
    """Fraction in percent, with three digits."""
    return f"{100 * share:.3g} %"


def degrees(angles: tuple[float, ...]) -> str:
    """Angles in degrees, rounded, for a line of text."""
    rounded = np.degrees(angles)
    return "  ".join(f"{each:.2g}°" if each < 100 else f"{each:.0f}°" for each in rounded)


def search_errors(data: Mapping[str, Any]) -> Mapping[str, float]:
    """Field of a file, which rigs up to version 4 call "errors"."""
    errors: Mapping[str, float] = data["errors" if "errors" in data else "search_errors"]
    return errors


def stop_reason(name: object) -> StopReason:
    """Reason of a file, by its name."""
    check_choice("stop_reason", name, tuple(StopReason.__members__))
    return StopReason[str(name)]


def row_of(report: Any) -> dict[str, Any]:
    """Single numbers and words of the report; NaN for what was not measured."""
    numbers = {
        name: float("nan") if getattr(report, name) is None else getattr(report, name)
        for name in ("shadow_error", "objective_error", "max_error", "points_error")
    }
    gloss_error = report.gloss_error()
    return {
        **numbers,
        "gloss_error": float("nan") if gloss_error is None else gloss_error,
        "ambient": report.ambient,
        "steps": report.steps,
        "stop_reason": report.stop_reason.name,
        "coverage_fraction": report.coverage_fraction,
        "seconds": float(sum(report.seconds.values())),
    }
