"""Result of the search for a sun."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.arrays import seal
from envlights._common.check import check_choice, rotation
from envlights._common.result import Result
from envlights._common.units import OWN_SCALE, checked_units, in_lux
from envlights.kernels.angles import SUN_RADIUS, azimuths, elevations
from envlights.kernels.image import LUMINANCE
from envlights.rigs.lights import Lights
from envlights.sun import wording

#: Possible values of `Sun.answer`.
ANSWERS = ("sun", "perhaps", "no")


@dataclass(frozen=True, eq=False, repr=False)
class Sun(Result):
    r"""Sun (or moon) of a map: the answer, its direction, and its irradiance.

    Examples
    --------
    >>> import envlights as el
    >>> print(el.find_sun(np.full((64, 128, 3), 0.5)))
    no sun
    note: no pixel is clipped, and no light of the map is like a sun
    """

    answer: str
    """ "sun", "perhaps" or "no"."""

    points: Mapping[str, bool] = field(default_factory=dict)
    """Question about the picture, and True for yes; empty if the map is not clipped, or if a
    direction was given."""

    direction: NDArray[np.float64] | None = None
    """Unit vector towards the sun, shape (3,): right-handed, +y up. None if the answer is "no"."""

    direction_uncertainty: float = 0.0
    """Direction error in radians that two of three suns do not exceed; 0 for a given direction."""

    irradiance: NDArray[np.float64] | None = None
    """Linear RGB at normal incidence, shape (3,). None if the answer is "no"."""

    interval: tuple[float, float] = (1.0, 1.0)
    """Factors on the irradiance that bound the true value for two of three suns."""

    wide_interval: tuple[float, float] = (1.0, 1.0)
    """Factors on the irradiance that bound the true value for nine of ten suns."""

    angular_radius: float = SUN_RADIUS
    """Radius of the disc in radians, by default that of the sun and the moon."""

    plateau_radius: float = 0.0
    """Radius in radians of a disc as large as the clipped region; 0 if there is none."""

    evidence: tuple[str, ...] = ()
    """Sources of the direction: "depth", "symmetry", "sky", "given" or "map"."""

    notes: tuple[str, ...] = ()
    """Notes on the answer."""

    plateau: NDArray[np.float32] | None = field(default=None, compare=False)
    """Luminance of the sky behind the sun in the pixels of the clipped region, and 0 elsewhere,
    shape (height, width); see `Sun.sky`. None without such a region."""

    units: str = field(default=OWN_SCALE, kw_only=True)
    """Unit of the radiance of the map; with "cd/m2", the luminance of `irradiance` is in lux."""

    def __post_init__(self) -> None:
        check_choice("answer", self.answer, ANSWERS)
        checked_units(self.units)
        for name in ("direction", "irradiance", "plateau"):
            array = getattr(self, name)
            if array is not None:
                kind = np.float32 if name == "plateau" else np.float64
                object.__setattr__(self, name, seal(np.array(array, kind)))

    @property
    def elevation(self) -> float | None:
        """Radians above the horizon; None without a direction."""
        return None if self.direction is None else float(elevations(self.direction[None])[0])

    @property
    def azimuth(self) -> float | None:
        """Radians from -z over +x, from 0 to 2 pi; None without a direction."""
        return None if self.direction is None else float(azimuths(self.direction[None])[0])

    @property
    def lights(self) -> Lights:
        """The sun as a disc of uniform radiance; no light if the answer is not "sun".

        Its `notes` say what is a guess.
        """
        if self.answer != "sun" or self.direction is None or self.irradiance is None:
            return Lights(np.zeros((0, 3)), np.zeros((0, 3)), units=self.units)
        radius = np.array([self.angular_radius])
        return Lights(
            self.direction[None],
            self.irradiance[None],
            radius,
            units=self.units,
            notes=(self.light_note(),),
        )

    def light_note(self, measured: str = "") -> str:
        """Note on the light, with the sources of direction and irradiance.

        Words for a `measured` irradiance replace those for the estimate.
        """
        moon = " (or moon, which a picture cannot tell)" if self.points else ""
        irradiance = measured or wording.of_irradiance(self.evidence, self.interval)
        return wording.of_light(f"{self.in_short()}{moon}", self.evidence, irradiance)

    def sky(self, radiance: NDArray[np.float32]) -> NDArray[np.float32]:
        """Radiance of the map with sky in the clipped region; each pixel keeps its colour.

        The radiance is that of the map of `find_sun`, shape (height, width, 3). No sample falls.
        Without a `plateau`, the radiance itself is returned.
        """
        if self.plateau is None:
            return radiance
        filled = radiance.copy()
        is_sun = self.plateau > 0
        pixels = filled[is_sun]
        factor = self.plateau[is_sun] / np.maximum(pixels @ LUMINANCE, np.finfo(np.float32).tiny)
        filled[is_sun] = pixels * np.maximum(factor, 1)[:, None].astype(np.float32)
        return filled

    def rotated(self, matrix: ArrayLike) -> Sun:
        """Sun after a rotation, without `plateau`, whose pixels belong to the map before it."""
        turn = rotation(matrix)
        direction = None if self.direction is None else self.direction @ turn.T
        return replace(self, direction=direction, plateau=None)

    def in_short(self) -> str:
        """Answer and direction."""
        if self.direction is None:
            return "no sun"
        words = {"sun": "sun", "perhaps": "perhaps a sun", "no": "no sun"}[self.answer]
        return f"{words} at {self._place()}"

    def _place(self) -> str:
        azimuth, elevation = np.degrees([self.azimuth or 0.0, self.elevation or 0.0])
        place = f"azimuth {azimuth:.1f}°, elevation {elevation:.1f}°"
        if not self.direction_uncertainty:
            return place
        return f"{place} ± {np.degrees(self.direction_uncertainty):.1f}°"

    def __str__(self) -> str:
        return "\n".join([self.in_short(), *self._measures(), *(f"note: {n}" for n in self.notes)])

    def _measures(self) -> tuple[str, ...]:
        if self.irradiance is None:
            return ()
        values = "  ".join(f"{value:.4g}" for value in self.irradiance)
        low, high = self.interval
        sure = "" if low == high else f", times {low:.2g} to {high:.2g} (two of three)"
        return (
            f"irradiance{in_lux(self.units)} at normal incidence: {values}{sure}",
            f"direction by: {', '.join(self.evidence)}",
        )

    def verbose(self) -> str:
        """Text with the questions, their answers, and sizes."""
        low, high = self.wide_interval
        wide = f"irradiance in nine of ten: times {low:.2g} to {high:.2g}"
        return "\n".join(
            [
                str(self),
                *([wide] if low != high else []),
                *(
                    f"{'yes' if yes else 'no ':<3}  {question}"
                    for question, yes in self.points.items()
                ),
                f"radius of the clipped part: {np.degrees(self.plateau_radius):.2f}°",
            ]
        )

    def to_dict(self) -> dict[str, Any]:
        """All fields except the `plateau` as plain numbers, lists and strings."""
        return {
            "answer": self.answer,
            "points": dict(self.points),
            "direction": None if self.direction is None else self.direction.tolist(),
            "direction_uncertainty": self.direction_uncertainty,
            "irradiance": None if self.irradiance is None else self.irradiance.tolist(),
            "interval": list(self.interval),
            "wide_interval": list(self.wide_interval),
            "angular_radius": self.angular_radius,
            "plateau_radius": self.plateau_radius,
            "evidence": list(self.evidence),
            "notes": list(self.notes),
            "scale": self.units,
        }
