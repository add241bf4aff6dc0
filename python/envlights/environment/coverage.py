"""Coverage of the pixels of a map: alpha, a mask, or a part of the sphere."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.blocks import in_blocks
from envlights._common.check import describe
from envlights._common.words import percent
from envlights._native import EnvLightsError
from envlights.kernels.sphere import pixel_solid_angles


def checked_coverage(coverage: ArrayLike, shape: tuple[int, ...]) -> NDArray[np.float32] | None:
    """Coverage from 0 to 1, (height, width); None if complete. Raises an error if invalid."""
    try:
        fraction = np.array(coverage, dtype=np.float32)
    except (TypeError, ValueError):
        raise EnvLightsError(
            f"coverage must be an array of numbers; got {describe(coverage)}"
        ) from None
    if fraction.shape != shape:
        raise EnvLightsError(
            f"coverage must have the shape {shape} of the pixels; got {fraction.shape}"
        )
    if not ((fraction >= 0) & (fraction <= 1)).all():
        raise EnvLightsError(
            f"coverage must lie from 0 to 1; got {fraction.min():g} to {fraction.max():g}"
        )
    if not fraction.any():
        raise EnvLightsError("no pixel of the map is seen; leave out its alpha, mask or `coverage`")
    return None if (fraction == 1).all() else fraction


def multiply_by_coverage(
    radiance: NDArray[np.float32], fraction: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Radiance multiplied by its coverage; 0 where the coverage is 0, whatever the sample."""

    def block(rows: slice) -> NDArray[np.float32]:
        part = fraction[rows][..., None]
        with np.errstate(invalid="ignore"):
            return np.where(part > 0, radiance[rows] * part, np.float32(0))

    return in_blocks(radiance.shape, block)


def fraction_of_sphere(fraction: NDArray[np.float32], border_sampled: bool) -> float:
    """Mean of the coverage over the sphere."""
    height, width = fraction.shape
    weights = pixel_solid_angles(height, width, border_sampled=border_sampled)
    return float((fraction * weights).sum() / weights.sum())


def note_of_coverage(fraction_of_sphere: float) -> str:
    """Note on the fraction of the sphere that is not visible in the map."""
    return f"{percent(1 - fraction_of_sphere)} of the sphere is not seen"
