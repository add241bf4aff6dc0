"""Wall times in reports; files hold none, so that the same work writes the same bytes."""

from __future__ import annotations

from collections.abc import Mapping
from time import perf_counter


def time_lines(seconds: Mapping[str, float]) -> list[str]:
    """Line on each stage, for `verbose`."""
    return [f"{stage}: {1e3 * time:.1f} ms" for stage, time in seconds.items()]


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
