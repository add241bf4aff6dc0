"""Report of a fit: the search, its errors, and the accuracy of the lights."""

from __future__ import annotations

import enum
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from envlights._common.fields import fields_of, on_demand, read_fields, value_or_function
from envlights._common.result import Result
from envlights._common.tables import frame_of
from envlights._common.times import time_lines
from envlights._common.words import percent, quantity
from envlights._native import EnvLightsError
from envlights.kernels import gloss

if TYPE_CHECKING:
    import pandas as pd


#: Roughness of the metal in the text of a report: the matte silver of published comparisons.
SHOWN_ROUGHNESS = 0.33


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


@dataclass(frozen=True, eq=False, repr=False)
class FitReport(Result):
    """Report of a fit: the search, its errors, and the accuracy of the lights.

    `str` gives the part for users; `verbose` gives everything.
    """

    search_errors: Mapping[int, float] = field(default_factory=dict)
    """Relative RMS error of the sets that the search passed, by their number of lights.

    Without a requested error, these lights are points, and only the last number was searched in
    full; see `sized_error`. `error_curve` compares full fits."""

    sized_error: float | None = None
    """Relative RMS error of the rig, if its lights have sizes and those of the search
    have none."""

    steps: int = 0
    """Number of steps of the solver."""

    stop_reason: StopReason = StopReason.NOT_FITTED
    """Reason why the solver stopped."""

    seconds: Mapping[str, float] = field(default_factory=dict, compare=False)
    """Wall time of each stage."""

    measured_on: str = ""
    """Normals on which the errors were measured, and the floor if there is one."""

    ambient: str = ""
    """Ambient term: "none", "constant" or "sh2"."""

    ambients: Mapping[str, tuple[int, float]] = field(default_factory=dict)
    """Lights and error with each ambient term that ``ambient="auto"`` compared."""

    channel_errors: tuple[float, ...] = ()
    """Relative RMS error in red, green and blue, each relative to its own irradiance."""

    max_error: float = on_demand(0.0)
    """Largest error of any channel at the measured normals, relative to the RMS irradiance.

    A map is measured at 5120 normals when this is first read. Normals whose horizon cuts a small
    sun have larger errors: on 100 generated maps, the largest error of others was 1.02 times as
    large in the median, at most 1.6 times on 90 of them, and up to 3.5 times."""

    shadow_error: float | None = None
    """Relative RMS error of shadowed irradiance, or None if it was not measured.

    It is the error of the irradiance at every normal with everything behind a plane hidden,
    integrated over all planes. Each pixel of the map is a square of one radiance. Below 0.5 % it is
    exact to 6 % of itself."""

    objective_error: float | None = None
    """Relative RMS error that the fit minimised: of its `objective`, or `Rig.error` of points.

    None if it was not measured, or if a sun was put beside the fitted lights."""

    gloss_bands: tuple[tuple[float, ...], tuple[float, ...]] = on_demand(((), ()))
    """Energy of the map in each degree of spherical harmonics, and of its difference from the rig.

    All channels are summed. Both are empty if there was no map; see `gloss_error`. They are
    computed when they are first read."""

    points_error: float | None = None
    """Relative RMS error of the rig in a target that shows its lights as points."""

    fitted_points_error: float | None = None
    """Relative RMS error of as many lights fitted as points, with the same ambient term."""

    target: tuple[str, ...] = ()
    """Names of the targets that the rig was fitted for; see `el.export.TARGETS`."""

    direction_tolerances: tuple[float, ...] = ()
    """Radians by which each light of a map can move before the error grows by 10 %.

    The light moves in the direction that raises the error least, and all else is fitted again. The
    tolerance is 0 for a fixed light, and pi if the map does not determine the direction. It uses
    second derivatives: above about 20 degrees, only its order of magnitude is meaningful."""

    condition: float = 1.0
    """Condition number of the Jacobian of a measured probe, with columns of equal length.

    It is large if the columns are almost linearly dependent, and infinite if they are dependent."""

    direction_errors: tuple[float, ...] = ()
    """Standard error of each light's direction under a measured probe, in radians.

    0 for a fixed light, infinite if `condition` is. A map has no noise, so it has no standard
    errors."""

    irradiance_errors: tuple[tuple[float, float, float], ...] = ()
    """Standard error of each light's irradiance under a measured probe, RGB.

    0 where the bound at zero is active, infinite if `condition` is."""

    fixed: tuple[int, ...] = ()
    """Row of each `fixed` light in `Rig.lights`, where the brightest comes first.

    ``rig.lights.irradiance[list(rig.report.fixed)]`` has the order of the argument."""

    at_max_radius: tuple[int, ...] = ()
    """Row of each light in `Rig.lights` that the `max_radius` of the fit keeps from being wider.

    Its radius may be smaller by the blur of a pixel. Empty without a `max_radius`."""

    fewer_lights: str = ""
    """Reason why there are fewer lights than allowed; empty if there are not."""

    coverage_fraction: float = 1.0
    """Fraction of the sphere that the map shows; over a floor, of its upper half."""

    unseen_spread: float = 0.0
    """Relative RMS difference of the probe between a black and a harmonic fill of the unseen part.

    It is the order of magnitude by which the unseen part may change the probe, but an unseen sun
    changes it more."""

    skipped: tuple[str, ...] = ()
    """Remarks on work that was not necessary."""

    def __post_init__(self) -> None:
        bands = value_or_function(self, "gloss_bands")
        if not callable(bands) and len(bands[0]) != len(bands[1]):
            raise EnvLightsError("gloss_bands must be two lists of the same length")

    def to_dict(self) -> dict[str, Any]:
        """All fields except the times as plain numbers, lists and strings."""
        ambients = {
            name: {"lights": lights, "error": error}
            for name, (lights, error) in self.ambients.items()
        }
        return {**fields_of(self), "ambients": ambients, "gloss_error": self.gloss_error()}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> FitReport:
        """Report that `to_dict` wrote; fields that an older version did not write get defaults."""
        ambients = {
            name: (one["lights"], one["error"]) for name, one in data.get("ambients", {}).items()
        }
        # Rigs up to version 4 call the first field "errors", and version 2 has wall times.
        former = {"search_errors": data["errors"]} if "errors" in data else {}
        return read_fields(cls, {**data, **former, "ambients": ambients})

    def row(self) -> dict[str, Any]:
        """Single numbers and words of the report; NaN for what was not measured."""
        numbers = {
            "shadow_error": self.shadow_error,
            "objective_error": self.objective_error,
            "max_error": self.max_error,
            "points_error": self.points_error,
            "gloss_error": self.gloss_error(),
        }
        return {
            **{name: np.nan if value is None else value for name, value in numbers.items()},
            "ambient": self.ambient,
            "steps": self.steps,
            "stop_reason": self.stop_reason.name,
            "coverage_fraction": self.coverage_fraction,
            "seconds": float(sum(self.seconds.values())),
        }

    def to_frame(self) -> pd.DataFrame:
        """Data frame with one row of the errors and the choices of the fit; needs pandas."""
        return frame_of({name: np.array([value]) for name, value in self.row().items()})

    def gloss_error(
        self, roughness: float = SHOWN_ROUGHNESS, material: str = "metal"
    ) -> float | None:
        r"""Relative RMS error of images of a shiny ball under the rig, from all sides.

        With the energies :math:`D_l` and :math:`L_l` in `gloss_bands` and the factors
        :math:`\lambda_l` of `kernels.gloss.spectrum`, it is
        :math:`\sqrt{\sum_l \lambda_l D_l / \sum_l \lambda_l L_l}`.

        Parameters
        ----------
        roughness : float
            Roughness of the ball, from 0.3 to 1.
        material : {"metal", "plastic"}
            Metal, or a coat over a base of reflectance 0.5.

        Returns
        -------
        float or None
            None if there was no map.

        Raises
        ------
        EnvLightsError
            If the roughness is out of range or `material` is unknown.

        Examples
        --------
        >>> import envlights as el
        >>> report = el.fit(el.synthetic.hall(64).radiance, lights=4).report
        >>> report.gloss_error(0.5) < report.gloss_error(0.33)
        True
        """
        return gloss.error(self.gloss_bands, gloss.checked_roughness(roughness), material)

    @property
    def errors(self) -> Mapping[int, float]:
        """Old name of `search_errors`."""
        warnings.warn(
            "FitReport.errors is now FitReport.search_errors: errors of points that the search"
            " tried; el.error_curve compares full fits",
            DeprecationWarning,
            stacklevel=2,
        )
        return self.search_errors

    def in_short(self) -> str:
        """Number of lights, error, and reason why the solver stopped."""
        if not self.search_errors:
            return self.stop_reason.value
        lights, error = list(self.search_errors.items())[-1]
        error = error if self.sized_error is None else self.sized_error
        return f"{quantity(lights, 'light')}, {percent(error)}; {self.stop_reason.value}"

    def _lines(self) -> list[str]:
        """Error of each number of lights, and lines for users."""
        # A rig shows the stop reason of its fit itself.
        unfitted = "" if self.search_errors else self.stop_reason.value
        made_for = f"fitted for {', '.join(self.target)}" if self.target else ""
        lines = [made_for, self._radius_bound(), self._unseen(), self.fewer_lights, unfitted]
        return [line for line in (self._by_number(), *self._choice(), *lines) if line]

    def _details(self) -> list[str]:
        """Lines for developers."""
        lines = [
            f"errors measured at {self.measured_on}" if self.measured_on else "",
            *self._by_channel(),
            f"error {self.with_shadows()}" if self.with_shadows() else "",
            f"error {self.with_gloss()}" if self.with_gloss() else "",
            *self._accuracy(),
            f"{self.steps} steps of the solver" if self.steps else "",
            self.stop_reason.value if self.search_errors else "",
            *self.skipped,
            *time_lines(self.seconds),
        ]
        return [line for line in lines if line]

    def with_shadows(self) -> str:
        """Error with shadows in words; empty if it was not measured."""
        return "" if self.shadow_error is None else f"with shadows {percent(self.shadow_error)}"

    def with_gloss(self) -> str:
        """Error of rough metal in words; empty if it was not measured."""
        error = self.gloss_error()
        return "" if error is None else f"on metal of roughness 0.33 {percent(error)}"

    def _by_number(self) -> str:
        """Error of each number of lights, and of the last number with sizes."""
        if not self.search_errors:
            return ""
        curve = "  ".join(
            f"{lights}: {percent(error)}" for lights, error in self.search_errors.items()
        )
        if self.sized_error is None:
            return f"error in the search by number of lights: {curve}"
        sized = percent(self.sized_error)
        return f"error in the search by number of lights, as points: {curve}; with sizes: {sized}"

    def _radius_bound(self) -> str:
        """Lights at the largest radius, counted from 1 like the rows of a rig; empty if none is."""
        numbers = ", ".join(str(row + 1) for row in self.at_max_radius)
        plural = "" if len(self.at_max_radius) == 1 else "s"
        return f"largest radius reached by light{plural} {numbers}" if numbers else ""

    def _unseen(self) -> str:
        """Seen share, and what the unseen part may change; empty if all is seen."""
        if self.coverage_fraction == 1:
            return ""
        return (
            f"{percent(self.coverage_fraction)} of the sphere is seen; a black or a harmonic fill"
            f" of the rest changes the probe by {percent(self.unseen_spread)}"
        )

    def _by_channel(self) -> tuple[str, ...]:
        if not self.channel_errors:
            return ()
        channels = "  ".join(percent(error) for error in self.channel_errors)
        return (f"error in red, green, blue: {channels}; largest {percent(self.max_error)}",)

    def _choice(self) -> tuple[str, ...]:
        """Selected ambient term, with lights and error of each."""
        if not self.ambients:
            return ()
        each = "  ".join(
            f"{name}: {quantity(lights, 'light')}, {percent(error)}"
            for name, (lights, error) in self.ambients.items()
        )
        return (f"ambient term {self.ambient!r} selected from  {each}",)

    def _accuracy(self) -> tuple[str, ...]:
        if self.direction_tolerances:
            angles = _each_degree(self.direction_tolerances)
            return (f"direction tolerance (10 % more error): {angles}",)
        if self.direction_errors:
            return (
                f"condition number {self.condition:.3g}",
                f"standard error of the directions: {_each_degree(self.direction_errors)}",
            )
        return ()


def _each_degree(angles: tuple[float, ...]) -> str:
    """Angles in degrees, rounded, for a line of text."""
    rounded = np.degrees(angles)
    return "  ".join(f"{each:.2g}°" if each < 100 else f"{each:.0f}°" for each in rounded)
