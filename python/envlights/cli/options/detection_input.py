"""Settings of detection, for the subcommands that detect."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from envlights.cli.options.settings import settings_from, settings_of
from envlights.detection.detect import detect
from envlights.papers import loghin

#: Detectors by the value of ``--method``.
METHODS: dict[str, Callable[..., Any]] = {"tree": detect, "loghin": loghin.detect}
#: Parameters that have their own option.
_OWN = ("lights", "max_lights", "sampling")
#: Names of all settings of all methods.
SETTINGS = settings_of(METHODS.values(), _OWN)


def detection_settings(texts: Iterable[str], method: str) -> dict[str, Any]:
    """Values of ``--set`` for a method; raises an error that lists the method's settings."""
    names = settings_of([METHODS[method]], _OWN)
    of = f"method {method}: {', '.join(names)}"
    return settings_from(texts, of, names.__contains__)
