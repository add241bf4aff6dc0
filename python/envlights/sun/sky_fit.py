"""Elevation of the sun, from fits of a clear sky for each position on its meridian.

The logarithm of the luminance is a function of the angle from the sun plus one of the elevation, as
in the general sky of the CIE (ISO 15469) and of Perez et al. (1993), here with linear coefficients:

    t = a0 + a1 log(g + 0.05) + a2 exp(-2.5 g) + a3 cos^2 g + a4 u + a5 u^2 + a6 u^6

for the angle g from the sun and u = 1 - sin(elevation). A picture has one of two tones: t = log Y
for a camera or renderer that cuts off, and t = log(Y / (1.03 - Y)) for a film curve, which bends
towards white. The likelihood of Box and Cox (1964) decides between them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights.kernels.sphere import pixel_directions
from envlights.sun.sky_image import SkyImage

#: Iterations of the reweighted least squares.
_STEPS = 4
#: Residual in robust deviations above which a cell has less weight: clouds, houses.
_OUTLIER = 1.5
#: Ridge parameter relative to the mean diagonal; without it, a small sky has no solution.
_RIDGE = 1e-5
#: Residual above which the cost grows slowly, and cost of noise.
_COST_SCALE, _NOISE = 0.1, 2e-4
#: Exponent of the cost ratio in the weight of an elevation.
_SHARPNESS = 32
#: Luminance at which the film curve ends, relative to the clip level.
_FILM_END = 1.03
#: Smallest gain in log likelihood per cell for which a film curve is assumed.
_LEAST_GAIN = 0.12
#: Columns of the image for the fit, and smallest number of its cells.
_COLUMNS, _LEAST_CELLS = 128, 100

Array = NDArray[np.float64]


class SkyFit(NamedTuple):
    """Fit of a sky model with a sun."""

    sun: Array
    """Unit vector towards the sun."""
    coefficients: Array
    is_film: bool
    """True if a film curve was applied to the luminance."""
    relative: float
    """Residual cost relative to the deviation of the sky: small for a good fit."""

    def luminance(self, directions: Array) -> Array:
        """Fitted luminance relative to the clip level, at unit vectors, (n, 3)."""
        value = (basis(directions, self.sun[None])[0] @ self.coefficients).clip(-20, 20)
        level: Array = _FILM_END / (1 + np.exp(-value)) if self.is_film else np.exp(value)
        return level


class SkySamples(NamedTuple):
    """Cells of the sky on a coarse regular grid."""

    directions: Array
    luminance: Array
    weight: Array

    def values(self, is_film: bool) -> Array:
        """Luminance of the samples, transformed by the film curve or logarithm."""
        if is_film:
            return _log(self.luminance / (_FILM_END - self.luminance))
        return _log(self.luminance)

    def stretch(self) -> float:
        """Mean log derivative of film values with respect to plain log luminance."""
        slope = np.log(_FILM_END / (_FILM_END - self.luminance))
        return float(np.average(slope, weights=self.weight))


def _log(values: Array) -> Array:
    logarithm: Array = np.log(values)
    return logarithm


def samples_of(image: SkyImage, shift: int) -> SkySamples | None:
    """Samples of the sky in blocks, from a column shift on; None if there are too few."""
    height, width = image.core.shape
    block = max(1, width // _COLUMNS)
    rows, columns = height // block, width // block

    def sums(values: NDArray[np.generic]) -> Array:
        part = np.roll(values, shift, axis=1)[: rows * block, : columns * block]
        total: Array = part.reshape(rows, block, columns, block).sum((1, 3), dtype=np.float64)
        return total

    count = sums(image.sky)
    usable = count >= 0.5 * block**2
    if np.count_nonzero(usable) < _LEAST_CELLS:
        return None
    log = sums(np.where(image.sky, image.log, 0))[usable] / count[usable]
    directions = _turned_back(pixel_directions(rows, columns)[usable], shift / width)
    weight = np.sqrt(np.maximum(1 - directions[:, 1] ** 2, 0))
    return SkySamples(directions, np.minimum(np.exp(log), 1.0), weight)


def _turned_back(directions: Array, turns: float) -> Array:
    """Directions before the columns were shifted by a fraction of a turn."""
    sine, cosine = np.sin(2 * np.pi * turns), np.cos(2 * np.pi * turns)
    x, y, z = directions.T
    return np.stack([x * cosine + z * sine, y, z * cosine - x * sine], axis=1)


def basis(directions: Array, suns: Array) -> Array:
    """Basis functions of the sky at n directions for m suns, (m, n, 7)."""
    angle = np.arccos(np.clip(suns @ directions.T, -1, 1))
    low = np.broadcast_to(1 - directions[:, 1], angle.shape)
    columns = [np.ones_like(angle), np.log(angle + 0.05), np.exp(-2.5 * angle)]
    columns += [np.cos(angle) ** 2, low, low**2, low**6]
    return np.stack(columns, axis=-1)


class Fits(NamedTuple):
    """Robust fits for m suns."""

    coefficients: Array
    deviation: Array
    cost: Array


def robust_fits(functions: Array, values: Array, weight: Array) -> Fits:
    """Robust fits of `values`, (n,), by basis functions, (m, n, k)."""
    weights = np.broadcast_to(weight, functions.shape[:2])
    size = functions.shape[-1]
    for _ in range(_STEPS):
        weighed = functions * weights[..., None]
        normal = weighed.swapaxes(1, 2) @ functions
        ridge = _RIDGE * np.trace(normal, axis1=1, axis2=2) / size
        normal += ridge[:, None, None] * np.eye(size)
        right = weighed.swapaxes(1, 2) @ values
        coefficients = np.linalg.solve(normal, right[..., None])[..., 0]
        residuals = values - (functions @ coefficients[..., None])[..., 0]
        deviation = 1.4 * np.median(np.abs(residuals), axis=1) + 1e-3
        weights = weight / (1 + (residuals / (_OUTLIER * deviation[:, None])) ** 2)
    cost = _COST_SCALE * np.log1p((residuals / _COST_SCALE) ** 2) @ weight / weight.sum()
    return Fits(np.asarray(coefficients), np.asarray(deviation), cost + _NOISE)


class MeridianFit(NamedTuple):
    """Summary of the fits for the positions on a meridian."""

    fit: SkyFit
    """Fit for the best position."""
    mean: float
    """Mean elevation in degrees, weighted by cost and depth."""
    spread: float
    """Standard deviation of the elevation in degrees."""
    gain: float
    """Log ratio of the residual of elevation bands without a sun to that of the best fit."""
    deviation: float
    """Robust deviation of log luminance from the best fit."""


def fit_meridian(samples: SkySamples, suns: Array, depth: Array) -> MeridianFit:
    """Fit the sky for each of m suns on a meridian, (m, 3), with clipped depths (m,)."""
    functions = basis(samples.directions, suns)
    tones = [robust_fits(functions, samples.values(film), samples.weight) for film in (False, True)]
    best = [int(fits.cost.argmin()) for fits in tones]
    plain, film = (float(fits.deviation[at]) for fits, at in zip(tones, best, strict=True))
    is_film = bool(np.log(plain / film) + samples.stretch() > _LEAST_GAIN)
    fits, at = tones[is_film], best[is_film]
    values = samples.values(is_film)
    weight = (fits.cost.min() / fits.cost) ** _SHARPNESS * np.sqrt(np.maximum(depth, 0.1))
    weight /= weight.sum()
    elevation = np.degrees(np.arcsin(np.clip(suns[:, 1], -1, 1)))
    mean = float(weight @ elevation)
    bands = robust_fits(functions[:1, :, [0, 4, 5, 6]], values, samples.weight)
    residual = float(fits.deviation[at])
    return MeridianFit(
        SkyFit(suns[at], fits.coefficients[at], is_film, float(fits.cost[at] / values.std())),
        mean,
        float(np.sqrt(weight @ (elevation - mean) ** 2)),
        float(np.log(bands.deviation[0] / residual)),
        residual / np.exp(samples.stretch()) if is_film else residual,
    )
