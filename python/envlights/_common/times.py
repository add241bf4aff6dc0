"""Wall times in reports; files hold none, so that the same work writes the same bytes."""

from __future__ import annotations

from collections.abc import Mapping


def time_lines(seconds: Mapping[str, float]) -> list[str]:
    """Line on each stage, for `verbose`."""
    return [f"{stage}: {1e3 * time:.1f} ms" for stage, time in seconds.items()]
