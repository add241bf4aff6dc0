"""Clip level of each picture, from the highest spike of its histogram.

Cameras and raw converters end at codes below 255. JPEG spreads the spike over a few codes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights._common.srgb import decode_srgb, encode_srgb
from envlights.environment.exposures.pictures import Picture

#: Number of codes on each side over which JPEG spreads a spike.
_REACH = 2
#: Lowest accepted clip code: if no other exposure confirms it, and at all.
_LEAST_ALONE, _LEAST_CODE = 250, 233
#: Smallest ratio of the count in a spike to the median count of equally many codes below it.
_PROMINENCE = 2.0
#: Smallest number of samples in a spike.
_FEWEST = 6
#: Ratio of predicted exposure to clip level at which a shorter exposure confirms a spike.
_CONFIRMED = 1.3
#: Difference in code between the clip levels of two pictures of one camera.
_SAME = 3
#: Number of codes by which JPEG moves the spike of a small clipped region.
_BLURRED = 8


def whites(pictures: list[Picture]) -> list[float]:
    """Clip level per picture, shortest exposure first; infinity if linear and unlimited."""
    if pictures[0].is_linear:
        return [_linear_white(picture.samples) for picture in pictures]
    counts = [histogram(picture.samples) for picture in pictures]
    own = _confirmed_spikes(pictures, [spike(each) for each in counts])
    common = spike(np.sum(counts[1:], axis=0))
    if common is None or not any(code is not None for code in own):
        common = max((code for code in own if code is not None), default=255)
    return [_level(code, each, common) / 255 for code, each in zip(own, counts, strict=True)]


def _level(own: int | None, counts: NDArray[np.int64], common: int) -> int:
    """Clip code: the picture's own spike if it is sharp, otherwise that of the series."""
    if own is not None:
        around = counts[max(own - _REACH, 0) : own + _REACH + 1].sum()
        is_sharp = 2 * counts[own] > around
        return own if is_sharp or abs(own - common) > _BLURRED else common
    above = counts[common + _BLURRED :].sum()
    is_beyond = above > 5 * counts[common - _BLURRED : common + _BLURRED].sum()
    return int(np.flatnonzero(counts)[-1]) if is_beyond else common


def _confirmed_spikes(pictures: list[Picture], codes: list[int | None]) -> list[int | None]:
    for place in range(1, len(codes)):
        shorter, longer = pictures[place - 1 : place + 1]
        code = codes[place]
        if code is not None and not _is_exceeded(shorter, longer, code):
            codes[place] = None
    first, others = codes[0], [code for code in codes[1:] if code is not None]
    least = _LEAST_CODE if not others else _LEAST_ALONE
    is_common = first is not None and any(abs(first - code) <= _SAME for code in others)
    if first is not None and first < least and not is_common:
        codes[0] = None
    return codes


def histogram(codes: NDArray[np.float32]) -> NDArray[np.int64]:
    """Number of samples at each of 256 codes, over all channels."""
    counts = np.zeros(256, np.int64)
    for row in codes:
        whole = (row * np.float32(255) + np.float32(0.5)).astype(np.uint8)
        counts += np.bincount(whole.ravel(), minlength=256)
    return counts


def spike(counts: NDArray[np.int64]) -> int | None:
    """Code of the highest spike of a histogram; None if there is no spike."""
    near = np.convolve(counts, np.ones(2 * _REACH + 1, np.int64), mode="same")
    above = counts[::-1].cumsum()[::-1]
    best: int | None = None
    for code in range(_LEAST_CODE, 256):
        below = float(np.median(near[code - 40 : code - 3 * _REACH]))
        rest = int(above[code + _REACH + 1]) if code + _REACH < 255 else 0
        is_spike = near[code] >= max(_PROMINENCE * below, _FEWEST) and 2 * rest <= near[code]
        if is_spike and (best is None or near[code] > near[best]):
            best = code
    if best is None:
        return None
    around = range(max(best - _REACH, 0), min(best + _REACH, 255) + 1)
    return max(around, key=lambda code: (counts[code], code))


def _is_exceeded(shorter: Picture, longer: Picture, code: int) -> bool:
    """True if the shorter exposure predicts more than the spike of the longer one."""
    at_spike = longer.samples >= (code - _SAME - 0.5) / 255
    if not at_spike.any():
        return False
    expected = decode_srgb(np.quantile(shorter.samples[at_spike], [0.75]))[0]
    ratio = longer.time / shorter.time
    return bool(expected * ratio > _CONFIRMED * decode_srgb(np.array([code / 255]))[0])


def _linear_white(samples: NDArray[np.float32]) -> float:
    """Clip level of linear samples: 1, or the spike at the top of samples that exceed 1."""
    most = float(samples.max())
    if most <= 1.02:
        return 1.0
    code = spike(histogram(encode_srgb(samples / most).astype(np.float32)))
    return np.inf if code is None else most * float(decode_srgb(np.array([code / 255]))[0])
