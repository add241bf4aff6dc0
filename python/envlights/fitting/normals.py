"""Normals that measure the error of a fit to a map, and those at which upward ones are fitted."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights import kernels

#: Normals that measure the error.
JUDGING = 5120
#: Upward normals at which a fit to upward surfaces is made.
FITTED_UPWARD = 2560


class Normals(NamedTuple):
    """Unit normals, shape (n, 3), and the weight of each."""

    directions: NDArray[np.float64]
    weights: NDArray[np.float64]


#: None are needed where the fit is at every normal, in closed form.
NO_NORMALS = Normals(np.zeros((0, 3)), np.zeros(0))


def judging(upward: bool) -> Normals:
    """The normals that measure the error: everywhere, or on the upper half of the sphere."""
    return _judging_upward() if upward else _everywhere(JUDGING)


@cache
def fitted_upward() -> Normals:
    """Normals that face up: faces of an icosphere, none of which measures the error."""
    return _upper_half(Normals(*kernels.icosphere(2 * FITTED_UPWARD)))


@cache
def _judging_upward() -> Normals:
    return _upper_half(_everywhere(2 * JUDGING))


@cache
def _everywhere(count: int) -> Normals:
    """Even points in opposite pairs, of which the kernel looks at one."""
    front = kernels.uniform_sphere(kernels.hammersley(count // 2) * (0.5, 1.0))
    return Normals(np.concatenate([front, -front]), np.full(count, 4 * np.pi / count))


def _upper_half(normals: Normals) -> Normals:
    is_up = normals.directions[:, 1] > 0
    return Normals(normals.directions[is_up], normals.weights[is_up])
