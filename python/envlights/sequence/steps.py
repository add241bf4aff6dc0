"""Steps of the light: frames before which the light of the scene changes at once."""

from __future__ import annotations

from collections import deque

import numpy as np

from envlights.fitting.map_fit import MapSamples
from envlights.kernels.probe import relative_rms

#: Ratio of a step to the median change from frame to frame. Noise of the exposure does not reach 5.
_RATIO = 5.0
#: Least relative RMS change of the irradiance in a step. Smaller ones are cross-faded unseen.
_LEAST = 0.01
#: Least change in a step while fewer than `_FEW` changes are known.
_LEAST_AT_FIRST, _FEW = 0.25, 3
#: Changes that the median is taken over.
_REMEMBERED = 12


class Steps:
    """Changes of the irradiance from frame to frame."""

    def __init__(self) -> None:
        self._last: MapSamples | None = None
        self._changes: deque[float] = deque(maxlen=_REMEMBERED)

    def is_step(self, samples: MapSamples) -> bool:
        """True if the irradiance under the next frame differs far more than usual from the last."""
        last, self._last = self._last, samples
        if last is None:
            return False
        change = _change(samples, last)
        usual = float(np.median(self._changes)) if self._changes else 0.0
        least = _LEAST if len(self._changes) >= _FEW else _LEAST_AT_FIRST
        self._changes.append(change)
        return change > max(least, _RATIO * usual)


def _change(samples: MapSamples, last: MapSamples) -> float:
    """Relative RMS difference of the irradiance of two frames, relative to the brighter one."""
    brighter, other = samples.irradiance, last.irradiance
    if (brighter**2).sum() < (other**2).sum():
        brighter, other = other, brighter
    return float(relative_rms(other, brighter, samples.weights))
