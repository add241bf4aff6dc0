"""Ward's linkage with weights, all pairs anew at each step."""

from __future__ import annotations

from itertools import combinations

import numpy as np


def clusters(flux, direction, most):
    """Sets of indices: at most `most`, by the fewest flux-weighted squares at each merger."""
    groups = [{i} for i in range(len(flux))]

    def cost(pair):
        one, other = (sorted(groups[i]) for i in pair)
        ends = [flux[each] @ direction[each] for each in (one, other)]
        towards = [end / np.linalg.norm(end) for end in ends]
        weight = 1 / (1 / flux[one].sum() + 1 / flux[other].sum())
        return weight * np.sum((towards[0] - towards[1]) ** 2)

    while len(groups) > most:
        i, j = min(combinations(range(len(groups)), 2), key=cost)
        groups[i] |= groups.pop(j)
    return groups
