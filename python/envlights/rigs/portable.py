"""Functions with bitwise equal results on all machines, from sums, products and quotients.

Libraries of C, and NumPy for each processor, round the last bit of sines and powers differently.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


def power_of_two(exponent: float) -> float:
    """Two to the power `exponent`, by the exponential series of the fractional part."""
    whole = math.floor(exponent + 0.5)
    small = (exponent - whole) * math.log(2.0)
    value = 1.0
    for k in range(15, 0, -1):
        value = 1.0 + small / k * value
    return math.ldexp(value, whole)


def circle(
    turns: float | NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Cosines and sines of angles in full turns, by series up to 1/8 of a turn."""
    quarters = np.floor(4.0 * np.asarray(turns) + 0.5)
    angle = (4.0 * turns - quarters) * (math.pi / 2)
    square, cosine, sine = angle * angle, np.ones_like(angle), np.ones_like(angle)
    for k in range(18, 0, -2):
        cosine = 1.0 - square / (k * (k - 1)) * cosine
        sine = 1.0 - square / (k * (k + 1)) * sine
    sine = angle * sine
    is_odd, is_back = quarters % 2 == 1, quarters % 4 >= 2
    cosine, sine = np.where(is_odd, -sine, cosine), np.where(is_odd, cosine, sine)
    return np.where(is_back, -cosine, cosine), np.where(is_back, -sine, sine)


def uniform(seed: int, number: int, count: int) -> NDArray[np.float64]:
    """Random numbers from 0 to 1 in stream `number` of a seed: 53 bits each of NumPy's PCG64.

    NumPy keeps the bits of its generators in all versions, but not the floats made of them.
    """
    source = np.random.PCG64(np.random.SeedSequence(seed, spawn_key=(number,)))
    return np.asarray((source.random_raw(count) >> np.uint64(11)) * 2.0**-53, np.float64)
