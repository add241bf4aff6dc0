"""Comparison of two sets of lights by optimal transport of their flux."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import count, describe
from envlights._common.words import percent
from envlights._native import EnvLightsError
from envlights.comparison.angles import degrees_between, rotation_degrees
from envlights.comparison.light_set_difference import UNMATCHED_DEG, LightSetDifference, Movement
from envlights.detection.lights import DetectedLights
from envlights.kernels.transport import transport_plan
from envlights.rigs.lights import Lights, brightest_first


def compare_lights(truth: Lights, guess: Lights, *, strongest: int = 256) -> LightSetDifference:
    r"""Compare two sets of lights: directions, flux, colour and size.

    The sets need neither the same number nor the same order of lights, and no threshold decides
    which lights belong together: the flux of the truth is moved to the guess at the least mean
    angle. A light that is seen as two halves is no error, and a missing light costs its share of
    the flux times the angle to the nearest light with too much.

    Parameters
    ----------
    truth, guess : Lights
        As of `Rig.lights`, `detect`, `split` or `Lights.load`.
    strongest : int
        Number of lights of each set to match, by luminance. Totals count all lights.

    Returns
    -------
    LightSetDifference
        All angles in degrees. Numbers that do not exist are None, with a note.

    Raises
    ------
    EnvLightsError
        If an argument is not `Lights`, or `strongest` is not a whole number from 1 on.

    See Also
    --------
    vector_angle : for maps, without a detection.

    Notes
    -----
    Flux is the luminance of the irradiance at normal incidence, as fractions that sum to 1 in
    either set, so brightness does not change the angles. The plan has the least mean angle
    (Peyré and Cuturi 2019, "Computational Optimal Transport", equation 2.11), which is a metric,
    symmetric and with a triangle inequality; of several such plans, it is one with the least mean
    square. Equal lamps may be exchanged, if that moves less. `peak_angle` is that between the
    `peak_direction` of both sets if both were detected, and otherwise between the directions.
    `rotation` solves Wahba's problem (1965) for the pairs of the plan.

    Examples
    --------
    A lamp seen as two halves, 1 degree to either side, and half as bright:

    >>> lamp = Lights([[0, 0, 1]], [[2, 2, 2]])
    >>> x, z = np.sin(np.deg2rad(1)), np.cos(np.deg2rad(1))
    >>> halves = Lights([[x, 0, z], [-x, 0, z]], [[0.5, 0.5, 0.5]] * 2)
    >>> difference = compare_lights(lamp, halves)
    >>> round(difference.angle, 6), round(difference.flux_ratio, 6)
    (1.0, -1.0)
    >>> print(difference)
    mean angle of the flux     1°
    between the strongest      1°
    flux of the lights, ratio  0.5
    angle between the colours  0°
    difference of the radii    0°
    moved more than 30°        0 %
    best common rotation       0°
    """
    most = count("strongest", strongest, least=1)
    one, other = _LightSet.of("truth", truth, most), _LightSet.of("guess", guess, most)
    notes = [*one.notes, *other.notes]
    if truth.units != guess.units:
        notes.append(f"the truth is in {truth.units}, the guess in {guess.units}; see flux_ratio")
    if not (one.flux.any() and other.flux.any()):
        left_out = max(one.left_out, other.left_out)
        return LightSetDifference(left_out=left_out, notes=tuple(notes))
    return _difference(one, other, tuple(notes))


class _LightSet(NamedTuple):
    lights: Lights
    """All lights."""

    rows: NDArray[np.intp]
    """Indices of the strongest lights, brightest first."""

    flux: NDArray[np.float64]
    """Luminance of the strongest lights."""

    left_out: float
    """Fraction of the flux in all other lights."""

    notes: tuple[str, ...]

    @classmethod
    def of(cls, name: str, lights: Lights, strongest: int) -> _LightSet:
        """Strongest lights of the argument `name`; raises an error for invalid sets."""
        if not isinstance(lights, Lights):
            raise EnvLightsError(
                f"{name} must be Lights, as of rig.lights or detect(map); got {describe(lights)}"
            )
        rows = brightest_first(lights.irradiance)
        flux = lights.luminance[rows]
        whole = flux.sum()
        left_out = float(flux[strongest:].sum() / whole) if whole else 0.0
        notes = tuple(_notes(name, lights, strongest, left_out))
        return cls(lights, rows[:strongest], flux[:strongest], left_out, notes)

    @property
    def total(self) -> NDArray[np.float64]:
        """RGB irradiance of all lights."""
        total: NDArray[np.float64] = self.lights.irradiance.sum(axis=0)
        return total


def _notes(name: str, lights: Lights, strongest: int, left_out: float) -> list[str]:
    notes = []
    if not lights.luminance.any():
        notes.append(f"the {name} has no light, so there is nothing to move")
    if len(lights) > strongest:
        notes.append(
            f"of the {name}, the {strongest} strongest of {len(lights)} lights are matched;"
            f" the others hold {percent(left_out, 2)} of its flux"
        )
    clipped = int(lights.is_clipped.sum()) if isinstance(lights, DetectedLights) else 0
    if clipped:
        notes.append(
            f"{clipped} light{' is' if clipped == 1 else 's are'} clipped in the {name}: the flux"
            " is a lower bound, and shares are uncertain"
        )
    return notes


def _difference(truth: _LightSet, guess: _LightSet, notes: tuple[str, ...]) -> LightSetDifference:
    before, after = truth.lights.direction[truth.rows], guess.lights.direction[guess.rows]
    angle, pairs, shares = transport_plan(before, truth.flux, after, guess.flux)
    before, after = before[pairs[:, 0]], after[pairs[:, 1]]
    angles = degrees_between(before, after)
    rows = truth.rows[pairs[:, 0]], guess.rows[pairs[:, 1]]
    radii = [
        each.lights.angular_radius[row] for each, row in zip((truth, guess), rows, strict=True)
    ]
    return LightSetDifference(
        angle=float(np.rad2deg(angle)),
        peak_angle=_peak_angle(truth, guess),
        flux_ratio=_flux_ratio(truth, guess),
        colour_angle=float(degrees_between(truth.total, guess.total)),
        size=float(np.rad2deg(shares @ np.abs(radii[0] - radii[1]))),
        unmatched=float(shares[angles > UNMATCHED_DEG].sum()),
        rotation=rotation_degrees(before, after, shares),
        left_out=max(truth.left_out, guess.left_out),
        plan=_movements(*rows, shares, angles),
        notes=notes,
    )


def _movements(*columns: NDArray[np.intp] | NDArray[np.float64]) -> tuple[Movement, ...]:
    """Movements of a plan, sorted by index in the truth, then in the guess."""
    return tuple(sorted(Movement(*row) for row in zip(*(c.tolist() for c in columns), strict=True)))


def _peak_angle(truth: _LightSet, guess: _LightSet) -> float:
    """Angle in degrees between the strongest lights, or between their peaks if both have one."""
    peaks = [_peak(each.lights, each.rows[0]) for each in (truth, guess)]
    if peaks[0] is None or peaks[1] is None:
        peaks = [each.lights.direction[each.rows[0]] for each in (truth, guess)]
    return float(degrees_between(*peaks))  # type: ignore[arg-type]


def _peak(lights: Lights, row: int) -> NDArray[np.float64] | None:
    """Peak direction of a detected light; None for other lights and for zero vectors."""
    if not isinstance(lights, DetectedLights) or not lights.peak_direction[row].any():
        return None
    peak: NDArray[np.float64] = lights.peak_direction[row]
    return peak


def _flux_ratio(truth: _LightSet, guess: _LightSet) -> float:
    """Binary logarithm of the ratio of the total luminances."""
    return float(np.log2(guess.lights.luminance.sum()) - np.log2(truth.lights.luminance.sum()))
