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
#: Least change in a step while fewer than `_FEW` changes are known, as at the ends of a flash.
_LEAST_AT_FIRST, _FEW = 0.25, 3
#: Changes that the median is taken over.
_REMEMBERED = 12


class _Changes:
    """One measure of the change from frame to frame, and what is usual for it."""

    def __init__(self) -> None:
        self._last: deque[tuple[float, bool]] = deque(maxlen=_REMEMBERED)

    def is_step(self, change: float) -> bool:
        """True if a change is far larger than usual; the first ones are not compared."""
        if len(self._last) < _FEW:
            found = change > _LEAST_AT_FIRST
        else:
            # Steps are not usual, unless there is nothing else.
            others = [each for each, is_step in self._last if not is_step]
            usual = float(np.median(others or [each for each, _ in self._last]))
            found = change > max(_LEAST, _RATIO * usual)
        self._last.append((change, found))
        return found


class Steps:
    """Changes of the irradiance from frame to frame: of all of it, and beyond the exposure."""

    def __init__(self) -> None:
        self._last: MapSamples | None = None
        self._changes = _Changes(), _Changes()

    def is_step(self, samples: MapSamples) -> bool:
        """True if the irradiance under the next frame differs far more than usual from the last."""
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
