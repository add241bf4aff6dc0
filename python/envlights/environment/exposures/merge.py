"""Weighted mean of linear exposures, and detection of contradictory pixels.

What is uncertain about a sample is a step of a code, dE, so weights are (t / dE)^2 times a ramp
that ends below white. JPEG rings around clipped regions, with samples below white inside them. Near
such a region a longer exposure counts only where the shorter ones prove it dark.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from envlights._common.srgb import code_step

#: Exposures relative to the clip level at which weights begin to fall, and reach 0. JPEG of quality
#: 90 moves the clip level to 0.9.
_FULL, _NONE = 0.5, 0.92
#: 8-bit code below which weights fall.
_DARK = 8.0
#: Smallest weight of a dark sample, so that at least one exposure counts.
_LEAST_DARK = 1e-3
#: Smallest weight of an unclipped linear sample: no compression has moved its value.
_LEAST_BRIGHT = 1e-2
#: Exposure, predicted from shorter pictures, above which samples near a clipped region are ignored.
_MOST_NEAR = 0.5
#: Exposure limit for the rim of a clipped region, which may be blurred.
_MOST_AT_RIM = 0.1
#: Ratio of variances near a clipped region and elsewhere, for ringing of 5 codes.
_RINGING = 25.0
#: Width in pixels of the rim of a clipped region.
_RIM = 2
#: Distance in pixels over which JPEG rings around a clipped region, and columns per pixel of
#: distance.
_DISTANCE, _COLUMNS_EACH = 8, 512
#: Range of samples that are used to compare exposures.
_LEAST_COMPARED, _MOST_COMPARED = 0.02, 0.94
#: Ratio above which exposures contradict each other, and error of a JPEG sample in codes.
_CONTRADICTION, _NOISE = 1.3, 4.0
#: Number of rows that are processed at once, to limit memory.
_ROWS = 64


@dataclass(eq=False)
class Exposure:
    """Linear exposure of one picture."""

    time: float
    """Exposure time."""

    linear: NDArray[np.float32]
    """Exposure of each sample relative to the clip level of the series, (height, width, 3)."""

    clip_level: float
    """Clip level, as an exposure."""

    clip: float
    """Exposure from which samples count as clipped."""

    clipped: NDArray[np.bool_]
    """Mask of clipped samples, (height, width, 3)."""

    rings: bool
    """True if the picture may be a JPEG, with ringing."""

    def __post_init__(self) -> None:
        any_channel: NDArray[np.bool_] = np.asarray(self.clipped.any(axis=2))
        reach = distance(any_channel.shape[1]) if self.rings else _RIM
        self.rim: NDArray[np.bool_] = dilate(any_channel, _RIM if self.rings else 0)
        self.near: NDArray[np.bool_] = dilate(any_channel, reach)


def distance(width: int) -> int:
    """Distance in pixels around a clipped region in which samples are doubtful."""
    return max(_DISTANCE, width // _COLUMNS_EACH)


def dilate(mask: NDArray[np.bool_], reach: int) -> NDArray[np.bool_]:
    """Mask dilated by a square of radius `reach`; columns wrap at the seam."""
    if reach == 0 or not mask.any():
        return mask
    rows = _counts(np.pad(mask, ((reach, reach), (0, 0))), reach, 0)
    around = np.pad(rows > 0, ((0, 0), (reach, reach)), mode="wrap")
    return _counts(around, reach, 1) > 0


def _counts(mask: NDArray[np.bool_], reach: int, axis: int) -> NDArray[np.int32]:
    """Number of true pixels in a sliding window along an axis."""
    sums = np.cumsum(mask, axis=axis, dtype=np.int32)
    zero = np.zeros_like(np.take(sums, [0], axis=axis))
    sums = np.concatenate([zero, sums], axis=axis)
    window = 2 * reach + 1
    ends = np.arange(window, sums.shape[axis])
    counts: NDArray[np.int32] = np.take(sums, ends, axis=axis)
    return counts - np.take(sums, ends - window, axis=axis)


def merge(exposures: list[Exposure]) -> tuple[NDArray[np.float32], NDArray[np.bool_], bool]:
    """Radiance for 1 s, mask of contradictory pixels, and True if radiance was clipped.

    Exposures are sorted, shortest first.
    """
    merged = np.empty_like(exposures[0].linear)
    is_moved = np.zeros(merged.shape[:2], bool)
    is_lost = False
    for top in range(0, len(merged), _ROWS):
        rows = slice(top, top + _ROWS)
        merged[rows], is_moved[rows], lost = _merge_rows(exposures, rows)
        is_lost |= lost
    return merged, is_moved, is_lost


def _merge_rows(
    exposures: list[Exposure], rows: slice
) -> tuple[NDArray[np.float64], NDArray[np.bool_], bool]:
    times = np.array([each.time for each in exposures])[:, None, None, None]
    linear = np.stack([each.linear[rows] for each in exposures]).astype(np.float64)
    radiance = linear / times
    weight = _weights(exposures, rows, radiance)
    # Use the shortest exposure where no exposure has weight.
    alone = (weight == 0).all(axis=0)
    weight[0][alone] = 1
    mean = (weight * radiance).sum(axis=0) / weight.sum(axis=0)
    is_moved, best = _contradictions(exposures, rows, linear, radiance, weight)
    mean = np.where(is_moved[..., None], best, mean)
    # Set samples that are clipped in the shortest exposure to its clip level.
    shortest = exposures[0]
    lost = alone & shortest.clipped[rows]
    mean = np.where(lost, shortest.clip_level / shortest.time, mean)
    return mean, is_moved, bool(lost.any())


def _weights(
    exposures: list[Exposure], rows: slice, radiance: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Weights of all samples, (exposures, rows, width, 3)."""
    weights = np.zeros_like(radiance)
    total, light = np.zeros(radiance.shape[1:]), np.zeros(radiance.shape[1:])
    for place, exposure in enumerate(exposures):
        linear = radiance[place] * exposure.time
        weight = _ramp(linear, exposure) * (exposure.time / code_step(linear)) ** 2
        weight[exposure.clipped[rows]] = 0
        near = exposure.near[rows]
        if near.any():
            # Predict the exposure from the shorter pictures.
            known = np.where(total > 0, light / np.maximum(total, 1e-300), radiance[0])
            expected = (known * exposure.time).max(axis=2) / exposure.clip
            limit = np.where(exposure.rim[rows], _MOST_AT_RIM, _MOST_NEAR)
            is_out = near & (expected > limit)
            weight[is_out] = 0
            weight[near] /= _RINGING
        weights[place] = weight
        total += weight
        light += weight * radiance[place]
    return weights


def _ramp(linear: NDArray[np.float64], exposure: Exposure) -> NDArray[np.float64]:
    """Weight factor that falls towards the clip level and towards black."""
    towards_white = np.clip((_NONE - linear / exposure.clip) / (_NONE - _FULL), 0, 1)
    if not exposure.rings:
        return np.maximum(towards_white, _LEAST_BRIGHT)
    dark = _DARK / 255 / 12.92
    return towards_white * np.clip(linear / dark, _LEAST_DARK, 1)


def _contradictions(
    exposures: list[Exposure],
    rows: slice,
    linear: NDArray[np.float64],
    radiance: NDArray[np.float64],
    weight: NDArray[np.float64],
) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
    """Mask of pixels that contradict the best exposure, and the radiance of the best one."""
    clips = np.array([each.clip for each in exposures])[:, None, None, None]
    near = np.stack([each.near[rows] for each in exposures])[..., None]
    is_good = (linear > _LEAST_COMPARED) & (linear < _MOST_COMPARED * clips) & ~near
    best = np.argmax(weight, axis=0)[None]
    alone = np.take_along_axis(radiance, best, axis=0)
    noise = np.where(is_good, _NOISE / 255 * code_step(linear) / np.maximum(linear, 1e-9), 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = radiance / alone
        differs = np.maximum(ratio, 1 / ratio) > _CONTRADICTION + noise
    is_good &= np.take_along_axis(is_good, best, axis=0)
    is_moved: NDArray[np.bool_] = np.asarray((differs & is_good).any(axis=(0, 3)))
    return is_moved, alone[0]
