"""Result type for the difference of two sets of lights."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, NamedTuple

from envlights._common.fields import fields_of
from envlights._common.result import Result
from envlights._common.tables import MOST_ROWS, Table
from envlights._common.words import degrees, percent

#: Angle in degrees above which moved flux counts as unmatched.
UNMATCHED_DEG = 30.0


class Movement(NamedTuple):
    """Flux moved from a light of the truth to a light of the guess."""

    truth: int
    """Index of the light in the truth."""

    guess: int
    """Index of the light in the guess."""

    fraction: float
    """Fraction of the flux; the fractions of a plan sum to 1."""

    angle: float
    """Angle between the two directions in degrees."""


@dataclass(frozen=True, eq=False, repr=False)
class LightSetDifference(Result):
    """Difference between a guessed and a true set of lights; see `compare_lights`.

    A number is None if it does not exist: most are, if either set has no light.
    """

    angle: float | None = None
    """Mean angle in degrees by which the optimal plan moves flux: the Wasserstein distance W1."""

    peak_angle: float | None = None
    """Angle in degrees between the strongest lights of both sets."""

    flux_ratio: float | None = None
    """Binary logarithm of the ratio of total luminance, guess to truth.

    None also for lights of a rig and lights that `detect` found in a map."""

    colour_angle: float | None = None
    """Angle in degrees between the total RGB irradiances."""

    size: float | None = None
    """Mean difference of the angular radii in degrees, over the plan."""

    unmatched: float | None = None
    """Fraction of the flux that the plan moves by more than 30 degrees."""

    rotation: float | None = None
    """Angle in degrees of the rotation that brings the truth closest to the guess, over the plan.

    With a single light, it is the smallest such rotation. None also if all are equally good."""

    left_out: float = 0.0
    """Fraction of the flux in lights beyond the strongest ones, the larger of both sets."""

    plan: tuple[Movement, ...] = ()
    """Movements of flux, sorted by index in the truth, then in the guess."""

    notes: tuple[str, ...] = ()
    """Notes on omitted lights, and on missing or uncertain numbers."""

    def to_dict(self) -> dict[str, Any]:
        """All fields as plain numbers, lists and strings."""
        return fields_of(self)

    def in_short(self) -> str:
        """Mean angle and ratio of the fluxes."""
        if self.angle is None:
            return "no lights to compare"
        flux = (
            "" if self.flux_ratio is None else f", flux of the lights x {_ratio(self.flux_ratio)}"
        )
        return f"{degrees(self.angle)} on average{flux}"

    def _details(self) -> list[str]:
        """Largest movements of the plan."""
        return ["", *str(self.table()).split("\n")] if self.plan else []

    def table(self) -> Table:
        """Table of the dozen largest movements, and a summary of the others."""
        largest = sorted(self.plan, key=lambda movement: -movement.fraction)
        rows = [
            [str(each.truth), str(each.guess), percent(each.fraction), degrees(each.angle)]
            for each in largest[:MOST_ROWS]
        ]
        hidden = largest[MOST_ROWS:]
        rest = f"{len(hidden)} more, {percent(sum(each.fraction for each in hidden))} together"
        return Table(["truth", "guess", "fraction", "angle"], rows, rest if hidden else "")

    def _html_parts(self) -> tuple[str, ...]:
        return (*super()._html_parts(), *([self.table().html()] if self.plan else []))

    def _lines(self) -> list[str]:
        """One line for each kind of number, and the notes."""
        lines = [
            f"mean angle of the flux     {degrees(self.angle)}",
            f"between the strongest      {degrees(self.peak_angle)}",
            f"flux of the lights, ratio  {_ratio(self.flux_ratio)}",
            f"angle between the colours  {degrees(self.colour_angle)}",
            f"difference of the radii    {degrees(self.size)}",
            f"moved more than {UNMATCHED_DEG:.0f}°        {percent(self.unmatched)}",
            f"best common rotation       {degrees(self.rotation)}",
        ]
        notes = (f"note: {note}" for note in self.notes)
        return [*(lines if self.angle is not None else []), *notes]


#: Numbers of a difference.
NUMBERS = tuple(each.name for each in fields(LightSetDifference))[:8]


def _ratio(binary_logarithm: float | None) -> str:
    return "none" if binary_logarithm is None else f"{2.0**binary_logarithm:.3g}"
