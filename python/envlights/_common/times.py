"""Wall times for reports; files omit them, so that equal work writes equal bytes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from time import perf_counter


def time_lines(seconds: Mapping[str, float]) -> list[str]:
    """Line per stage, for `verbose`."""
    return [f"{stage}: {1e3 * time:.1f} ms" for stage, time in seconds.items()]


class Clock:
    """Wall time of each stage, measured between calls of `lap`."""

    def __init__(self, laps: Mapping[str, float] | None = None) -> None:
        self.laps = dict(laps or {})
        self._last = perf_counter()

    def lap(self, stage: str) -> None:
        """Store the time since the last lap under `stage`."""
        now = perf_counter()
        self.laps[stage] = now - self._last
        self._last = now

    def add(self, stages: Iterable[tuple[str, float]]) -> None:
        """Add times of stages that were measured elsewhere since the last lap."""
        for stage, seconds in stages:
            self.laps[stage] = self.laps.get(stage, 0.0) + seconds
        self._last = perf_counter()
