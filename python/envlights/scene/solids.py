"""Light that solids hide from surfaces, in closed form, and a ray tracer for them."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights import kernels
from envlights.occluders import Ball, Solid, Stage
from envlights.rig import Rig
from envlights.scene.sky import Blocked, sky_transfer
from envlights.scene.surface import Surface

#: Rays to the sky from each point, for an ambient term of harmonics.
_RAYS = 64
_DARK = np.zeros(3)
_Hits = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.bool_]]


class SourceLight(NamedTuple):
    """Irradiance of points under each source alone: the ambient term first, then each light."""

    whole: NDArray[np.float64]
    """Irradiance with nothing in the way, (1 + m, n, 3)."""

    hidden: NDArray[np.float64]
    """Irradiance that the solids hide, (1 + m, n, 3)."""


def source_light(rig: Rig, stage: Stage) -> SourceLight:
    """Light of each source of a rig at the points of a stage, and its hidden part."""
    lights = rig.lights
    none: tuple[NDArray[np.float64], ...] = (np.zeros((0, 3)), np.zeros((0, 3)))
    whole = [kernels.rig_irradiance(stage.normals, rig.ambient, *none, floor=rig.floor)]
    shares = kernels.hidden_fractions(stage, lights.direction, lights.angular_radius, floor=rig.floor)
    hidden = [_hidden_ambient(rig.ambient, shares[:, 0], stage)]
    rows = zip(lights.direction, lights.irradiance, lights.angular_radius, strict=True)
    for share, (direction, strength, radius) in zip(shares.T[1:], rows, strict=True):
        light = ([direction], [strength], [radius])
        whole.append(kernels.rig_irradiance(stage.normals, _DARK, *light))
        hidden.append(np.outer(share, strength))
    return SourceLight(np.array(whole), np.minimum(hidden, whole))


def _hidden_ambient(
    ambient: NDArray[np.float64], shares: NDArray[np.float64], stage: Stage
) -> NDArray[np.float64]:
    """Hidden irradiance of a constant ambient term, or of harmonics."""
    if ambient.ndim == 1:
        return np.pi * np.outer(shares, ambient)
    surface = Surface(stage.points[None], stage.normals[None], np.ones((1, len(shares), 3)))
    return hidden_harmonics(surface, stage, _RAYS) @ ambient


def hidden_harmonics(surface: Surface, stage: Stage, directions: int) -> NDArray[np.float64]:
    """Hidden irradiance under each of the nine harmonics at the covered texels, (n, 9).

    Harmonic 0 is constant, so it is exact. The others have its hidden share times their mean over
    the rays that meet a solid.
    """
    whole = kernels.harmonic_irradiance(stage.normals)
    traced = whole - sky_transfer(surface, blocked_by(stage.solids), directions)
    none = np.zeros((0, 3)), np.zeros(0)
    exact = (kernels.hidden_fractions(stage, *none) * np.pi / np.sqrt(4 * np.pi))[:, 0]
    # Without a ray that meets a solid, use the mean over the whole sky.
    is_hit = traced[:, 0] > 1e-12
    means = np.where(is_hit[:, None], traced, whole)
    return np.asarray(means * (exact / means[:, 0])[:, None])


def blocked_by(solids: tuple[Solid, ...]) -> Blocked:
    """Ray tracer of solids."""
    hits = [_ball_hits(each) if isinstance(each, Ball) else _faces_hit(each) for each in solids]

    def is_blocked(
        origins: NDArray[np.float64], directions: NDArray[np.float64]
    ) -> NDArray[np.bool_]:
        is_hit = np.zeros(len(origins), np.bool_)
        for each in hits:
            is_hit |= each(origins, directions)
        return is_hit

    return is_blocked


def _ball_hits(ball: Ball) -> _Hits:
    def hits(origins: NDArray[np.float64], directions: NDArray[np.float64]) -> NDArray[np.bool_]:
        away = np.array(ball.centre) - origins
        along = np.einsum("ni,ni->n", away, directions)
        outside = np.einsum("ni,ni->n", away, away) - ball.radius**2
        return np.asarray((outside < 0) | ((along > 0) & (outside < along**2)))

    return hits


def _faces_hit(solid: Solid) -> _Hits:
    """Rays whose lengths within all faces of a polyhedron are an interval."""
    assert not isinstance(solid, Ball)
    normals, distances = solid.planes()

    def hits(origins: NDArray[np.float64], directions: NDArray[np.float64]) -> NDArray[np.bool_]:
        near, far = np.zeros(len(origins)), np.full(len(origins), np.inf)
        for normal, distance in zip(normals, distances, strict=True):
            height, slope = origins @ normal - distance, directions @ normal
            with np.errstate(divide="ignore", invalid="ignore"):
                length = -height / slope
            near = np.where(slope < 0, np.maximum(near, length), near)
            far = np.where(slope > 0, np.minimum(far, length), far)
            far = np.where((slope == 0) & (height > 0), -1.0, far)
        return np.asarray(near < far)

    return hits
