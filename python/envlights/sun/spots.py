"""Search for a single small clipped spot in smooth sky: the sun in a picture without glare."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights.kernels.image import LUMINANCE
from envlights.sun.sky_image import SkyImage

#: Smallest peak luminance of a spot relative to the clip level: JPEG darkens single pixels by 3 %.
_LEAST_PEAK = 0.96
#: Inner and outer radius of the ring around a spot, in degrees.
_INNER, _OUTER = 1.5, 3.5
#: Largest luminance of the ring, at its 95 % quantile, relative to the peak of the spot.
_MOST_RING = 0.95
#: Largest deviation of log luminance in the ring from a plane plus a glow; clouds exceed it.
_SMOOTH_RING = 0.03
#: Largest fraction of clipped pixels in the ring; noise of a bright sky clips a few.
_MOST_CLIPPED = 0.02
#: Elevation in degrees below which spots are ignored.
_ABOVE = 3.0
#: Largest number of candidates; a picture with more has no isolated spot.
_MOST_PLACES = 256

Array = NDArray[np.float64]


def single_spot(image: SkyImage, radiance: NDArray[np.float32], clip_level: float) -> Array | None:
    """Direction of the only spot of a map clipped at `clip_level`; None unless exactly one.

    `radiance` holds the cells of the map, (height, 2 height, 3).
    """
    places = _peaks(image)
    if len(places) > _MOST_PLACES:
        return None
    found: list[Array] = []
    for row, column in places:
        direction = image.directions[row, column]
        if all(each @ direction < np.cos(np.radians(_INNER)) for each in found) and _is_lonely(
            image, row, column
        ):
            found.append(direction)
    if len(found) != 1:
        return None
    return _centre(radiance, np.float32(clip_level), found[0])


def _peaks(image: SkyImage) -> NDArray[np.intp]:
    """Cells with a bright pixel, brightest first, in columns that are unclipped nearby."""
    is_peak = (image.peak >= _LEAST_PEAK) & (image.elevation > _ABOVE)
    height = len(is_peak)
    step = int(np.ceil(_INNER / 180 * height)) + 1
    rows, columns = np.nonzero(is_peak)
    above, below = np.maximum(rows - step, 0), np.minimum(rows + step, height - 1)
    free = (image.clipped[above, columns] == 0) & (image.clipped[below, columns] == 0)
    rows, columns = rows[free], columns[free]
    order = np.lexsort((columns, rows, -image.peak[rows, columns]))
    return np.stack([rows, columns], axis=1)[order]


def _is_lonely(image: SkyImage, row: int, column: int) -> bool:
    """True for a bright cell within a ring of smooth, blue, unclipped sky."""
    reach = int(np.ceil(_OUTER / 180 * len(image.core)))
    rows = slice(max(row - reach, 0), row + reach + 1)
    cosine = image.directions[rows] @ image.directions[row, column]
    ring = (cosine < np.cos(np.radians(_INNER))) & (cosine > np.cos(np.radians(_OUTER)))
    # Also count pixels clipped in one channel, because JPEG darkens an isolated pixel.
    clipped = image.clipped if image.clipped[row, column] else image.touched
    if np.count_nonzero(ring) < 16 or clipped[rows][ring].mean() > _MOST_CLIPPED:
        return False
    if np.quantile(image.luminance[rows][ring], 0.95) > _MOST_RING * image.peak[row, column]:
        return False
    red, blue = image.radiance[rows][ring][:, [0, 2]].mean(axis=0)
    return bool(blue > red and _deviation(image, rows, ring, cosine) < _SMOOTH_RING)


def _deviation(image: SkyImage, rows: slice, ring: NDArray[np.bool_], cosine: Array) -> float:
    """Robust deviation of log luminance in a ring from a plane plus a cone, the glow of a sun."""
    cone = np.arccos(cosine[ring])
    functions = np.column_stack([image.directions[rows][ring], cone])
    values = image.log[rows][ring]
    residual = values - functions @ np.linalg.lstsq(functions, values, rcond=None)[0]
    return float(1.48 * np.median(np.abs(residual)))


def _centre(radiance: NDArray[np.float32], clip_level: np.float32, near: Array) -> Array:
    """Centroid of the excess radiance around a direction, at full resolution."""
    height, width = radiance.shape[:2]
    middle = int(np.arccos(np.clip(near[1], -1, 1)) / np.pi * height)
    reach = int(np.ceil(_OUTER / 180 * height)) + 1
    rows = slice(max(middle - reach, 0), min(middle + reach + 1, height))
    directions = _native.pixel_directions(height, width, False, rows.start, rows.stop)
    cosine = directions @ near
    inside, ring = cosine > np.cos(np.radians(_INNER)), cosine > np.cos(np.radians(_OUTER))
    luminance = radiance[rows] @ LUMINANCE / clip_level
    background = np.median(luminance[ring & ~inside])
    peak = luminance[inside].max()
    # Subtract half of the peak height, to exclude the noise of the ring.
    excess = np.maximum(luminance - 0.5 * (peak + background), 0) * inside
    weight = excess * np.sqrt(1 - directions[..., 1] ** 2)
    sum_ = (directions * weight[..., None]).sum(axis=(0, 1))
    direction: Array = sum_ / np.linalg.norm(sum_)
    return direction
