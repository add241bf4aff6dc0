"""Steadiness of a sequence: half-width of the window over which rigs are averaged."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import count, describe, positive
from envlights._native import EnvLightsError

#: Largest half-width, because a window holds the rigs and irradiance of its frames in memory.
MOST_FRAMES = 1000

_SECONDS = re.compile(r"\s*(\d+(?:\.\d*)?|\.\d+)\s*s\s*")


def frame_rate(fps: float | None) -> float | None:
    """Frames per second, above 0, or None."""
    return None if fps is None else positive("fps", fps)


def window_frames(steadiness: int | str, fps: float | None) -> int:
    """Half-width of the window in frames, from a number of frames or a text such as "0.2 s".

    Examples
    --------
    >>> window_frames(3, None), window_frames("0.2 s", 24.0)
    (3, 5)
    """
    if not isinstance(steadiness, str):
        return count("steadiness", steadiness, most=MOST_FRAMES)
    seconds = _SECONDS.fullmatch(steadiness)
    if seconds is None:
        raise EnvLightsError(
            "steadiness must be a number of frames, or seconds such as '0.2 s'; got"
            f" {describe(steadiness)}"
        )
    if fps is None:
        raise EnvLightsError(
            f"steadiness in seconds needs fps, the frames in a second; got {describe(steadiness)}"
            " without fps. Set fps, or give a number of frames"
        )
    return count("steadiness", round(float(seconds[1]) * fps), most=MOST_FRAMES)


def window_weights(half: int) -> NDArray[np.float64]:
    """Raised-cosine weights over the frames from -half to half, (2 * half + 1,), with sum 1.

    Examples
    --------
    >>> window_weights(1)
    array([0.25, 0.5 , 0.25])
    """
    weights = 1 + np.cos(np.pi * np.arange(-half, half + 1) / (half + 1))
    return np.asarray(weights / weights.sum())
