"""Direction of the sun in its part of the core: by depth, by symmetry, and by a fit of the sky."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights.kernels.sphere import direction_to_uv, uv_to_direction
from envlights.sun.parts import Part
from envlights.sun.sky_fit import MeridianFit, fit_meridian, samples_of
from envlights.sun.sky_image import SkyImage
from envlights.sun.symmetry import best_meridian

#: Contrast of symmetry below which it counts, and its error in degrees.
_SYMMETRIC, _SYMMETRY_ERROR = 0.4, 1.5
#: Relative residual of the fit of the sky below which it counts, its error in degrees without any
#: residual, and the growth of the error with the residual.
_FITTING, _FIT_ERROR, _FIT_SLOPE = 0.07, 2.5, 15.0
#: Error in degrees of a spot: a pixel of a small map.
_SPOT_ERROR = 0.3
#: Elevation in degrees above which an azimuth says little.
_ZENITH = 80.0

Array = NDArray[np.float64]


class SunPosition(NamedTuple):
    """Direction of the sun, and the fit of the sky about it."""

    direction: Array
    uncertainty: float
    """Root of the sum of the squared errors along both axes, in degrees."""
    evidence: tuple[str, ...]
    fit: MeridianFit | None


def depth_error(radius: float) -> float:
    """Error in degrees of the centroid of a part of a radius in degrees."""
    return 0.5 + 0.14 * radius + 0.18 * max(radius - 12, 0)


def sun_position(image: SkyImage, part: Part, elevation: float | None = None) -> SunPosition:
    """Direction of the sun in a part; `elevation` in degrees if it is known."""
    width = image.core.shape[1]
    ((u, v),) = direction_to_uv(part.direction[None])
    shift = width // 2 - int(u * width)
    start = depth_error(part.radius)
    azimuth, az_error, el_error = float(u), start, start
    level = 90 - 180 * float(v) if elevation is None else elevation
    evidence = ["depth"]
    depth = np.roll(part.depth, shift, axis=1)
    sky, log = np.roll(image.sky, shift, axis=1), np.roll(image.log, shift, axis=1)
    meridian = best_meridian(log, sky, depth) if level < _ZENITH else None
    if meridian is not None and meridian.contrast < _SYMMETRIC:
        evidence.append("symmetry")
        error = np.hypot(_SYMMETRY_ERROR, meridian.spread * 360 / width * np.cos(np.radians(level)))
        place = (meridian.column - shift) / width
        # The azimuth of the depth is in columns, and its error is across them.
        turn = (place - u + 0.5) % 1 - 0.5
        azimuth = float((u + turn * _weight(error, start)) % 1)
        az_error = _joint(error, start)
    fit = _fit(image, part, azimuth, shift)
    if elevation is not None:
        level, el_error = elevation, 0.0
    elif fit is not None and fit.fit.relative < _FITTING and "symmetry" in evidence:
        evidence.append("sky")
        error = float(np.hypot(_FIT_ERROR + _FIT_SLOPE * fit.fit.relative, fit.spread))
        level += _weight(error, start) * (fit.mean - level)
        el_error = _joint(error, start)
    direction = uv_to_direction(np.array([[azimuth, 0.5 - level / 180]]))[0]
    return SunPosition(direction, float(np.hypot(az_error, el_error)), tuple(evidence), fit)


def _weight(error: float, other: float) -> float:
    """Weight of a value with an error, beside another."""
    return float(1 / error**2 / (1 / error**2 + 1 / other**2))


def _joint(error: float, other: float) -> float:
    """Error of the mean of two values, weighted by their errors."""
    return float(1 / np.sqrt(1 / error**2 + 1 / other**2))


def _fit(image: SkyImage, part: Part, azimuth: float, shift: int) -> MeridianFit | None:
    """Fit of the sky about each place of the core on a meridian."""
    height, width = image.core.shape
    samples = samples_of(image, shift)
    if samples is None:
        return None
    depth = image.depth[:, int(azimuth * width) % width]
    rows = np.flatnonzero(depth > 0)
    if not len(rows):
        return None
    v = (rows + 0.5) / height
    # The samples are those of the shifted image.
    turned = np.full(len(v), azimuth + shift / width)
    return fit_meridian(samples, uv_to_direction(np.stack([turned % 1, v], axis=1)), depth[rows])


def spot_position(image: SkyImage, direction: Array) -> SunPosition:
    """Position of a spot in smooth sky, and the fit of the sky about it."""
    return SunPosition(direction, _SPOT_ERROR, ("depth",), fit_about(image, direction))


def fit_about(image: SkyImage, direction: Array) -> MeridianFit | None:
    """Fit of the sky about a single direction; None with too little sky."""
    samples = samples_of(image, 0)
    return None if samples is None else fit_meridian(samples, direction[None], np.ones(1))
