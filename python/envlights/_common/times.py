"""Wall times in reports; files hold none, so that the same work writes the same bytes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from envlights._common.check import amount


def time_lines(seconds: Mapping[str, float]) -> list[str]:
    """Line on each stage, for `verbose`."""
    return [f"{stage}: {1e3 * time:.1f} ms" for stage, time in seconds.items()]


def times_of(data: Mapping[str, Any]) -> dict[str, float]:
    """Wall times in a report of an older version."""
    stages = data.get("seconds", {}).items()
    return {str(stage): amount("seconds", seconds) for stage, seconds in stages}
