"""Detection of lights with a black channel at their peak, which is rare in undamaged maps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envlights.environment.envmap import EnvMap
from envlights.kernels import image as images
from envlights.kernels.angles import place_of
from envlights.kernels.sphere import direction_to_uv

#: Smallest luminance of a pixel, relative to the peak, that counts as part of the peak.
_AT_PEAK = 0.99

_CHANNELS = ("red", "green", "blue")


def colour_cast_notes(
    world: EnvMap, peak_direction: NDArray[np.float64], peak_luminance: NDArray[np.float64]
) -> list[str]:
    """Note for each light whose peak has no red, green or blue.

    Few real lights lack a channel. More often its value was negative, not a number, or outside the
    colour range of the file, and was set to 0.
    """
    # Find the peak pixels, because the centroid of a flat top may lie outside of them.
    radiance = _pixels(world, peak_direction).astype(np.float64)
    is_peak = radiance @ images.LUMINANCE >= _AT_PEAK * peak_luminance
    is_black = (radiance == 0) & is_peak[:, None]
    lights = np.flatnonzero(is_black.any(axis=1) & (radiance > 0).any(axis=1))
    return [
        f"the light at {place_of(peak_direction[light])} has no {_names(is_black[light])} at its"
        " peak, so its colour may be wrong"
        for light in lights
    ]


def _pixels(world: EnvMap, directions: NDArray[np.float64]) -> NDArray[np.float32]:
    """Radiance of the pixels in the given directions.

    This holds for border-sampled maps too: pixel k of n lies at k / (n - 1), and k n / (n - 1) is
    below k + 1.
    """
    uv = direction_to_uv(directions)
    row, column = images.uv_to_pixel(uv, world.height, world.width).T
    pixels: NDArray[np.float32] = world.radiance[row, column]
    return pixels


def _names(is_black: NDArray[np.bool_]) -> str:
    return " and no ".join(name for name, black in zip(_CHANNELS, is_black, strict=True) if black)
