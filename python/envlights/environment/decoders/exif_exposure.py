"""Exposure of a photograph from its EXIF: time, sensitivity and aperture."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Protocol


class NumberOf(Protocol):
    """Function that gives a numeric tag above `least`, or None."""

    def __call__(self, name: str, least: float = 0.0) -> float | None:
        """Value of the tag `name`."""


def exposure_tags(number: NumberOf) -> dict[str, float]:
    """Exposure time in seconds, sensitivity and aperture, as far as the EXIF holds them."""
    aperture = _number_or_apex(
        number, "FNumber", "Exif:ApertureValue", lambda apex: 2 ** (apex / 2)
    )
    time = _number_or_apex(
        number, "ExposureTime", "Exif:ShutterSpeedValue", lambda apex: 2.0**-apex
    )
    tags = ("Exif:PhotographicSensitivity", "Exif:ISOSpeedRatings")
    speed = max((value for tag in tags if (value := number(tag))), default=None)
    found = {"time": time, "speed": speed, "aperture": aperture}
    return {key: float(value) for key, value in found.items() if value}


def ev100_of(tags: Mapping[str, float]) -> float | None:
    """Exposure value at ISO 100, log2(N^2 / t * 100 / S); None if a tag is missing."""
    if set(tags) != {"time", "speed", "aperture"}:
        return None
    return math.log2(tags["aperture"] ** 2 / tags["time"] * 100 / tags["speed"])


def _number_or_apex(
    number: NumberOf, name: str, apex_name: str, of_apex: Callable[[float], float]
) -> float | None:
    """Value of a tag, or that of its logarithm in the APEX system."""
    if value := number(name):
        return value
    apex = number(apex_name, least=-math.inf)
    return None if apex is None or abs(apex) > _MOST_APEX else of_apex(apex)


#: Largest logarithm in the APEX system that is believed: an aperture of 2^32, or 2^64 seconds.
_MOST_APEX = 64.0
