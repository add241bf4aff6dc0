"""Alpha channel of a file as the coverage of each pixel.

Straight (unassociated) alpha, of PNG and of TIFF: the colour is multiplied by alpha, because colour
under alpha 0 is no light. OpenEXR is premultiplied: a pixel of alpha 0 with a colour is a light
without a surface, so only black pixels of alpha 0 are not seen. Integers that are premultiplied are
divided by alpha first, because their transfer curve belongs to the colour itself.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights.environment.decoders.raw_image import Header


def straight_codes(colours: NDArray[Any], alpha: NDArray[Any], header: Header) -> NDArray[Any]:
    """Colours divided by premultiplied alpha; floating-point colours are unchanged."""
    if header.alpha != "premultiplied" or header.dtype.kind == "f":
        return colours
    most = np.iinfo(header.dtype).max
    if (alpha == most).all():
        return colours
    divisor = np.maximum(alpha, 1).astype(np.float32)[..., None]
    codes: NDArray[Any] = np.minimum(np.rint(colours * (most / divisor)), most)
    codes[alpha == 0] = 0
    return codes.astype(header.dtype)


def visible(colours: NDArray[Any], alpha: NDArray[Any]) -> NDArray[Any]:
    """Colours, set to 0 where alpha, (rows, width, 0 or 1), is 0."""
    if not alpha.shape[2] or alpha.all():
        return colours
    codes: NDArray[Any] = np.where(alpha > 0, colours, colours.dtype.type(0))
    return codes


def seen_of_alpha(
    linear: NDArray[np.float32], alpha: NDArray[Any], header: Header
) -> NDArray[np.float32] | None:
    """Coverage of each pixel, None if complete; multiplies straight colours `linear` in place."""
    fraction = fraction_of_alpha(alpha)
    if header.alpha == "premultiplied" and header.dtype.kind == "f":
        is_seen = (fraction > 0) | (linear != 0).any(axis=-1)
        return None if is_seen.all() else is_seen.astype(np.float32)
    if (fraction == 1).all():
        return None
    linear *= fraction[..., None]
    # Set hidden samples to 0, because infinity or NaN times 0 is NaN.
    linear[fraction == 0] = 0
    return fraction


def fraction_of_alpha(alpha: NDArray[Any]) -> NDArray[np.float32]:
    """Alpha from 0 to 1; NaN counts as opaque."""
    if alpha.dtype.kind != "f":
        return alpha.astype(np.float32) / np.float32(np.iinfo(alpha.dtype).max)
    fraction: NDArray[np.float32] = np.nan_to_num(alpha.astype(np.float32), nan=1.0).clip(0, 1)
    return fraction
