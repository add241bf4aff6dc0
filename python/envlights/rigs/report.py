"""Report of a fit: search, errors, and accuracy of the lights."""

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


#: Roughness of the metal in report texts: the matte silver of published comparisons.
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
        """True if more steps would not change the result."""
        successes = (StopReason.CONVERGED, StopReason.EXACT, StopReason.NOTHING_TO_FIT)
        return self in successes


@dataclass(frozen=True, eq=False, repr=False)
class FitReport(Result):
    """Report of a fit: search, errors, and accuracy of the lights.

    `str` gives the part for users; `verbose` gives everything.
    """

    search_errors: Mapping[int, float] = field(default_factory=dict)
    """Error of the best set found, for each number of lights.

    Without a requested error, these lights are points, and only the last number was searched in
    full; see `sized_error`. `error_curve` compares full fits."""

    sized_error: float | None = None
    """Relative RMS error of the final rig, if its lights have sizes but those of the search do
    not."""

    steps: int = 0
    """Number of steps of the solver."""

    stop_reason: StopReason = StopReason.NOT_FITTED
    """Reason why the solver stopped."""

    seconds: Mapping[str, float] = field(default_factory=dict, compare=False)
    """Wall time of each stage."""

    measured_on: str = ""
    """Normals at which the errors were measured, and the floor if there is one."""

    ambient: str = ""
    """Ambient term: "none", "constant" or "sh2"."""

    ambients: Mapping[str, tuple[int, float]] = field(default_factory=dict)
    """Number of lights and error for each ambient term that ``ambient="auto"`` compared."""

    channel_errors: tuple[float, ...] = ()
    """Relative RMS error in red, green and blue, relative to the irradiance of the channel."""

    max_error: float = on_demand(0.0)
    """Largest error of any channel at the measured normals, relative to the RMS irradiance.

    A map is measured at 5120 normals when this is first read. Normals whose horizon cuts a small
    sun have larger errors: on 100 generated maps, the largest error of others was 1.02 times as
    large in the median, at most 1.6 times on 90 of them, and up to 3.5 times."""

    shadow_error: float | None = None
    """Relative RMS error of irradiance with shadows; None if not measured.

    It is the error of the irradiance at every normal with everything behind a plane hidden,
    integrated over all planes. Each pixel of the map is a square of one radiance. Below 0.5 % it is
    exact to 6 % of itself."""

    objective_error: float | None = None
    """Relative RMS error that the fit minimised: that of its `objective`, or `Rig.error` for
    points.

    None if it was not measured, or if a sun was put beside the fitted lights."""

    gloss_bands: tuple[tuple[float, ...], tuple[float, ...]] = on_demand(((), ()))
    """Energy of the map per degree of spherical harmonics, and energy of the difference to the rig.

    All channels are summed. Both are empty if there was no map; see `gloss_error`. They are
    computed when they are first read."""

    points_error: float | None = None
    """Relative RMS error of the rig in a target that shows its lights as points."""

    fitted_points_error: float | None = None
    """Relative RMS error of equally many lights fitted as points, with the same ambient term."""

    target: tuple[str, ...] = ()
    """Names of the targets for which the rig was fitted; see `el.export.TARGETS`."""

    direction_tolerances: tuple[float, ...] = ()
    """Angle in radians by which each light can move before the error increases by 10 %.

    The light moves in the direction that raises the error least, and all else is fitted again. The
    tolerance is 0 for a fixed light, and pi if the map does not determine the direction. It uses
    second derivatives: above about 20 degrees, only its order of magnitude is meaningful."""

    condition: float = 1.0
    """Condition number of the Jacobian for measured irradiance, with normalised columns.

    It is large if the columns are almost linearly dependent, and infinite if they are dependent."""

    direction_errors: tuple[float, ...] = ()
    """Standard error of each light's direction for measured irradiance, in radians.

    0 for a fixed light, infinite if `condition` is. A map has no noise, so it has no standard
    errors."""

    irradiance_errors: tuple[tuple[float, float, float], ...] = ()
    """Standard error of each light's irradiance for measured irradiance, RGB.

    0 where the bound at zero is active, infinite if `condition` is."""

    fixed: tuple[int, ...] = ()
    """Index of each `fixed` light in `Rig.lights`, which are sorted by brightness.

    ``rig.lights.irradiance[list(rig.report.fixed)]`` has the order of the argument."""

    at_max_radius: tuple[int, ...] = ()
    """Index of each light in `Rig.lights` whose radius is limited by `max_radius`.

    Its radius may be smaller by the blur of a pixel. Empty without a `max_radius`."""

    fewer_lights: str = ""
    """Reason why fewer lights are used than allowed; empty if all are used."""

    coverage_fraction: float = 1.0
    """Covered fraction of the sphere; over a floor, of the upper hemisphere."""

    unseen_spread: float = 0.0
    """Relative RMS difference of irradiance between a black and a harmonic fill.

    It is the order of magnitude by which the unseen part may change the probe, but an unseen sun
    changes it more."""

    skipped: tuple[str, ...] = ()
    """Notes on work that was skipped as unnecessary."""

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
        """Report from the dictionary of `to_dict`; fields missing in old versions get defaults."""
        ambients = {
            name: (one["lights"], one["error"]) for name, one in data.get("ambients", {}).items()
        }
        # Rigs up to version 4 name the first field "errors"; version 2 has wall times.
        former = {"search_errors": data["errors"]} if "errors" in data else {}
        return read_fields(cls, {**data, **former, "ambients": ambients})

    def row(self) -> dict[str, Any]:
        """Scalar values and words of the report; NaN for values that were not measured."""
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
        """Data frame with one row: errors and options of the fit; needs pandas."""
        return frame_of({name: np.array([value]) for name, value in self.row().items()})

    def gloss_error(
        self, roughness: float = SHOWN_ROUGHNESS, material: str = "metal"
    ) -> float | None:
        r"""Relative RMS error of images of a glossy ball under the rig, over all views.

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
        # The rig itself prints the stop reason.
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
        """Error with shadows as text; empty if not measured."""
        return "" if self.shadow_error is None else f"with shadows {percent(self.shadow_error)}"

    def with_gloss(self) -> str:
        """Error of rough metal as text; empty if not measured."""
        error = self.gloss_error()
        return "" if error is None else f"on metal of roughness 0.33 {percent(error)}"

    def _by_number(self) -> str:
        """Text with the error for each number of lights, and the final error with sizes."""
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
        """Text on lights at the largest radius, numbered from 1; empty if there are none."""
        numbers = ", ".join(str(row + 1) for row in self.at_max_radius)
        plural = "" if len(self.at_max_radius) == 1 else "s"
        return f"largest radius reached by light{plural} {numbers}" if numbers else ""

    def _unseen(self) -> str:
        """Text on the covered fraction, and on the effect of the fill; empty if complete."""
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
        """Text on the selected ambient term, with lights and error of each alternative."""
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
    """Angles in degrees, rounded, joined to a line of text."""
    rounded = np.degrees(angles)
    return "  ".join(f"{each:.2g}°" if each < 99.5 else f"{each:.0f}°" for each in rounded)
