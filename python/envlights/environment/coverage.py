"""Share of each pixel of a map that was seen: alpha, a mask, or a part of the sphere."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.blocks import in_blocks
from envlights._common.check import describe
from envlights._native import EnvLightsError
from envlights.kernels.sphere import pixel_solid_angles


def checked_seen(seen: ArrayLike, shape: tuple[int, int]) -> NDArray[np.float32] | None:
    """Share of each pixel as an array from 0 to 1, or a refusal; None if all is seen."""
    try:
        share = np.array(seen, dtype=np.float32)
    except (TypeError, ValueError):
        raise EnvLightsError(f"seen must be an array of numbers; got {describe(seen)}") from None
    if share.shape != shape:
        raise EnvLightsError(f"seen must have the shape {shape} of the pixels; got {share.shape}")
    if not ((share >= 0) & (share <= 1)).all():
        raise EnvLightsError(f"seen must lie from 0 to 1; got {share.min():g} to {share.max():g}")
    if not share.any():
        raise EnvLightsError("no pixel of the map is seen; leave out its alpha, mask or `seen`")
    return None if (share == 1).all() else share


def multiply_by_share(
    radiance: NDArray[np.float32], share: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Radiance multiplied by its share; 0 where nothing is seen, whatever the sample."""

    def block(rows: slice) -> NDArray[np.float32]:
        part = share[rows, :, None]
        with np.errstate(invalid="ignore"):
            return np.where(part > 0, radiance[rows] * part, np.float32(0))

    return in_blocks(radiance.shape, block)


def share_of_sphere(share: NDArray[np.float32], border_sampled: bool) -> float:
    """Mean of the share over the sphere."""
    height, width = share.shape
    weights = pixel_solid_angles(height, width, border_sampled=border_sampled)
    return float((share * weights).sum() / weights.sum())


def note_of_unseen(share_of_sphere: float) -> str:
    """Note on the fraction of the sphere that is not seen."""
    return f"{100 * (1 - share_of_sphere):.2g} % of the sphere is not seen"
