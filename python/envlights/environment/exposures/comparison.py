"""Codes at which two exposures show the same radiance, found by histogram matching.

Grossberg and Nayar 2003, "What can be known about the radiometric response from images?". Equal
fractions of the pixels are above equal radiances, so neither shifts nor small motions matter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

#: Number of histogram bins: 8-bit codes.
LEVELS = 256
#: Darkest code to compare; its noise is 10 %.
_DARKEST = 20 / 255
#: Distance of the brightest code to the clip level, which JPEG moves by several codes.
_TO_WHITE = 16 / 255
#: Smallest number of pixels that two exposures must share.
_FEWEST = 16
#: Largest number of pixels to compare; more only take time.
_MOST = 2**20


@dataclass(frozen=True, eq=False)
class Comparison:
    """Pairs of codes of two exposures at the same radiance, concatenated over the channels."""

    short: int
    """Index of the shorter exposure."""

    long: int
    """Index of the longer exposure."""

    channel: NDArray[np.int64]
    """Channel of each pair, (n,)."""

    low: NDArray[np.float64]
    """Codes of the shorter exposure, (n,)."""

    high: NDArray[np.float64]
    """Codes of the longer exposure, (n,)."""

    count: NDArray[np.float64]
    """Number of pixels per pair."""


def comparisons(
    samples: list[NDArray[np.float32]], near: list[NDArray[np.bool_]], whites: list[float]
) -> list[Comparison]:
    """Comparisons of all exposures that share enough pixels.

    `near` marks pixels near clipped regions, where JPEG rings; they do not count.
    """
    step = int(np.ceil(np.sqrt(near[0].size / _MOST)))
    samples = [each[::step, ::step] for each in samples]
    away = [~each[::step, ::step] for each in near]
    found = []
    for long in range(1, len(samples)):
        for short in range(long):
            both = away[short] & away[long]
            pair = _compare([samples[place][both] for place in (short, long)], whites, short, long)
            found += [] if pair is None else [pair]
    return found


def _compare(
    samples: list[NDArray[np.float32]], whites: list[float], short: int, long: int
) -> Comparison | None:
    found = []
    for channel in range(3):
        low, high, count = _match(*(_histogram(each[:, channel]) for each in samples))
        is_good = (low >= _DARKEST) & (low <= whites[short] - _TO_WHITE)
        is_good &= (high >= _DARKEST) & (high <= whites[long] - _TO_WHITE)
        found.append([np.full(is_good.sum(), channel), low[is_good], high[is_good], count[is_good]])
    channels, low, high, count = (np.concatenate(parts) for parts in zip(*found, strict=True))
    if count.sum() < 3 * _FEWEST:
        return None
    return Comparison(short, long, channels, low, high, count)


def _histogram(codes: NDArray[np.float32]) -> NDArray[np.int64]:
    whole = np.clip(codes * np.float32(LEVELS - 1) + np.float32(0.5), 0, LEVELS - 1)
    return np.bincount(whole.astype(np.uint8), minlength=LEVELS)


def _match(
    short: NDArray[np.int64], long: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Codes at equal quantiles of two histograms, and their counts."""
    low, high = np.flatnonzero(short), np.flatnonzero(long)
    if not high.size:
        low = high
        return low / 1.0, low / 1.0, low / 1.0
    rank = np.cumsum(short) - short / 2
    ranks = np.cumsum(long) - long / 2
    matched = np.interp(rank[low], ranks[high], high)
    return low / (LEVELS - 1), matched / (LEVELS - 1), short[low].astype(np.float64)
