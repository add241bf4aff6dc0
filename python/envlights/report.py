"""Report of a fit: the search, its errors, and the accuracy of the lights."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from envlights import _html
from envlights._check import amount, count
from envlights._report_fields import (
    StopReason,
    bands,
    degrees,
    finite,
    number,
    optional,
    percent,
    rgb,
    row_of,
    search_errors,
    stop_reason,
)
from envlights._result import Result
from envlights._tables import Table, frame_of
from envlights._times import time_lines, times_of
from envlights.kernels import gloss

if TYPE_CHECKING:
    import pandas as pd


#: Roughness of the metal in the text of a report: the matte silver of published comparisons.
SHOWN_ROUGHNESS = 0.33


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

    max_error: float = 0.0
    """Largest error of any channel at the measured normals, relative to the RMS irradiance.

    A map is measured at 5120 or more normals. Normals whose horizon cuts a small sun have larger
    errors: on 100 generated maps, the largest error of others was 1.02 times as large in the
    median, at most 1.6 times on 90 of them, and up to 3.5 times."""

    shadow_error: float | None = None
    """Relative RMS error of shadowed irradiance, or None if it was not measured.

    It is the error of the irradiance at every normal with everything behind a plane hidden,
    integrated over all planes. Each pixel of the map is a square of one radiance."""

    objective_error: float | None = None
    """Relative RMS error that the fit minimised: of its `objective`, or `Rig.error` of points.

    None if it was not measured, or if a sun was put beside the fitted lights."""

    gloss_bands: tuple[tuple[float, ...], tuple[float, ...]] = ((), ())
    """Energy of the map in each degree of spherical harmonics, and of its difference from the rig.

    All channels are summed. Both are empty if there was no map; see `gloss_error`."""

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

    def to_dict(self) -> dict[str, Any]:
        """All fields except the times as plain numbers, lists and strings."""
        return {
            "search_errors": {str(n): error for n, error in self.search_errors.items()},
            "sized_error": self.sized_error,
            "steps": self.steps,
            "stop_reason": self.stop_reason.name,
            "measured_on": self.measured_on,
            "ambient": self.ambient,
            "ambients": {
                name: {"lights": lights, "error": error}
                for name, (lights, error) in self.ambients.items()
            },
            "channel_errors": list(self.channel_errors),
            "max_error": self.max_error,
            "shadow_error": self.shadow_error,
            "objective_error": self.objective_error,
            "gloss_error": self.gloss_error(),
            "gloss_bands": [list(band) for band in self.gloss_bands],
            "points_error": self.points_error,
            "fitted_points_error": self.fitted_points_error,
            "target": list(self.target),
            "direction_tolerances": list(self.direction_tolerances),
            "condition": finite(self.condition),
            "direction_errors": [finite(error) for error in self.direction_errors],
            "irradiance_errors": [[finite(e) for e in errors] for errors in self.irradiance_errors],
            "fixed": list(self.fixed),
            "at_max_radius": list(self.at_max_radius),
            "fewer_lights": self.fewer_lights,
            "coverage_fraction": self.coverage_fraction,
            "unseen_spread": self.unseen_spread,
            "skipped": list(self.skipped),
        }

    def row(self) -> dict[str, Any]:
        """Single numbers and words of the report; NaN for what was not measured."""
        return row_of(self)

    def to_frame(self) -> pd.DataFrame:
        """Data frame with one row of the errors and the choices of the fit; needs pandas."""
        return frame_of({name: np.array([value]) for name, value in self.row().items()})

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> FitReport:
        """Report that `to_dict` wrote; fields that an older version did not write get defaults."""
        return cls(
            search_errors={
                count("lights", int(n)): amount("search_errors", error)
                for n, error in search_errors(data).items()
            },
            sized_error=optional("sized_error", data.get("sized_error")),
            steps=count("steps", data["steps"]),
            stop_reason=stop_reason(data["stop_reason"]),
            seconds=times_of(data),
            measured_on=str(data["measured_on"]),
            ambient=str(data.get("ambient", "")),
            ambients={
                str(name): (count("lights", one["lights"]), amount("error", one["error"]))
                for name, one in data.get("ambients", {}).items()
            },
            channel_errors=tuple(amount("channel_errors", e) for e in data["channel_errors"]),
            max_error=amount("max_error", data["max_error"]),
            shadow_error=optional("shadow_error", data.get("shadow_error")),
            objective_error=optional("objective_error", data.get("objective_error")),
            gloss_bands=bands(data.get("gloss_bands", ((), ()))),
            points_error=optional("points_error", data.get("points_error")),
            fitted_points_error=optional("fitted_points_error", data.get("fitted_points_error")),
            target=tuple(str(name) for name in data.get("target", ())),
            direction_tolerances=tuple(
                amount("direction_tolerances", t) for t in data.get("direction_tolerances", ())
            ),
            condition=number(data["condition"]),
            direction_errors=tuple(number(error) for error in data["direction_errors"]),
            irradiance_errors=tuple(rgb(errors) for errors in data["irradiance_errors"]),
            fixed=tuple(count("fixed", row) for row in data.get("fixed", ())),
            at_max_radius=tuple(
                count("at_max_radius", row) for row in data.get("at_max_radius", ())
            ),
            fewer_lights=str(data.get("fewer_lights", "")),
            coverage_fraction=amount("coverage_fraction", data.get("coverage_fraction", 1.0), most=1.0),
            unseen_spread=amount("unseen_spread", data.get("unseen_spread", 0.0)),
            skipped=tuple(str(note) for note in data["skipped"]),
        )

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
        plural = "" if lights == 1 else "s"
        return f"{lights} light{plural}, {percent(error)}; {self.stop_reason.value}"

    def __str__(self) -> str:
        return "\n".join(filter(None, [self._by_number(), *self._short()]))

    def verbose(self) -> str:
        """Text with all details."""
        return "\n".join(filter(None, [self._by_number(), *self._short(), *self._details()]))

    def _html_parts(self) -> tuple[str, ...]:
        has_sizes = self.sized_error is not None
        columns = ["lights", *map(str, self.search_errors), *(["with sizes"] if has_sizes else [])]
        each = [
            *self.search_errors.values(),
            *([self.sized_error] if self.sized_error is not None else []),
        ]
        curve = (
            Table(columns, [["error", *map(percent, each)]]).html() if self.search_errors else ""
        )
        return curve, _html.lines("\n".join(filter(None, self._short())))

    def _short(self) -> list[str]:
        """Lines for users, below the error of each number of lights."""
        # A rig shows the stop reason of its fit itself.
        unfitted = "" if self.search_errors else self.stop_reason.value
        made_for = f"fitted for {', '.join(self.target)}" if self.target else ""
        lines = [made_for, self._radius_bound(), self._unseen(), self.fewer_lights, unfitted]
        return [*self._choice(), *lines]

    def _details(self) -> list[str]:
        """Lines for developers."""
        return [
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
            f"{percent(self.coverage_fraction)} of the sphere is seen; a black or a harmonic fill of the"
            f" rest changes the probe by {percent(self.unseen_spread)}"
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
            f"{name}: {lights} light{'' if lights == 1 else 's'}, {percent(error)}"
            for name, (lights, error) in self.ambients.items()
        )
        return (f"ambient term {self.ambient!r} selected from  {each}",)

    def _accuracy(self) -> tuple[str, ...]:
        """Accuracy of the directions."""
        if self.direction_tolerances:
            angles = degrees(self.direction_tolerances)
            return (f"direction tolerance (10 % more error): {angles}",)
        if self.direction_errors:
            return (
                f"condition number {self.condition:.3g}",
                f"standard error of the directions: {degrees(self.direction_errors)}",
            )
        return ()
