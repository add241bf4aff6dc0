"""Light of a map: irradiance and harmonics, with a fill for uncovered parts."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import amount, check_choice, count, one_or_more
from envlights.environment.coverage import note_of_coverage
from envlights.environment.fill import (
    Fill,
    PartialMap,
    checked_unseen,
    choice_of,
    fill_part,
    note_of_fill,
    share_above_horizon,
)
from envlights.environment.harmonics import CONVENTIONS, in_convention, map_harmonics
from envlights.environment.pixels import MapPixels
from envlights.kernels.image import LUMINANCE
from envlights.kernels.probe import irradiance
from envlights.kernels.sphere import pixel_solid_angles

#: Upward unit normal.
_UP = np.array([0.0, 1.0, 0.0])


def probe(pixels: MapPixels, normals: ArrayLike, fill: Fill) -> NDArray[np.float64]:
    """Irradiance of surfaces with the given `normals`; see `EnvMap.probe`."""
    rows, is_one = one_or_more("normals", normals)
    radiance = with_fill(pixels, fill).radiance
    values = irradiance(radiance, rows, border_sampled=pixels.is_border_sampled)
    return values[0] if is_one else values


def harmonics(pixels: MapPixels, degree: int, convention: str, fill: Fill) -> NDArray[np.float64]:
    """Spherical harmonics up to a degree; see `EnvMap.harmonics`."""
    count("degree", degree, most=2)
    check_choice("convention", convention, CONVENTIONS)
    radiance = with_fill(pixels, fill).radiance
    rows = in_convention(map_harmonics(radiance, pixels.is_border_sampled), convention)
    return rows[: (degree + 1) ** 2]


def mean_radiance(
    radiance: NDArray[np.float32], border_sampled: bool, coverage_fraction: float = 1.0
) -> NDArray[np.float64]:
    """Mean radiance over the covered part of the sphere, (3,)."""
    height, width, _ = radiance.shape
    rows = pixel_solid_angles(height, 2, border_sampled=border_sampled).sum(axis=1)
    columns = np.ones(width)
    if border_sampled:
        columns[[0, -1]] = 0.5  # the seam
    sums = rows.astype(np.float32) @ radiance.reshape(height, -1)
    mean: NDArray[np.float64] = columns @ sums.reshape(width, 3) / columns.sum()
    return mean / (4 * np.pi * (coverage_fraction or 1.0))


def with_fill(pixels: MapPixels, fill: Fill, albedo: float = 0.25) -> MapPixels:
    """Pixels with radiance filled in where the map shows nothing; see `EnvMap.filled`."""
    amount("albedo", albedo, most=1.0)
    if pixels.coverage is None:
        checked_unseen(fill)
        return pixels
    part = _part_of(pixels, pixels.coverage)
    fraction = part.fraction
    choice = choice_of(fill, fraction)
    of_unseen = note_of_coverage(fraction)
    notes = [note for note in pixels.notes if note != of_unseen]
    notes.append(note_of_fill(choice, fraction, albedo))
    return pixels.changed(fill_part(part, choice, albedo), None, notes)


def from_unseen(
    pixels: MapPixels, fill: Fill, normal: NDArray[np.float64] | None = None
) -> tuple[float, list[str]]:
    """Luminance of the irradiance that a fill adds in a clipped map, and notes.

    The surface faces a unit vector; up when left out.
    """
    checked_unseen(fill)
    if pixels.coverage is None or not pixels.clipped_fractions[0]:
        return 0.0, []
    part = _part_of(pixels, pixels.coverage)
    fraction = part.fraction if normal is not None else share_above_horizon(part)
    whole = with_fill(pixels, choice_of(fill, fraction))
    normal = _UP if normal is None else normal
    whole_light, own_light = (
        float(probe(of, normal, "black") @ LUMINANCE) for of in (whole, pixels)
    )
    return whole_light - own_light, [f"for the irradiance of the surface, {whole.notes[-1]}"]


def _part_of(pixels: MapPixels, coverage: NDArray[np.float32]) -> PartialMap:
    return PartialMap(pixels.radiance, coverage, pixels.is_border_sampled)
