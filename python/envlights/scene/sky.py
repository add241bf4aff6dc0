"""Visible part of an ambient term, and of a light, at a surface, with shadows."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from envlights import kernels
from envlights._native import EnvLightsError
from envlights.scene.surface import Surface, tangent_frames

#: Ray tracer: origins (n, 3), unit directions (n, 3) -> True for each ray that hits something (n,).
Blocked = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.bool_]]

#: Surface points whose rays are held in memory at once.
_BLOCK = 4096


def sky_transfer(surface: Surface, blocked: Blocked, directions: int) -> NDArray[np.float64]:
    r"""Irradiance of each covered texel under each of the nine harmonics.

    Parameters
    ----------
    surface : Surface
    blocked : callable
        See `Blocked`.
    directions : int
        Rays for each texel.

    Returns
    -------
    ndarray, shape (n, 9)
        :math:`\int V(\omega) Y_k(\omega) \max(0, n \cdot \omega)\, d\omega`, for the harmonics of
        `kernels.harmonic_radiance`, with the visibility V. Light is linear, so its product with the
        coefficients of an ambient term, (9, 3), is the irradiance under it.

    Notes
    -----
    The irradiance of the whole sky is known in closed form. Rays sample only the blocked part, so
    an open surface has no noise. Their directions have a density of cos / pi, by Malley's method,
    from the points of Hammersley. A point of Halton shifts them for each texel (Cranley and
    Patterson 1976): neighbours have different rays, so their mean is accurate with few rays.
    """
    origins, normals = surface.lifted()
    square = kernels.hammersley(directions)
    shifts = kernels.halton(len(origins))
    transfer = kernels.harmonic_irradiance(normals)
    for first in range(0, len(origins), _BLOCK):
        some = slice(first, first + _BLOCK)
        rays = cosine_hemisphere((square + shifts[some, None]) % 1) @ tangent_frames(normals[some])
        rows = np.repeat(origins[some], directions, axis=0)
        hit = are_blocked(blocked, rows, rays.reshape(-1, 3)).reshape(rays.shape[:2])
        radiance = kernels.harmonic_radiance(rays.reshape(-1, 3)).reshape(*hit.shape, 9)
        hidden = np.einsum("nd,ndk->nk", hit, radiance)
        transfer[some] -= np.pi / directions * hidden
    return transfer


def are_blocked(
    blocked: Blocked, origins: NDArray[np.float64], directions: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Result of a ray tracer as bool; accepts 0 and 1, and raises an error for others."""
    answer = np.asarray(blocked(origins, directions))
    is_flag = answer.dtype == np.bool_
    if answer.dtype.kind in "iu":
        is_flag = bool(np.isin(answer, (0, 1)).all())
    if answer.shape != (len(origins),) or not is_flag:
        raise EnvLightsError(
            f"blocked must return true or false for each of {len(origins)} rays;"
            f" got the dtype {answer.dtype} and the shape {answer.shape}"
        )
    return answer.astype(np.bool_, copy=False)


def cosine_hemisphere(square: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points of the unit square, (..., 2), as directions around +z with a density of cos / pi."""
    radius, angle = np.sqrt(square[..., 0]), 2 * np.pi * square[..., 1]
    height = np.sqrt(1 - square[..., 0])
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=-1)


def visible_share(
    blocked: Blocked,
    origins: NDArray[np.float64],
    normals: NDArray[np.float64],
    direction: NDArray[np.float64],
    radius: float,
    rays: int,
) -> NDArray[np.float64]:
    """Visible fraction of the irradiance of a light at each surface point.

    Parameters
    ----------
    blocked : callable
        See `Blocked`.
    origins, normals : ndarray, shape (n, 3)
        Points that face some of the light.
    direction : ndarray, shape (3,)
        Unit vector towards the light.
    radius : float
        Its angular radius in radians; a point takes one ray.
    rays : int
        From each point to a disc.

    Returns
    -------
    ndarray, shape (n,)
        1 without obstacles, and 0 if all rays are blocked; neither has noise.

    Notes
    -----
    The rays are uniform in solid angle over the disc, from the points of Hammersley, which a point
    of Halton shifts for each surface point (Cranley and Patterson 1976). Each counts by its cosine.
    """
    if radius == 0:
        towards = np.broadcast_to(direction, (len(origins), 3))
        return np.where(are_blocked(blocked, origins, towards), 0.0, 1.0)
    square, shifts = kernels.hammersley(rays), kernels.halton(len(origins))
    (frame,) = tangent_frames(direction[None])
    shares = np.ones(len(origins))
    for first in range(0, len(origins), _BLOCK):
        some = slice(first, first + _BLOCK)
        towards = _cap((square + shifts[some, None]) % 1, radius) @ frame
        cosines = np.maximum(np.einsum("nri,ni->nr", towards, normals[some]), 0)
        # Trace only rays that leave the surface.
        point, ray = np.nonzero(cosines)
        hit = are_blocked(blocked, origins[some][point], towards[point, ray])
        visible = cosines.copy()
        visible[point[hit], ray[hit]] = 0
        whole = cosines.sum(axis=1)
        # If only a sliver of the disc is above the surface, no ray may hit it.
        np.divide(visible.sum(axis=1), whole, out=shares[some], where=whole > 0)
    return shares


def _cap(square: NDArray[np.float64], radius: float) -> NDArray[np.float64]:
    """Points of the unit square, (..., 2), as directions up to `radius` around +z, uniform."""
    # 1 - cos, computed without cancellation for a small radius.
    depth = square[..., 0] * 2 * np.sin(radius / 2) ** 2
    across, angle = np.sqrt(depth * (2 - depth)), 2 * np.pi * square[..., 1]
    return np.stack([across * np.cos(angle), across * np.sin(angle), 1 - depth], axis=-1)
