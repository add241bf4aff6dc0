"""Azimuth of the sun by symmetry: a sky is mirror-symmetric about the meridian of the sun."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

#: Largest azimuth difference between the meridian and a pair of cells, in degrees.
_REACH = 100.0
#: Smallest number of pairs for a meridian, as a fraction of the cells in a hemisphere of sky.
_LEAST_PAIRS = 0.02
#: Largest number of meridians to test, which limits the time for wide regions.
_MOST_MERIDIANS = 128
#: Exponent of the cost ratio in the weight of a meridian, and cost of noise.
_SHARPNESS, _NOISE = 8, 0.005
#: Fraction of the largest depth below which a meridian is not tested.
_SHALLOW = 0.2


class Meridian(NamedTuple):
    """Meridian with the best symmetry."""

    column: float
    """Column coordinate: 0.5 is the centre of the first column."""
    spread: float
    """Spread of the meridians that fit about as well, in columns."""
    contrast: float
    """Ratio of the smallest cost to the median cost: small if the symmetry is clear."""


def best_meridian(
    values: NDArray[np.float64], sky: NDArray[np.bool_], depth: NDArray[np.float64]
) -> Meridian | None:
    """Most symmetric meridian through the deep part; None without enough sky.

    The arrays are images, (height, width), in which the deep part does not meet the seam. The cost
    of a meridian is the median difference of `values` over pairs of `sky`.
    """
    height, width = values.shape
    columns = depth.max(axis=0)
    deep = np.flatnonzero(columns >= _SHALLOW * columns.max())
    doubled = _meridians(2 * deep[0], 2 * deep[-1])
    # Use every other row of the upper half, because neighbouring rows are similar.
    step = 2 if height > 64 else 1
    top = height // 2
    level, shown = (np.tile(values[:top:step], 3), np.tile(sky[:top:step], 3))
    costs = np.array([_cost(level, shown, int(twice) + 2 * width, width) for twice in doubled])
    least = _LEAST_PAIRS * width * (top // step)
    usable = costs[:, 1] >= least
    if np.count_nonzero(usable) < 3:
        return None
    place, cost = doubled[usable] / 2, costs[usable, 0]
    nearest = np.clip(np.round(place).astype(int), 0, width - 1)
    weight = columns[nearest] * ((cost.min() + _NOISE) / (cost + _NOISE)) ** _SHARPNESS
    weight /= weight.sum()
    mean = float(weight @ place)
    spread = float(np.sqrt(weight @ (place - mean) ** 2))
    contrast = float((cost.min() + 1e-4) / (np.median(cost) + 1e-4))
    return Meridian(mean + 0.5, spread, contrast)


def _meridians(first: int, last: int) -> NDArray[np.intp]:
    """Doubled column indices from `first` to `last`, evenly spaced and centred."""
    step = max(1, -(-(last - first + 1) // _MOST_MERIDIANS))
    return np.arange(first + (last - first) % step // 2, last + 1, step)


def _cost(
    values: NDArray[np.float64], sky: NDArray[np.bool_], twice: int, width: int
) -> tuple[float, int]:
    """Median difference over the pairs about a doubled column, and the number of pairs."""
    start, reach = twice // 2 + 1, int(_REACH / 360 * width)
    right = slice(start, start + reach)
    left = slice(twice - start, twice - start - reach, -1)
    both = sky[:, right] & sky[:, left]
    count = int(np.count_nonzero(both))
    if not count:
        return np.inf, 0
    return float(np.median(np.abs(values[:, right] - values[:, left])[both])), count
