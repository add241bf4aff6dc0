"""Comparison of detected lights with the known ones."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import reals
from envlights._common.result import Result
from envlights._common.words import percent
from envlights.kernels.image import LUMINANCE
from envlights.synthetic.scene import SyntheticMap

#: Largest angle of a hit in degrees; for a larger light, its own radius.
TOLERANCE_DEG = 2.0


@dataclass(frozen=True, eq=False, repr=False)
class Score(Result):
    """Score of a detector on a family of maps.

    A ratio with the denominator 0 is 1: a detector that finds nothing in a map without lights makes
    no mistake.
    """

    known: int
    """Number of lights in all maps."""

    found: int
    """Number of detected lights, maps without lights included."""

    angles_deg: NDArray[np.float64]
    """Angle from each hit to its light."""

    flux_errors: NDArray[np.float64]
    """Relative error of the luminance of each hit."""

    false_on_lightless: int
    """Number of lights that were detected on maps without lights."""

    def in_short(self) -> str:
        """The ratios, and the accuracy of the hits."""
        if not len(self.angles_deg):
            return f"no hit of {self.known} lights, {self.found} found"
        angle, flux = np.median(self.angles_deg), np.median(np.abs(self.flux_errors))
        return (
            f"precision {percent(self.precision)}, recall {percent(self.recall)};"
            f" median error {angle:.2g}° and {percent(flux, 2)} of the flux"
        )

    @property
    def precision(self) -> float:
        """Fraction of the detected lights that are hits."""
        return len(self.angles_deg) / self.found if self.found else 1.0

    @property
    def recall(self) -> float:
        """Fraction of the known lights that were hit."""
        return len(self.angles_deg) / self.known if self.known else 1.0

    @property
    def f1(self) -> float:
        """Harmonic mean of precision and recall."""
        both = self.found + self.known
        return 2 * len(self.angles_deg) / both if both else 1.0


def evaluate(results: Iterable[tuple[SyntheticMap, ArrayLike, ArrayLike]]) -> Score:
    """Score a detector on a family of maps.

    Parameters
    ----------
    results : iterable of (SyntheticMap, directions, flux)
        Lights detected in each map: unit vectors, shape (n, 3), and their `DetectedLights.flux`,
        shape (n, 3).

    Returns
    -------
    Score

    Examples
    --------
    >>> from envlights.synthetic import Disc, scene
    >>> lamp = scene(64, shapes=[Disc((1, 0, 0), 5, (2, 2, 2))])
    >>> score = evaluate([(lamp, [[1, 0, 0], [0, 1, 0]], [[0.05, 0.05, 0.05], [1, 1, 1]])])
    >>> score.precision, score.recall
    (0.5, 1.0)
    """
    known = found = false_on_lightless = 0
    angles: list[float] = []
    flux_errors: list[float] = []
    for world, directions, rgb_flux in results:
        # Count lights, known and detected.
        detected = np.reshape(directions, (-1, 3))
        flux = np.reshape(rgb_flux, (-1, 3)) @ LUMINANCE
        truth = world.irradiance_with_background @ LUMINANCE
        known, found = known + len(world.lights), found + len(detected)
        false_on_lightless += len(detected) * (len(world.lights) == 0)
        # Measure the hits.
        for i, j, angle in match(world, detected):
            angles.append(angle)
            flux_errors.append(abs(flux[j] - truth[i]) / truth[i])
    return Score(known, found, np.array(angles), np.array(flux_errors), false_on_lightless)


def match(world: SyntheticMap, directions: ArrayLike) -> list[tuple[int, int, float]]:
    """Pair detected lights with known ones, the closest first, each light at most once.

    Parameters
    ----------
    world : SyntheticMap
    directions : array_like, shape (n, 3)
        Unit vectors towards the detected lights.

    Returns
    -------
    list of (int, int, float)
        Index of the known light, of the detected one, and the angle between them in degrees: at
        most 2 degrees, or the light's angular radius where that is more.
    """
    detected = reals("directions", directions, 2)
    chords = np.linalg.norm(world.lights.direction[:, None] - detected[None], axis=2)
    # Measure all angles by their chords, because the arc cosine is blind below 1e-6 degrees.
    angles = np.rad2deg(2 * np.arcsin(np.clip(chords / 2, 0, 1)))
    angles[angles > np.maximum(TOLERANCE_DEG, world.angular_radius_deg)[:, None]] = np.inf
    # Take the closest pair, remove both lights, and repeat.
    hits = []
    while angles.size and np.isfinite(angles.min()):
        i, j = (int(k) for k in np.unravel_index(angles.argmin(), angles.shape))
        hits.append((i, j, float(angles[i, j])))
        angles[i], angles[:, j] = np.inf, np.inf
    return hits
