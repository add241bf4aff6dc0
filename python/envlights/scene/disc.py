"""Visible part of a light at a surface, with shadows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights import kernels
from envlights.scene.sky import Blocked, are_blocked
from envlights.scene.surface import tangent_frames

#: Surface points whose rays are held in memory at once.
_BLOCK = 4096


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
        # Trace those rays that leave the surface.
        point, ray = np.nonzero(cosines)
        hit = are_blocked(blocked, origins[some][point], towards[point, ray])
        visible = cosines.copy()
        visible[point[hit], ray[hit]] = 0
        whole = cosines.sum(axis=1)
        # Where only a sliver of the disc rises above the surface, no ray may meet it.
        np.divide(visible.sum(axis=1), whole, out=shares[some], where=whole > 0)
    return shares


def _cap(square: NDArray[np.float64], radius: float) -> NDArray[np.float64]:
    """Points of the unit square, (..., 2), as directions up to `radius` around +z, uniform."""
    # 1 - cos, which keeps its digits for a small radius.
    depth = square[..., 0] * 2 * np.sin(radius / 2) ** 2
    across, angle = np.sqrt(depth * (2 - depth)), 2 * np.pi * square[..., 1]
    return np.stack([across * np.cos(angle), across * np.sin(angle), 1 - depth], axis=-1)
