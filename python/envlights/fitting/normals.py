"""Irradiance of a map at two sets of normals: one is fitted, the other measures the error."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights import kernels
from envlights.envmap import EnvMap

#: Faces of the fitted probe (Madsen et al. 2003, section 3.1), and normals that measure the error.
FITTED = 320
JUDGING = 5120


class Normals(NamedTuple):
    """Normals in opposite pairs: the second half mirrors the first.

    The kernel looks at one normal of each pair.
    """

    directions: NDArray[np.float64]
    weights: NDArray[np.float64]


class Samples(NamedTuple):
    """Irradiance at normals, and the weight of each."""

    normals: NDArray[np.float64]
    weights: NDArray[np.float64]
    irradiance: NDArray[np.float64]

    def divided_by(self, scale: float) -> Samples:
        """With all irradiance in units of `scale`."""
        return self._replace(irradiance=self.irradiance / scale)

    def upper(self) -> Samples:
        """Those of surfaces that face up, as most visible ones of an object on a floor do."""
        is_up = self.normals[:, 1] > 0
        return Samples(self.normals[is_up], self.weights[is_up], self.irradiance[is_up])


def fitted_and_judging(env: EnvMap, judges: int = JUDGING) -> tuple[Samples, Samples, int]:
    """Irradiance of `env` at both sets of normals, and the point sources it was made from."""
    sets = _fitted(), _judging(judges)
    seen, sources = _irradiance(env, *sets)
    fitted, judging = (Samples(*normals, part) for normals, part in zip(sets, seen, strict=True))
    return fitted, judging, sources


def upper_fitted_and_judging(env: EnvMap) -> tuple[Samples, Samples, int]:
    """The same for surfaces that face up, of which JUDGING measure the error."""
    fitted, judging, sources = fitted_and_judging(env, 2 * JUDGING)
    return fitted.upper(), judging.upper(), sources


@cache
def _fitted() -> Normals:
    """The faces of the fitted probe."""
    faces, solid_angles = kernels.icosphere(FITTED)
    # No face looks along the horizon of this axis, so just one of each pair is in front of it.
    is_front = faces @ (0.8, 0.5, 0.33) > 0
    return _with_opposites(faces[is_front], solid_angles[is_front])


@cache
def _judging(count: int) -> Normals:
    """Even points between the faces."""
    front = kernels.uniform_sphere(kernels.hammersley(count // 2) * (0.5, 1.0))
    return _with_opposites(front, np.full(count // 2, 4 * np.pi / count))


def _with_opposites(front: NDArray[np.float64], weights: NDArray[np.float64]) -> Normals:
    return Normals(np.concatenate([front, -front]), np.concatenate([weights, weights]))


def _irradiance(env: EnvMap, *normals: Normals) -> tuple[list[NDArray[np.float64]], int]:
    """Irradiance at each set of normals, and the point sources it was made from."""
    directions = [some.directions for some in normals]
    irradiance, sources = kernels.working_irradiance(
        env.radiance,
        np.concatenate(directions),
        border_sampled=env.registration == "border-sampled",
    )
    ends = np.cumsum([len(some) for some in directions[:-1]])
    return np.split(irradiance, ends), sources
