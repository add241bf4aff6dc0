"""Wall time of the stages of a fit."""

from __future__ import annotations

from time import perf_counter


class Clock:
    """Wall time of each stage."""

    def __init__(self) -> None:
        self.laps: dict[str, float] = {}
        self._last = perf_counter()

    def lap(self, stage: str) -> None:
        """Store the time since the last lap under `stage`."""
        now = perf_counter()
        self.laps[stage] = now - self._last
        self._last = now
