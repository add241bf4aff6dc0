"""What a detector found against what is there."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._check import reals
from envlights.kernels.image import LUMINANCE
from envlights.synthetic.scene import SyntheticMap

#: A light may be missed by this, or by its own radius where that is more.
TOLERANCE_DEG = 2.0


@dataclass(frozen=True)
class Score:
    """How well a detector did on a family of maps.

    Ratios without a denominator are 1: who finds nothing where nothing is makes no mistake.
    """

    known: int
    """Lights in all maps."""

    found: int
    """Lights that were detected, those on maps without lights included."""

    angles_deg: NDArray[np.float64]
    """From each hit to its light."""

    flux_errors: NDArray[np.float64]
    """Relative, in luminance, of each hit."""

    false_on_lightless: int
    """Lights that were detected on maps that have none."""

    @property
    def precision(self) -> float:
        """Share of what was found that is there."""
        return len(self.angles_deg) / self.found if self.found else 1.0

    @property
    def recall(self) -> float:
        """Share of what is there that was found."""
        return len(self.angles_deg) / self.known if self.known else 1.0

    @property
    def f1(self) -> float:
        """Harmonic mean of precision and recall."""
        both = self.found + self.known
        return 2 * len(self.angles_deg) / both if both else 1.0


def judge(results: Iterable[tuple[SyntheticMap, ArrayLike, ArrayLike]]) -> Score:
    """Score a detector on a family of maps.

    Parameters
    ----------
    results : iterable of (SyntheticMap, directions, irradiance)
        For each map what was found in it: unit vectors, shape (n, 3), and the RGB integral of
        the radiance over each light, shape (n, 3), background included.

    Returns
    -------
    Score

    Examples
    --------
    >>> from envlights.synthetic import Disc, scene
    >>> lamp = scene(64, shapes=[Disc((1, 0, 0), 5, (2, 2, 2))])
    >>> score = judge([(lamp, [[1, 0, 0], [0, 1, 0]], [[0.05, 0.05, 0.05], [1, 1, 1]])])
    >>> score.precision, score.recall
    (0.5, 1.0)
    """
    known = found = false_on_lightless = 0
    angles: list[float] = []
    flux_errors: list[float] = []
    for world, directions, irradiance in results:
        detected = np.reshape(directions, (-1, 3))
        flux = np.reshape(irradiance, (-1, 3)) @ LUMINANCE
        truth = world.irradiance_with_background @ LUMINANCE
        known, found = known + len(world.lights), found + len(detected)
        false_on_lightless += len(detected) * (len(world.lights) == 0)
        for i, j, angle in match(world, detected):
            angles.append(angle)
            flux_errors.append(abs(flux[j] - truth[i]) / truth[i])
    return Score(known, found, np.array(angles), np.array(flux_errors), false_on_lightless)


def match(world: SyntheticMap, directions: ArrayLike) -> list[tuple[int, int, float]]:
    """Which detected light is which known one: the closest pair first, each at most once.

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
    # From the chord, for the arc cosine is blind below 1e-6 degrees.
    angles = np.rad2deg(2 * np.arcsin(np.clip(chords / 2, 0, 1)))
    angles[angles > np.maximum(TOLERANCE_DEG, world.angular_radius_deg)[:, None]] = np.inf
    hits = []
    while angles.size and np.isfinite(angles.min()):
        i, j = (int(k) for k in np.unravel_index(angles.argmin(), angles.shape))
        hits.append((i, j, float(angles[i, j])))
        angles[i], angles[:, j] = np.inf, np.inf
    return hits
