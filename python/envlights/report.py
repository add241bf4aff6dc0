"""How a rig was found, and how far it can be trusted."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from envlights import _html
from envlights._check import amount, check_choice, count
from envlights._result import Result
from envlights._tables import Table


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


@dataclass(frozen=True, eq=False, repr=False)
class FitReport(Result):
    """How a rig was found, and how far it can be trusted."""

    errors: Mapping[int, float] = field(default_factory=dict)
    """Relative RMS error for each number of lights that was tried. Where no error was asked for,
    all of these are points, and only the last number was searched in full; see `sized_error`."""

    sized_error: float | None = None
    """Relative RMS error of the rig, whose lights have sizes, where `errors` are those of points.
    None where both are of the same kind."""

    steps: int = 0
    """Steps that the solver took on the way to the answer."""

    stop_reason: StopReason = StopReason.NOT_FITTED
    """Why it took no more steps."""

    seconds: Mapping[str, float] = field(default_factory=dict, compare=False)
    """Wall time of each stage."""

    measured_on: str = ""
    """The normals on which the errors were measured, and whether over a floor."""

    ambient: str = ""
    """The environment beside the lights: "none", "constant" or "sh2"."""

    ambients: Mapping[str, tuple[int, float]] = field(default_factory=dict)
    """Where ``ambient="auto"`` chose: lights and error with each that was tried."""

    channel_errors: tuple[float, ...] = ()
    """Relative RMS error in red, green and blue, each relative to its own irradiance."""

    max_error: float = 0.0
    """Greatest difference at the judged normals (5120 or more of a map) and in any channel,
    relative to the RMS irradiance, as `Rig.error` is. Between them it was up to a fifth greater."""

    shadow_error: float | None = None
    """Relative RMS error where things stand in the way: of the irradiance at every normal, with all
    hidden that lies behind a plane, over all planes; each pixel of the map is a square of one
    radiance. None where it was not measured."""

    direction_tolerances: tuple[float, ...] = ()
    """For a map: how far each light may stand elsewhere, in radians and in whichever direction
    matters least, before the error grows by a tenth, all else fitted anew. 0 where the light was
    fixed, pi where nothing holds it. To second order: where a tolerance is more than some 20
    degrees, it is the order of magnitude that counts."""

    condition: float = 1.0
    """For a measured probe: condition number of the Jacobian, its columns scaled to the same
    length. Large where several unknowns change the probe in almost the same way, infinite where in
    the same way."""

    direction_errors: tuple[float, ...] = ()
    """For a measured probe: standard error of each light's direction, in radians; 0 where it was
    fixed, infinite where `condition` is. A map has no noise, so it has no standard errors."""

    irradiance_errors: tuple[tuple[float, float, float], ...] = ()
    """For a measured probe: standard error of each light's irradiance, RGB; 0 where the bound at
    zero is active, infinite where `condition` is."""

    fixed: tuple[int, ...] = ()
    """Row of each of the `fixed` lights in `Rig.lights`, where the brightest comes first:
    ``rig.lights.irradiance[list(rig.report.fixed)]`` is theirs, in the order they were given."""

    skipped: tuple[str, ...] = ()
    """What was not computed because it was not needed."""

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain numbers, lists and strings."""
        return {
            "errors": {str(lights): error for lights, error in self.errors.items()},
            "sized_error": self.sized_error,
            "steps": self.steps,
            "stop_reason": self.stop_reason.name,
            "seconds": dict(self.seconds),
            "measured_on": self.measured_on,
            "ambient": self.ambient,
            "ambients": {
                name: {"lights": lights, "error": error}
                for name, (lights, error) in self.ambients.items()
            },
            "channel_errors": list(self.channel_errors),
            "max_error": self.max_error,
            "shadow_error": self.shadow_error,
            "direction_tolerances": list(self.direction_tolerances),
            "condition": _finite(self.condition),
            "direction_errors": [_finite(error) for error in self.direction_errors],
            "irradiance_errors": [[_finite(e) for e in rgb] for rgb in self.irradiance_errors],
            "fixed": list(self.fixed),
            "skipped": list(self.skipped),
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> FitReport:
        """The report that `to_dict` wrote; what older versions did not write is left out."""
        return cls(
            errors={int(n): amount("errors", error) for n, error in data["errors"].items()},
            sized_error=_optional("sized_error", data.get("sized_error")),
            steps=count("steps", data["steps"]),
            stop_reason=_stop_reason(data["stop_reason"]),
            seconds={str(stage): amount("seconds", s) for stage, s in data["seconds"].items()},
            measured_on=str(data["measured_on"]),
            ambient=str(data.get("ambient", "")),
            ambients={
                str(name): (count("lights", tried["lights"]), amount("error", tried["error"]))
                for name, tried in data.get("ambients", {}).items()
            },
            channel_errors=tuple(amount("channel_errors", e) for e in data["channel_errors"]),
            max_error=amount("max_error", data["max_error"]),
            shadow_error=_optional("shadow_error", data.get("shadow_error")),
            direction_tolerances=tuple(
                amount("direction_tolerances", t) for t in data.get("direction_tolerances", ())
            ),
            condition=_number(data["condition"]),
            direction_errors=tuple(_number(error) for error in data["direction_errors"]),
            irradiance_errors=tuple(_rgb(rgb) for rgb in data["irradiance_errors"]),
            fixed=tuple(count("fixed", row) for row in data.get("fixed", ())),
            skipped=tuple(str(note) for note in data["skipped"]),
        )

    def in_short(self) -> str:
        """The error of the last number of lights that was tried, and why the solver stopped."""
        if not self.errors:
            return self.stop_reason.value
        lights, error = list(self.errors.items())[-1]
        error = error if self.sized_error is None else self.sized_error
        plural = "" if lights == 1 else "s"
        return f"{lights} light{plural}, {_percent(error)}; {self.stop_reason.value}"

    def __str__(self) -> str:
        return "\n".join(filter(None, [self._by_number(), *self._lines()]))

    def _html_parts(self) -> tuple[str, ...]:
        has_sizes = self.sized_error is not None
        columns = ["lights", *map(str, self.errors), *(["with sizes"] if has_sizes else [])]
        each = [
            *self.errors.values(),
            *([self.sized_error] if self.sized_error is not None else []),
        ]
        curve = Table(columns, [["error", *map(_percent, each)]]).html() if self.errors else ""
        return curve, _html.lines("\n".join(self._lines()))

    def _lines(self) -> list[str]:
        steps = f"{self.steps} steps; " if self.steps else ""
        lines = [
            f"measured on {self.measured_on}" if self.measured_on else "",
            *self._by_channel(),
            self.with_shadows(),
            *self._choice(),
            *self._determined(),
            f"{steps}{self.stop_reason.value}",
            *(f"skipped: {note}" for note in self.skipped),
        ]
        return [line for line in lines if line]

    def with_shadows(self) -> str:
        """The error with shadows in words; nothing where it was not measured."""
        return "" if self.shadow_error is None else f"with shadows {_percent(self.shadow_error)}"

    def _by_number(self) -> str:
        """The error of each number of lights, and of the sizes that the last of them got."""
        if not self.errors:
            return ""
        curve = "  ".join(f"{lights}: {_percent(error)}" for lights, error in self.errors.items())
        if self.sized_error is None:
            return f"error by number of lights: {curve}"
        sized = _percent(self.sized_error)
        return f"error by number of lights without sizes: {curve}; with sizes: {sized}"

    def _by_channel(self) -> tuple[str, ...]:
        if not self.channel_errors:
            return ()
        channels = "  ".join(_percent(error) for error in self.channel_errors)
        worst = f"at most {_percent(self.max_error)} at the judged normals"
        return (f"red, green, blue: {channels}; {worst}",)

    def _choice(self) -> tuple[str, ...]:
        """The ambient term that was chosen, and the figures of each."""
        if not self.ambients:
            return ()
        tried = "  ".join(
            f"{name}: {lights} light{'' if lights == 1 else 's'}, {_percent(error)}"
            for name, (lights, error) in self.ambients.items()
        )
        return (f"ambient chosen: {self.ambient}, of  {tried}",)

    def _determined(self) -> tuple[str, ...]:
        """How far the lights are determined."""
        if self.direction_tolerances:
            angles = _degrees(self.direction_tolerances)
            each = "each light may stand this far off before the error grows by a tenth"
            return (f"{each}: {angles}",)
        if self.direction_errors:
            return (
                f"condition number {self.condition:.3g}",
                f"standard error of the directions: {_degrees(self.direction_errors)}",
            )
        return ()


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %"


def _degrees(angles: tuple[float, ...]) -> str:
    degrees = np.degrees(angles)
    return "  ".join(f"{each:.2g}°" if each < 100 else f"{each:.0f}°" for each in degrees)


def _finite(value: float) -> float | str:
    """`value`, or a word for infinity, which JSON does not have."""
    return value if np.isfinite(value) else "infinite"


def _stop_reason(name: object) -> StopReason:
    check_choice("stop_reason", name, tuple(StopReason.__members__))
    return StopReason[str(name)]


def _optional(name: str, value: float | None) -> float | None:
    return None if value is None else amount(name, value)


def _number(value: float | str) -> float:
    return np.inf if value == "infinite" else amount("report", value)


def _rgb(values: list[float | str]) -> tuple[float, float, float]:
    red, green, blue = (_number(value) for value in values)
    return red, green, blue
