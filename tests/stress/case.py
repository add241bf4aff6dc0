"""A case of the stress suite."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from tests.helpers import angle_deg

#: Largest relative error of one rounding.
U32, U64 = 2.0**-24, 2.0**-53


class Case(NamedTuple):
    """Bound at an extreme, checked by the tests and printed by the benchmarks."""

    group: str
    name: str
    bound: float
    reason: str
    """Reason for the bound; a number refers to `docs/lab/bounds.md`."""

    measure: Callable[[], float]
    """The largest error, relative unless the name says otherwise."""

    float32: Callable[[], float] | None = None
    """Error of plain sums in float32, for comparison."""

    is_open: bool = False
    """True where the bound is known not to hold: a defect to be mended."""


def cases_of(group, what, bound, reason, measure, arguments):
    """A case for each name in `arguments`, whose values `measure` takes."""
    return [
        Case(group, what + name, bound, reason, partial(measure, *given))
        for name, given in arguments.items()
    ]


def light_of(lights):
    """Flux of detected lights, which is measured, or irradiance of fitted ones."""
    return getattr(lights, "flux", lights.irradiance)


def lights_apart(found, direction, light, in_order=False):
    """Largest turn in radians or relative change of `light_of`; infinite unless one for one.

    Each is compared with the nearest, or with the one at its place.
    """
    if len(found) != len(direction):
        return np.inf
    if not len(found):
        return 0.0
    nearest = np.argmax(found.direction @ direction.T, axis=0)
    if in_order and (nearest != np.arange(len(found))).any():
        return np.inf
    if len(np.unique(nearest)) < len(nearest):
        return np.inf
    turned = np.deg2rad(angle_deg(found.direction[nearest], direction))
    change = np.abs(light_of(found)[nearest] / light - 1)
    # Python's `max` would drop NaN.
    return float(np.maximum(turned.max(initial=0), change.max(initial=0)))
