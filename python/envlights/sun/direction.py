"""Direction of the sun in a clipped region: by depth, by symmetry, and by a fit of the sky."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights.kernels.sphere import direction_to_uv, uv_to_direction
from envlights.sun.parts import Part
from envlights.sun.sky_fit import MeridianFit, fit_meridian, samples_of
from envlights.sun.sky_image import SkyImage
from envlights.sun.symmetry import best_meridian

#: Contrast below which symmetry is clear enough, and the error of its azimuth in degrees.
_SYMMETRIC, _SYMMETRY_ERROR = 0.4, 1.5
#: Relative residual below which the fit of the sky is used, its error in degrees at residual 0, and
#: the growth of the error with the residual.
_FITTING, _FIT_ERROR, _FIT_SLOPE = 0.07, 2.5, 15.0
#: Direction error of a spot in degrees: one pixel of a small map.
_SPOT_ERROR = 0.3
#: Elevation in degrees above which azimuths are not meaningful.
_ZENITH = 80.0

Array = NDArray[np.float64]


class SunPosition(NamedTuple):
    """Direction of the sun, and the fit of the sky around it."""

    direction: Array
    uncertainty: float
    """Root of the sum of squared errors along both axes, in degrees."""
    evidence: tuple[str, ...]
    fit: MeridianFit | None


def depth_error(radius: float) -> float:
    """Error in degrees of the centroid of a clipped region with a radius in degrees."""
    return 0.5 + 0.14 * radius + 0.18 * max(radius - 12, 0)


def sun_position(image: SkyImage, part: Part, elevation: float | None = None) -> SunPosition:
    """Direction of the sun in a clipped region; `elevation` in degrees if known."""
    width = image.core.shape[1]
    ((u, v),) = direction_to_uv(part.direction[None])
    # Rotate the region to the middle of the image, away from the seam.
    shift = width // 2 - int(u * width)
    error = depth_error(part.radius)
    azimuth = Estimate(float(u), error)
    level = Estimate(90 - 180 * float(v), error)
    if elevation is not None:
        level = Estimate(elevation, 0.0)
    evidence = ["depth"]
    by_symmetry = _azimuth_by_symmetry(image, part, shift, level.value)
    if by_symmetry is not None:
        evidence.append("symmetry")
        turn = 360 * np.cos(np.radians(level.value))
        azimuth = azimuth.joined(by_symmetry, turn, period=1.0)
    fit = _fit(image, azimuth.value, shift)
    usable = fit is not None and fit.fit.relative < _FITTING and by_symmetry is not None
    if fit is not None and usable and elevation is None:
        evidence.append("sky")
        by_fit = np.hypot(_FIT_ERROR + _FIT_SLOPE * fit.fit.relative, fit.spread)
        level = level.joined(Estimate(fit.mean, float(by_fit)))
    direction = uv_to_direction(np.array([[azimuth.value, 0.5 - level.value / 180]]))[0]
    uncertainty = float(np.hypot(azimuth.error, level.error))
    return SunPosition(direction, uncertainty, tuple(evidence), fit)


class Estimate(NamedTuple):
    """Value with its error, in degrees on the sphere."""

    value: float
    error: float

    def joined(self, other: Estimate, degrees: float = 1.0, period: float = np.inf) -> Estimate:
        """Mean of two estimates, weighted by their errors; `degrees` per unit of both values.

        If they differ by more than both errors, the error grows by the ratio of Birge (1932).
        """
        weight = 1 / other.error**2 / (1 / other.error**2 + 1 / self.error**2)
        step = other.value - self.value
        if np.isfinite(period):
            step = (step + period / 2) % period - period / 2
        value = self.value + weight * step
        error = 1 / np.sqrt(1 / self.error**2 + 1 / other.error**2)
        error *= max(1.0, abs(step) * degrees / np.hypot(self.error, other.error))
        return Estimate(value % period if np.isfinite(period) else value, float(error))


def _azimuth_by_symmetry(
    image: SkyImage, part: Part, shift: int, elevation: float
) -> Estimate | None:
    """Azimuth as a fraction of the circle, from the best symmetry; None if not clear."""
    if elevation >= _ZENITH:
        return None
    width = image.core.shape[1]
    sky, log = np.roll(image.sky, shift, axis=1), np.roll(image.log, shift, axis=1)
    meridian = best_meridian(log, sky, np.roll(part.depth, shift, axis=1))
    if meridian is None or meridian.contrast >= _SYMMETRIC:
        return None
    spread = meridian.spread * 360 / width * np.cos(np.radians(elevation))
    error = float(np.hypot(_SYMMETRY_ERROR, spread))
    return Estimate((meridian.column - shift) / width % 1, error)


def _fit(image: SkyImage, azimuth: float, shift: int) -> MeridianFit | None:
    """Fits of the sky for all sun positions in the core on the meridian of an azimuth."""
    height, width = image.core.shape
    depth = image.depth[:, int(azimuth * width) % width]
    rows = np.flatnonzero(depth > 0)
    samples = samples_of(image, shift)
    if samples is None or not len(rows):
        return None
    places = np.stack([np.full(len(rows), azimuth), (rows + 0.5) / height], axis=1)
    return fit_meridian(samples, uv_to_direction(places), depth[rows])


def spot_position(image: SkyImage, direction: Array) -> SunPosition:
    """Position of a spot in a smooth sky, and the fit of the sky around it."""
    return SunPosition(direction, _SPOT_ERROR, ("depth",), fit_about(image, direction))


def fit_about(image: SkyImage, direction: Array) -> MeridianFit | None:
    """Fit of the sky around a direction; None if too little sky is visible."""
    samples = samples_of(image, 0)
    return None if samples is None else fit_meridian(samples, direction[None], np.ones(1))
