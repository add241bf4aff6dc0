"""How a rig was found, and how far it can be trusted."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from envlights._check import amount, check_choice, count


class StopReason(enum.Enum):
    """Why the solver stopped. The text is what a user reads."""

    NOT_FITTED = "not fitted"
    CONVERGED = "the error stopped falling"
    EXACT = "the lights reproduce the probe"
    OUT_OF_STEPS = "the step limit came first; the lights are usable but may not be the best"
    ERROR_NOT_REACHED = "the error asked for was not reached with that many lights"
    RAN_AWAY = "a step led to no finite light; the lights are those before it"
    NOTHING_TO_FIT = "the map is black: there is no light to fit"

    @property
    def is_success(self) -> bool:
        """Whether more steps would change nothing."""
        successes = (StopReason.CONVERGED, StopReason.EXACT, StopReason.NOTHING_TO_FIT)
        return self in successes


@dataclass(frozen=True)
class FitReport:
    """How a rig was found, and how far it can be trusted."""

    errors: Mapping[int, float] = field(default_factory=dict)
    """Relative RMS error for each number of lights that was tried. Where no `error` was asked for,
    only the last number of lights was searched in full; those before it led there."""

    steps: int = 0
    """Steps that the solver took on the way to the answer."""

    stop_reason: StopReason = StopReason.NOT_FITTED
    """Why it took no more steps."""

    seconds: Mapping[str, float] = field(default_factory=dict)
    """Wall time of each stage."""

    measured_on: str = ""
    """The normals on which the errors were measured."""

    channel_errors: tuple[float, ...] = ()
    """Relative RMS error in red, green and blue, each relative to its own irradiance."""

    max_error: float = 0.0
    """Greatest difference at any normal and in any channel, relative to the RMS irradiance, as
    `Rig.error` is."""

    condition: float = 1.0
    """Condition number of the Jacobian, its columns scaled to the same length. Large where
    several unknowns change the probe in almost the same way, infinite where in the same way."""

    direction_errors: tuple[float, ...] = ()
    """Standard error of each light's direction, in radians; 0 where it was fixed."""

    irradiance_errors: tuple[tuple[float, float, float], ...] = ()
    """Standard error of each light's irradiance, RGB; 0 where the bound at zero is active."""

    fixed: tuple[int, ...] = ()
    """Row of each of the `fixed` lights in `Rig.lights`, where the brightest comes first:
    ``rig.lights.irradiance[list(rig.report.fixed)]`` is theirs, in the order they were given."""

    skipped: tuple[str, ...] = ()
    """What was not computed because it was not needed."""

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain numbers, lists and strings."""
        return {
            "errors": {str(lights): error for lights, error in self.errors.items()},
            "steps": self.steps,
            "stop_reason": self.stop_reason.name,
            "seconds": dict(self.seconds),
            "measured_on": self.measured_on,
            "channel_errors": list(self.channel_errors),
            "max_error": self.max_error,
            "condition": _finite(self.condition),
            "direction_errors": [_finite(error) for error in self.direction_errors],
            "irradiance_errors": [[_finite(e) for e in rgb] for rgb in self.irradiance_errors],
            "fixed": list(self.fixed),
            "skipped": list(self.skipped),
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> FitReport:
        """The report that `to_dict` wrote."""
        return cls(
            errors={int(n): amount("errors", error) for n, error in data["errors"].items()},
            steps=count("steps", data["steps"]),
            stop_reason=_stop_reason(data["stop_reason"]),
            seconds={str(stage): amount("seconds", s) for stage, s in data["seconds"].items()},
            measured_on=str(data["measured_on"]),
            channel_errors=tuple(amount("channel_errors", e) for e in data["channel_errors"]),
            max_error=amount("max_error", data["max_error"]),
            condition=_number(data["condition"]),
            direction_errors=tuple(_number(error) for error in data["direction_errors"]),
            irradiance_errors=tuple(_rgb(rgb) for rgb in data["irradiance_errors"]),
            fixed=tuple(count("fixed", row) for row in data.get("fixed", ())),
            skipped=tuple(str(note) for note in data["skipped"]),
        )

    def __str__(self) -> str:
        curve = "  ".join(f"{lights}: {100 * error:.3g} %" for lights, error in self.errors.items())
        angles = "  ".join(f"{np.degrees(error):.2g}°" for error in self.direction_errors)
        steps = f"{self.steps} steps; " if self.steps else ""
        lines = [
            f"error by number of lights: {curve}" if curve else "",
            f"measured on {self.measured_on}" if self.measured_on else "",
            *self._by_channel(),
            f"standard error of the directions: {angles}" if angles else "",
            f"{steps}{self.stop_reason.value}",
            *(f"skipped: {note}" for note in self.skipped),
        ]
        return "\n".join(line for line in lines if line)

    def _by_channel(self) -> tuple[str, ...]:
        if not self.channel_errors:
            return ()
        channels = "  ".join(f"{100 * error:.3g} %" for error in self.channel_errors)
        return (
            f"red, green, blue: {channels}; at most {100 * self.max_error:.3g} % at any normal",
            f"condition number {self.condition:.3g}",
        )


def _finite(value: float) -> float | str:
    """`value`, or a word for infinity, which JSON does not have."""
    return value if np.isfinite(value) else "infinite"


def _stop_reason(name: object) -> StopReason:
    check_choice("stop_reason", name, tuple(StopReason.__members__))
    return StopReason[str(name)]


def _number(value: float | str) -> float:
    return np.inf if value == "infinite" else amount("report", value)


def _rgb(values: list[float | str]) -> tuple[float, float, float]:
    red, green, blue = (_number(value) for value in values)
    return red, green, blue
