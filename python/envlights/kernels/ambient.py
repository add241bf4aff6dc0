"""Ambient term: a constant radiance, or nine spherical harmonics of the radiance."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights.kernels import harmonics, sampling, sphere

#: Radiance of the constant harmonic.
HARMONIC_MEAN = 0.5 / np.sqrt(np.pi)
#: Number of evenly spread directions at which rotated harmonics are fitted; nine would suffice.
_DIRECTIONS = 80


def mean_ambient(ambient: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mean radiance of an ambient term, (3,)."""
    mean: NDArray[np.float64] = ambient if ambient.ndim == 1 else HARMONIC_MEAN * ambient[0]
    return mean


def as_harmonics(ambient: NDArray[np.float64]) -> NDArray[np.float64]:
    """Nine harmonics of an ambient term, (9, 3)."""
    if ambient.ndim == 2:
        return ambient
    rows = np.zeros((9, 3))
    rows[0] = ambient / HARMONIC_MEAN
    return rows


def half_sky_harmonics(ambient: NDArray[np.float64]) -> NDArray[np.float64]:
    """Nine harmonics of a constant radiance above the horizon and none below, (9, 3).

    Their irradiance is exact: the half sky differs from its mean by odd orders alone, and the
    cosine has no odd order but the first.
    """
    rows = np.zeros((9, 3))
    rows[:2] = np.outer(np.sqrt(np.pi) * np.array([1, np.sqrt(0.75)]), ambient)
    return rows


def ambient_rows(
    ambient: NDArray[np.float64], height: int, floor: bool
) -> Callable[[slice], NDArray[np.float32]]:
    """Function that returns rows of the radiance of an ambient term, (n, 2 * height, 3)."""
    if ambient.ndim == 2:

        def radiance(rows: slice) -> NDArray[np.float32]:
            directions = sphere.row_directions(height, rows)
            values = harmonics.harmonic_radiance(directions.reshape(-1, 3)) @ ambient
            return np.maximum(values, 0).reshape(directions.shape).astype(np.float32)

        return radiance
    fraction = np.ones((height, 1, 1))
    if floor:
        # If the number of rows is odd, half of the middle row is above the horizon.
        fraction[height // 2 : (height + 1) // 2] = 0.5
        fraction[(height + 1) // 2 :] = 0
    sky = (fraction * ambient).astype(np.float32)
    return lambda rows: np.broadcast_to(sky[rows], (len(sky[rows]), 2 * height, 3))


def turned_ambient(ambient: NDArray[np.float64], matrix: ArrayLike) -> NDArray[np.float64]:
    """Ambient term after a rotation or a reflection.

    Harmonics up to one order are closed under rotation: with rows of values B at directions d, the
    new coefficients solve B(matrix @ d) new = B(d) old.
    """
    if ambient.ndim == 1:
        return ambient
    directions, _ = sampling.icosphere(_DIRECTIONS)
    old = harmonics.harmonic_radiance(directions) @ ambient
    turned = directions @ np.transpose(matrix)
    turned /= np.linalg.norm(turned, axis=1, keepdims=True)
    values = harmonics.harmonic_radiance(turned)
    return np.asarray(np.linalg.lstsq(values, old, rcond=None)[0], np.float64)


def turned_about_pole(
    ambient: NDArray[np.float64], cosine: float, sine: float
) -> NDArray[np.float64]:
    """Ambient term rotated about +y towards larger azimuths, bitwise equal on all machines."""
    if ambient.ndim == 1:
        return ambient
    one, y, z, x, xy, yz, zz, xz, xx = ambient
    half, root = 0.5, 0.5 * np.sqrt(3.0)
    # Rotate about y, although 3zz - 1 and xx - yy are aligned with z: 3yy - 1 is invariant, and xx
    # - zz rotates.
    pole, level = -half * zz - root * xx, half * xx - root * zz
    double_cosine, double_sine = cosine * cosine - sine * sine, 2.0 * cosine * sine
    level, xz = double_cosine * level - double_sine * xz, double_cosine * xz + double_sine * level
    turned = [one, y, cosine * z + sine * x, cosine * x - sine * z]
    turned += [cosine * xy - sine * yz, cosine * yz + sine * xy]
    turned += [-half * pole - root * level, xz, half * level - root * pole]
    return np.stack(turned)
