"""The remainder of a map as small diffuse surfaces at their depth."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from envlights.environment.envmap import EnvMap
from envlights.kernels.image import area_means
from envlights.kernels.sphere import pixel_directions, pixel_solid_angles
from envlights.placing.reading import Reals, block_planes, of_blocks

#: Rows of patches; twice as many columns.
_ROWS = 16


class Patches(NamedTuple):
    """Diffuse patches of uniform radiance."""

    position: Reals
    """Centres in metres, (n, 3)."""

    normal: Reals
    """Unit normals towards the camera, (n, 3)."""

    area: Reals
    """Square metres, (n,)."""

    radiance: Reals
    """Linear RGB, (n, 3)."""


def no_patches() -> Patches:
    """Patches of a map without depth: none."""
    return Patches(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros((0, 3)))


def patches_of(remainder: EnvMap, distance: Reals) -> Patches:
    """Patches of the pixels that have a distance; the others stay at infinity."""
    height, width = distance.shape
    same = remainder if remainder.height == height else remainder.resized(width)
    ray = pixel_directions(height, width)
    plane = of_blocks(block_planes(distance, ray, 2 * _ROWS), distance.shape)
    length = np.linalg.norm(plane, axis=-1)
    cosine = np.einsum("...i,...i->...", plane, ray) / length
    known = np.isfinite(distance) & np.isfinite(cosine)
    metres = np.where(known, distance, 0)
    angle = pixel_solid_angles(height, width)
    area = np.where(known, angle * metres**2 / np.clip(cosine, 0.1, 1), 0)

    def total(values: Reals) -> Reals:
        means = area_means(values * area[..., None], _ROWS, 2 * _ROWS)
        return means.reshape(-1, values.shape[-1]) * (height * width / (2 * _ROWS**2))

    size = total(np.ones((*distance.shape, 1)))
    flux, point = total(same.cells().astype(float)), total(ray * metres[..., None])
    towards = total(np.where(known[..., None], -plane / length[..., None], 0))
    some = (size[:, 0] > 0) & (np.linalg.norm(towards, axis=1) > 0)
    size, flux, point, towards = (each[some] for each in (size, flux, point, towards))
    unit = towards / np.linalg.norm(towards, axis=1, keepdims=True)
    return Patches(point / size, unit, size[:, 0], flux / size)
