"""Exposure of a photograph from its EXIF: time, sensitivity and aperture."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

#: Largest plausible logarithm in the APEX system: an aperture of 2^32, or 2^64 seconds.
_MOST_APEX = 64.0


def exposure_of(exif: Mapping[str, float]) -> dict[str, float]:
    """Exposure time in seconds, sensitivity and aperture; keys missing in the EXIF are absent."""
    found = {
        "time": _number_or_apex(exif, "ExposureTime", "ShutterSpeedValue", lambda apex: 2.0**-apex),
        "speed": above_0(exif, "PhotographicSensitivity"),
        "aperture": _number_or_apex(exif, "FNumber", "ApertureValue", lambda apex: 2 ** (apex / 2)),
    }
    return {key: value for key, value in found.items() if value}


def ev100_of(tags: Mapping[str, float]) -> float | None:
    """Exposure value at ISO 100, log2(N^2 / t * 100 / S); None if a tag is missing."""
    if set(tags) != {"time", "speed", "aperture"}:
        return None
    return math.log2(tags["aperture"] ** 2 / tags["time"] * 100 / tags["speed"])


def above_0(exif: Mapping[str, float], name: str) -> float | None:
    """Value of a tag if a camera can have it, above 0; otherwise None."""
    value = exif.get(name, 0.0)
    return value if 2.0**-_MOST_APEX <= value <= 2.0**_MOST_APEX else None


def _number_or_apex(
    exif: Mapping[str, float], name: str, apex_name: str, of_apex: Callable[[float], float]
) -> float | None:
    """Value of a tag, or the value that its APEX logarithm gives."""
    if value := above_0(exif, name):
        return value
    apex = exif.get(apex_name, math.nan)
    return of_apex(apex) if abs(apex) <= _MOST_APEX else None
