"""Spherical harmonics of maps and discs, and their inner products by degree.

Up to `DEGREE` they are those of all light. Shadows also see the size of a sun in degrees beyond,
where only discs and the brightest pixels have light.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights.environment.envmap import EnvMap
from envlights.kernels.harmonics import expand_discs, expand_map
from envlights.kernels.sphere import pixel_solid_angles, uv_to_direction

#: Highest degree for maps, and for small discs. Degrees above 100 hold 0.01 % of the energy of a
#: point at roughness 0.3271, but up to 30 % of the shadow error of a rig under a sun.
DEGREE, FINE_DEGREE = 100, 2000
#: Largest number of map rows whose harmonics are computed; larger maps are reduced. With 256 rows,
#: a gloss error was 42 % too large under a sun.
MOST_ROWS = 1024
#: Largest radius in radians of discs that are expanded beyond `DEGREE`, where larger ones hold 0.3
#: % of their energy; and smallest fraction of a channel's flux for such a cell. With 1e-3, a shadow
#: error under a sun with its glow was 5 % too large instead of 3 %.
_MOST_RADIUS, _LEAST_FRACTION = 0.05, 3e-4
#: Largest number of cells, 2 x 2 pixels of a map of `MOST_ROWS`, that are expanded beyond `DEGREE`:
#: as many as such a disc has. With 64, a shadow error under a lamp of 0.044 radians was 0.0041
#: instead of 0.0028.
_MOST_CELLS = int(np.pi * (_MOST_RADIUS * MOST_ROWS / (2 * np.pi)) ** 2)


class Discs(NamedTuple):
    """Discs of uniform radiance."""

    direction: NDArray[np.float64]
    """Unit vectors, (n, 3)."""

    irradiance: NDArray[np.float64]
    """Irradiance at normal incidence, (n, 3)."""

    radius: NDArray[np.float64]
    """Angular radii in radians, (n,)."""

    def harmonics(self) -> NDArray[np.float64]:
        """Coefficients up to `DEGREE`; see `kernels.expand_discs`."""
        return expand_discs(*self, DEGREE)

    def small(self) -> Discs:
        """Discs small enough to be expanded beyond `DEGREE`."""
        is_small = self.radius <= _MOST_RADIUS
        return Discs(*(each[is_small] for each in self))


def of_map(radiance: NDArray[np.floating]) -> NDArray[np.float64]:
    """Coefficients of cell-centred pixels; see `kernels.expand_map`."""
    return expand_map(radiance, DEGREE)


def bright_parts(radiance: NDArray[np.float32]) -> Discs:
    """Bright pixels of a map, grouped into cells and replaced by discs of equal flux and extent."""
    solid_angles = pixel_solid_angles(*radiance.shape[:2])
    block = -(-2 * len(radiance) // MOST_ROWS)
    pixels = _bright_pixels(radiance, solid_angles, block)
    rows, columns = np.array(pixels)
    if not len(rows):
        return Discs(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))
    # Use equal squares from the first pixel on, or whole cells. A few discs instead of whole pixels
    # have too much energy beyond `DEGREE`: 41 % of a shadow error.
    count = _MOST_CELLS / (2 * len(rows))
    sine = np.sin(np.pi * (rows[0] + 0.5) / len(radiance))
    tall = int(max(np.sqrt(count / sine), 1))
    wide = int(max(count / tall, 1))
    down, right = (np.arange(n) / n + 0.5 / n for n in (tall, wide))
    v = np.repeat(rows[:, None] + down, wide, axis=1) / radiance.shape[0]
    u = np.tile(columns[:, None] + np.tile(right, tall), 1) / radiance.shape[1]
    areas = solid_angles[pixels].repeat(tall * wide) / (tall * wide)
    flux = radiance[pixels].repeat(tall * wide, axis=0) * areas[:, None]
    directions = uv_to_direction(np.stack([u.ravel(), v.ravel()], axis=-1))
    # Near a pole, pixels are slivers: squares are parts of rows that span columns. A shadow error
    # under a sun at 84 degrees was 10 % too large with slivers.
    high = block if tall == 1 and count <= 1 else 1
    long = int(max(tall / count, 1)) if tall > 1 else high
    parts = rows[:, None] // high * tall + np.arange(tall)
    cells = parts * radiance.shape[1] + (columns // long)[:, None]
    groups = np.arange(len(flux))
    if long > 1:
        groups = np.unique(cells.ravel(), return_inverse=True)[1]
    return merge(directions, flux, areas, groups)


def _bright_pixels(
    radiance: NDArray[np.float32], solid_angles: NDArray[np.float64], block: int
) -> tuple[NDArray[np.intp], ...]:
    """Rows and columns of the pixels in the brightest cells, each `block` by `block` pixels."""
    shape = solid_angles.shape
    fraction = np.zeros(shape)
    for channel in np.moveaxis(radiance, 2, 0):
        flux = channel * solid_angles
        np.maximum(fraction, flux / max(flux.sum(), np.finfo(float).tiny), out=fraction)
    sums = np.add.reduceat(fraction, range(0, shape[0], block), axis=0)
    sums = np.add.reduceat(sums, range(0, shape[1], block), axis=1)
    brightest = np.argsort(-sums, axis=None, kind="stable")[:_MOST_CELLS]
    is_bright = np.zeros(sums.shape, bool)
    is_bright.flat[brightest] = sums.flat[brightest] > _LEAST_FRACTION
    is_bright = is_bright.repeat(block, axis=0).repeat(block, axis=1)
    return np.nonzero(is_bright[: shape[0], : shape[1]] & (fraction > 0))


def merge(
    directions: NDArray[np.float64],
    flux: NDArray[np.float64],
    areas: NDArray[np.float64],
    groups: NDArray[np.intp],
) -> Discs:
    """Disc for each group of small squares, with the same flux and extent."""
    # The mean cosine to the centre is 1 - area / 12 in a square, and cos^2 (radius / 2) in a disc.
    whole = flux.sum(axis=1, keepdims=True)
    vectors = _sums(whole * (1 - areas[:, None] / 12) * directions, groups)
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    cosine = lengths / _sums(whole, groups)
    radius = 2 * np.arccos(np.sqrt(cosine[:, 0]))
    return Discs(vectors / lengths, _sums(flux, groups) * cosine, radius)


def _sums(values: NDArray[np.float64], groups: NDArray[np.intp]) -> NDArray[np.float64]:
    """Sum of the rows of each group."""
    return np.stack([np.bincount(groups, column) for column in values.T], axis=-1)


def products(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.float64]:
    """Inner product per degree, summed over orders and channels, (degree,)."""
    by_degree: NDArray[np.float64] = (one * other).sum(axis=(0, 2))
    return by_degree


def fine_products(one: Discs, other: Discs) -> NDArray[np.float64]:
    """Inner products for degrees from `DEGREE` + 1 to `FINE_DEGREE`, by the addition theorem."""
    one, other = one.small(), other.small()
    cosines = np.clip(one.direction @ other.direction.T, -1, 1)
    out = np.empty(FINE_DEGREE - DEGREE)
    weights = [_fluxes_by_degree(discs) for discs in (one, other)]
    for degree, values in enumerate(_legendre(cosines, FINE_DEGREE)):
        if degree > DEGREE:
            a, b = (each[degree] for each in weights)
            out[degree - DEGREE - 1] = (2 * degree + 1) / (4 * np.pi) * (a * (values @ b)).sum()
    return out


def _fluxes_by_degree(discs: Discs) -> NDArray[np.float64]:
    """Flux times the mean of each Legendre polynomial over each disc, (degree, n, 3)."""
    # Limit the radius, because differences of polynomials vanish by rounding for smaller discs.
    radius = np.maximum(discs.radius, 1e-5)
    values = np.stack(list(_legendre(np.cos(radius), FINE_DEGREE + 1)))
    degrees = np.arange(1, FINE_DEGREE + 1)[:, None]
    area = 2 * np.sin(radius / 2) ** 2
    means = (values[:-2] - values[2:]) / ((2 * degrees + 1) * area)
    flux = discs.irradiance / np.cos(radius / 2)[:, None] ** 2
    out: NDArray[np.float64] = np.concatenate([np.ones((1, len(radius))), means])[..., None] * flux
    return out


def _legendre(x: NDArray[np.float64], degree: int) -> Iterator[NDArray[np.float64]]:
    """Legendre polynomials of each degree from 0 to `degree`."""
    before, value = np.zeros_like(x), np.ones_like(x)
    for k in range(degree + 1):
        yield value
        before, value = value, ((2 * k + 1) * x * value - k * before) / (k + 1)


def reduce_cells(radiance: NDArray[np.float32], rows: int) -> NDArray[np.float32]:
    """Map reduced to at most `rows` rows, by area means."""
    return radiance if len(radiance) <= rows else EnvMap(radiance).resized(2 * rows).cells()
