"""Copies of pairs, which leave-one-out errors leave out together.

A remaining copy would show the fit the pair that is left out. With `m` copies of a pair
the sums of squares of basis and regression are those of one pair, `sqrt(m)` times as bright: so
the copies are one pair in the closed forms, and its relative error is that of each.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights.transfer.pairs import PairSummary

#: Relative difference of the numbers of two copies: that of rounding in single precision.
_SAME = 1e-6


class Distinct(NamedTuple):
    """Distinct pairs, and the copies of each."""

    learnt: PairSummary
    """The first of each group of copies, brighter by the square root of their number."""

    group: NDArray[np.intp]
    """For each of all pairs, which of these it is a copy of, (k,)."""

    @property
    def copies(self) -> int:
        """Number of copies."""
        return len(self.group) - len(self.learnt.energy)


def distinct(learnt: PairSummary) -> Distinct:
    """The pairs without their copies."""
    first = _first(learnt)
    kept, group, times = np.unique(first, return_inverse=True, return_counts=True)
    root = np.sqrt(times)[:, None, None]
    together = PairSummary(
        learnt.direct[kept] * root,
        learnt.coefficients[kept] * root,
        learnt.outside[kept] * root**2,
        learnt.energy[kept] * times,
    )
    return Distinct(together, group.ravel())


def _first(learnt: PairSummary) -> NDArray[np.intp]:
    """For each pair the first that it is a copy of, which may be itself, (k,)."""
    count = len(learnt.energy)
    direct = learnt.direct.reshape(count, -1)
    first = np.arange(count)
    # Direct images have norm 1: only those with products of 1 need a closer look.
    for i, j in np.argwhere(np.tril(direct @ direct.T > 1 - _SAME, -1)):
        are_same = first[j] == j and all(
            np.linalg.norm(part[i] - part[j]) <= _SAME * np.linalg.norm(part[i])
            for part in (direct, learnt.coefficients, learnt.energy)
        )
        if are_same and first[i] == i:
            first[i] = j
    return first
