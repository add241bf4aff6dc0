"""Detection of frames at which the scene's light changes abruptly."""

from __future__ import annotations

from collections import deque

import numpy as np

from envlights.fitting.map_fit import MapSamples
from envlights.kernels.probe import relative_rms

#: Smallest ratio of a step to the median change between frames; exposure noise stays below 5.
_RATIO = 5.0
#: Smallest relative RMS change of irradiance in a step; smaller ones are invisible in a cross-fade.
_LEAST = 0.01
#: Smallest change in a step while fewer than `_FEW` changes are known, for example at the end of a
#: flash.
_LEAST_AT_FIRST, _FEW = 0.25, 3
#: Number of changes in the median.
_REMEMBERED = 12


class _Changes:
    """Measure of the change between frames, with its usual size."""

    def __init__(self) -> None:
        self._last: deque[tuple[float, bool]] = deque(maxlen=_REMEMBERED)

    def is_step(self, change: float) -> bool:
        """True if a change is far larger than usual; false until enough changes are known."""
        if len(self._last) < _FEW:
            found = change > _LEAST_AT_FIRST
        else:
            # Exclude steps from the usual changes, unless there are only steps.
            others = [each for each, is_step in self._last if not is_step]
            usual = float(np.median(others or [each for each, _ in self._last]))
            found = change > max(_LEAST, _RATIO * usual)
        self._last.append((change, found))
        return found


class Steps:
    """Changes of irradiance between frames: total, and after removal of exposure."""

    def __init__(self) -> None:
        self._last: MapSamples | None = None
        self._changes = _Changes(), _Changes()

    def is_step(self, samples: MapSamples) -> bool:
        """True if the irradiance of the next frame differs far more than usual."""
        last, self._last = self._last, samples
        if last is None:
            return False
        pairs = zip(self._changes, _changes(samples, last), strict=True)
        found = [changes.is_step(change) for changes, change in pairs]
        return any(found)


def _changes(samples: MapSamples, last: MapSamples) -> tuple[float, float]:
    """Relative RMS differences of the irradiance of two frames, relative to the brighter one.

    The second one remains at the best scale of each channel, so that the exposure and the white
    balance do not count.
    """
    brighter, other = samples.irradiance, last.irradiance
    if (brighter**2).sum() < (other**2).sum():
        brighter, other = other, brighter
    weights = samples.weights[:, None]
    squares = (weights * other**2).sum(axis=0)
    scale = (weights * other * brighter).sum(axis=0) / np.where(squares > 0, squares, 1)
    return (
        float(relative_rms(other, brighter, samples.weights)),
        float(relative_rms(scale * other, brighter, samples.weights)),
    )
