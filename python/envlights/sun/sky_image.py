"""Reduced image of a clipped map, with the masks of its clipped core and its sky."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights.kernels.image import LUMINANCE
from envlights.kernels.sphere import pixel_directions, pixel_solid_angles

#: Largest number of columns. A sky is smooth, and its clipped regions are degrees wide.
COLUMNS = 512

#: Smallest fraction of fully clipped pixels for a cell in the core.
_CORE = 0.5
#: Fraction of pixels with a clipped channel above which neighbouring cells are not sky.
_TOUCHED = 0.25

#: Elevation in degrees above which sky is expected, because trees and houses are below.
_SKY_ABOVE = 3.0
#: Elevation in degrees above which the core may contain a sun.
_CORE_ABOVE = -1.0
#: Deviation of log luminance in 5x5 cells below which a cell is as smooth as sky.
_SMOOTH = 0.12
#: Smallest luminance of sky relative to the median of the smooth part above the horizon.
_LEAST_SKY = 0.25
#: Smallest ratio of blue to red in the sky; brick and wood have less.
_LEAST_BLUE = 0.75

#: Smallest luminance relative to the clip level, before the logarithm; an 8-bit code is 3e-4.
_DARK = 1e-4

Mask = NDArray[np.bool_]
Image = NDArray[np.float64]


@dataclass(frozen=True)
class SkyImage:
    """Radiance of a clipped map relative to its clip level, on at most 512 columns."""

    radiance: Image
    """Mean radiance of each cell, (height, width, 3)."""
    clipped: Image
    """Fraction of pixels per cell that are clipped in all channels, (height, width)."""
    touched: Image
    """Fraction of pixels per cell that are clipped in any channel, (height, width)."""
    peak: Image
    """Largest luminance of the pixels in each cell, (height, width)."""

    @cached_property
    def directions(self) -> Image:
        """Unit vector of each cell, (height, width, 3)."""
        return pixel_directions(*self.clipped.shape)

    @cached_property
    def solid_angles(self) -> Image:
        """Solid angle of each cell in steradians, (height, width)."""
        return pixel_solid_angles(*self.clipped.shape)

    @cached_property
    def elevation(self) -> Image:
        """Elevation of each row in degrees, (height, 1)."""
        height = len(self.clipped)
        return 90 - 180 * (np.arange(height)[:, None] + 0.5) / height

    @cached_property
    def luminance(self) -> Image:
        """Luminance of each cell, (height, width)."""
        values: Image = self.radiance @ LUMINANCE
        return values

    @cached_property
    def log(self) -> Image:
        """Logarithm of the luminance, (height, width)."""
        return np.log(np.maximum(self.luminance, _DARK))

    @cached_property
    def core(self) -> Mask:
        """Mask of clipped cells above the horizon."""
        return (self.clipped > _CORE) & (self.elevation > _CORE_ABOVE)

    @cached_property
    def is_touched(self) -> Mask:
        """Mask of cells with clipped pixels."""
        return self.touched > _TOUCHED

    @cached_property
    def depth(self) -> Image:
        """Degrees from each core cell to the nearest cell outside, with small gaps filled."""
        image = np.repeat(self.core[..., None].astype(np.float32), 3, axis=2)
        width = self.core.shape[1]
        return np.degrees(_native.clipped_depth(image, False, 1.0, width, 2 * np.pi / width))

    @cached_property
    def roughness(self) -> Image:
        """Standard deviation of log luminance in 5x5 cells around each cell."""
        mean = _mean_of_25(self.log)
        return np.sqrt(np.maximum(_mean_of_25(self.log**2) - mean**2, 0))

    @cached_property
    def sky(self) -> Mask:
        """Mask of the unclipped sky: above the horizon, smooth, neither dark nor brown."""
        near_clipped = _mean_of_9(self.is_touched.astype(float)) > 0.01
        smooth = (self.elevation > _SKY_ABOVE) & (self.roughness < _SMOOTH) & ~near_clipped
        if not smooth.any():
            return smooth
        level = float(np.median(self.luminance[smooth]))
        bright = self.luminance > _LEAST_SKY * level
        return smooth & bright & (self.radiance[..., 2] > _LEAST_BLUE * self.radiance[..., 0])


def sky_image(radiance: NDArray[np.float32], clip_level: float) -> SkyImage:
    """Reduced image of a map of cells, (height, 2 height, 3), clipped at `clip_level`."""
    height, width = radiance.shape[:2]
    columns = min(COLUMNS, width)
    rows = columns // 2
    least = np.float32(_native.LEAST_WHITE * clip_level)
    means, (clipped, touched, peak) = np.zeros((rows, columns, 3)), np.zeros((3, rows, columns))
    edges, starts = np.arange(rows + 1) * height // rows, np.arange(columns) * width // columns
    counts = np.diff(starts, append=width)
    for row, (top, bottom) in enumerate(pairwise(edges)):
        band = radiance[top:bottom]
        pixels = counts * len(band)
        sums = np.add.reduceat(band.sum(axis=0, dtype=np.float64), starts, axis=0)
        means[row] = sums / pixels[:, None] / clip_level
        red, green, blue = np.moveaxis(band >= least, 2, 0)
        for share, mask in ((clipped, red & green & blue), (touched, red | green | blue)):
            share[row] = np.add.reduceat(mask.sum(axis=0), starts) / pixels
        peak[row] = np.maximum.reduceat((band @ LUMINANCE).max(axis=0) / clip_level, starts)
    return SkyImage(means, clipped, touched, peak)


def _mean_of_25(image: Image) -> Image:
    return _box(image, 2)


def _mean_of_9(image: Image) -> Image:
    return _box(image, 1)


def _box(image: Image, reach: int) -> Image:
    """Mean over a square window; columns wrap at the seam, rows repeat at the poles."""
    size = 2 * reach + 1
    wide = np.pad(np.pad(image, ((reach, reach), (0, 0)), "edge"), ((0, 0), (reach, reach)), "wrap")
    height, width = image.shape
    rows = np.sum([wide[step : step + height] for step in range(size)], axis=0)
    columns = np.sum([rows[:, step : step + width] for step in range(size)], axis=0)
    mean: Image = columns / size**2
    return mean
