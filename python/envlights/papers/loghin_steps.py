"""Steps 3 to 9 of Loghin (2021) on a luminance image, of a map or of a photograph."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import amount, check_choice
from envlights.kernels import loghin, sampling

#: Points of the unit square by the name of their sequence.
SAMPLINGS: dict[str, Callable[[int], NDArray[np.float64]]] = {
    "hammersley": sampling.hammersley,
    "halton": sampling.halton,
}


@dataclass(frozen=True)
class BrightSamples:
    """Samples near a bright pixel, brightest first."""

    pixel: NDArray[np.int64]
    """Row and column of each sample, (k, 2)."""

    luminance: NDArray[np.float32]
    """Luminance of this pixel, (k,)."""

    own_pixel: NDArray[np.int64]
    """Pixel of each sample before it moved to a maximum, (k, 2)."""

    maximum: NDArray[np.int64]
    """Brightest pixel in the window of each sample, (k, 2)."""

    total: int
    """Number of all samples, dark ones included."""


class MergeRule(NamedTuple):
    """Options of steps 7 and 8."""

    apart: float
    """Distance below which a brighter sample suppresses another."""

    farthest: float
    """Distance beyond which samples are not merged."""

    tolerance: float
    """Largest difference of the mean of a line from the luminance of its start."""

    ceiling: float
    """Largest luminance of a pixel in the mean of a line."""

    bright: float
    """Mean of a line that is always bright enough."""


@dataclass(frozen=True)
class MergedSamples:
    """Lights as groups of samples."""

    means: NDArray[np.float64]
    """Mean of the points of each light, weighted by luminance, (n, d)."""

    peak: NDArray[np.int64]
    """Pixel of the brightest sample of each light, (n, 2)."""

    light: NDArray[np.int64]
    """Light of each sample, (k,)."""

    survivor: NDArray[np.int64]
    """Index of the sample that suppresses each, or its own, (k,)."""


def square_points(name: str, image: NDArray[np.float32], per_pixel: float) -> NDArray[np.float64]:
    """Step 3: points of the unit square, `per_pixel` for each pixel of an image, (n, 2)."""
    check_choice("sampling", name, tuple(SAMPLINGS))
    return SAMPLINGS[name](int(amount("samples_per_pixel", per_pixel, most=1.0) * image.size))


def bright_samples(
    image: NDArray[np.float32],
    pixel: NDArray[np.int64],
    reach: int,
    threshold: float,
    move_to_maximum: bool,
    sphere: bool,
) -> BrightSamples:
    """Steps 5 and 6: samples whose window holds a pixel above the threshold, brightest first."""
    brightest, place = loghin.neighbour_maximum(image, pixel, reach, sphere=sphere)
    is_bright = brightest > threshold
    own_pixel, place = pixel[is_bright], place[is_bright]
    moved = place if move_to_maximum else own_pixel
    luminance = image[moved[:, 0], moved[:, 1]]
    order = np.argsort(-luminance, kind="stable")
    arrays = moved[order], luminance[order], own_pixel[order], place[order]
    return BrightSamples(*arrays, total=len(pixel))


def climb(
    image: NDArray[np.float32], samples: BrightSamples, reach: int, least: float
) -> BrightSamples:
    """Samples moved until nothing in their window is brighter, if their maximum reaches `least`.

    Windows that end on the slope of a lamp would each report a maximum of their own.
    """
    pixel, luminance = samples.pixel, samples.luminance
    is_lower = np.ones(len(pixel), bool)
    while is_lower.any():
        brightest, place = loghin.neighbour_maximum(image, pixel, reach)
        is_lower = brightest > luminance
        pixel = np.where(is_lower[:, None], place, pixel)
        luminance = np.where(is_lower, brightest, luminance)
    rows = np.argsort(-luminance, kind="stable")
    rows = rows[luminance[rows] >= least]
    arrays = pixel[rows], luminance[rows], samples.own_pixel[rows], pixel[rows]
    return BrightSamples(*arrays, total=samples.total)


def merged_samples(
    image: NDArray[np.float32],
    samples: BrightSamples,
    points: NDArray[np.float64],
    rule: MergeRule,
    sphere: bool,
) -> MergedSamples:
    """Steps 7 to 9: suppress samples near brighter ones, merge along lines, take means.

    `points` are the positions of the samples, in a plane or on the sphere.
    """
    survivor_of = loghin.suppress(points, rule.apart)
    survivors = np.unique(survivor_of)
    merged_into = loghin.merge_along_lines(
        image,
        samples.pixel[survivors],
        tolerance=rule.tolerance,
        ceiling=rule.ceiling,
        bright=rule.bright,
        points=points[survivors],
        farthest=rule.farthest,
        sphere=sphere,
    )
    means = loghin.weighted_means(points[survivors], samples.luminance[survivors], merged_into)
    peaks, light = np.unique(merged_into, return_inverse=True)
    return MergedSamples(
        means=means,
        peak=samples.pixel[survivors[peaks]],
        light=light[np.searchsorted(survivors, survivor_of)],
        survivor=survivor_of,
    )


def sums_of_lights(
    values: NDArray[np.float64], light: NDArray[np.int64], lights: int
) -> NDArray[np.float64]:
    """Sum of the rows of `values`, (k, d), over each light, (n, d)."""
    columns = [np.bincount(light, column, minlength=lights) for column in values.T]
    return np.stack(columns, axis=1)
