"""Exposure times from the caller or from EXIF, corrected for aperture and sensitivity."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any, NamedTuple

from envlights._common.check import describe, positive
from envlights._native import EnvLightsError
from envlights.environment.decoders import raw
from envlights.environment.decoders.exif_exposure import exposure_of
from envlights.environment.decoders.native import open_native
from envlights.environment.decoders.source import kind_of, named_source
from envlights.environment.files.images import MOST_PIXELS

#: Names of the EXIF tags in messages, by the keys of `_exif`.
_TAGS = {
    "speed": "sensitivity (PhotographicSensitivity)",
    "aperture": "aperture (FNumber or ApertureValue)",
}


class Times(NamedTuple):
    """Exposure times of a series."""

    seconds: list[float]
    """Exposure time of each picture, converted to ISO 100 and f/1."""

    are_exposures: bool
    """True if the files state time, sensitivity and aperture, so that the times have a unit."""


def exposure_times(pictures: list[Any], times: object) -> Times:
    """Exposure time of each picture, from `times` or from EXIF."""
    if times is None:
        return _of_files(pictures)
    if isinstance(times, str | dict) or not isinstance(times, Iterable):
        raise EnvLightsError(
            f"times must be a list of numbers, one for each exposure; got {describe(times)}"
        )
    by_hand = list(times)
    if len(by_hand) != len(pictures):
        raise EnvLightsError(
            f"there must be a time for each exposure ({len(pictures)}); got {len(by_hand)}"
        )
    seconds = [
        positive(f"the time of exposure {number}", time) for number, time in enumerate(by_hand, 1)
    ]
    return Times(seconds, are_exposures=False)


def _of_files(pictures: list[Any]) -> Times:
    """Time x sensitivity / aperture^2 of each file; needs the same tags in all files."""
    for number, picture in enumerate(pictures, 1):
        if not isinstance(picture, str | os.PathLike):
            raise EnvLightsError(
                f"exposure {number} is an array; arrays hold no exposure times; give times"
            )
    shots = [_exif(picture) for picture in pictures]
    for name, shown in _TAGS.items():
        without = [str(number) for number, shot in enumerate(shots, 1) if name not in shot]
        if without and len(without) < len(shots):
            raise EnvLightsError(
                f"the EXIF of some exposures holds no {shown}: {', '.join(without)} of"
                f" {len(shots)}; give times"
            )
    seconds = [
        shot["time"] * shot.get("speed", 100.0) / 100.0 / shot.get("aperture", 1.0) ** 2
        for shot in shots
    ]
    return Times(seconds, are_exposures=all(set(_TAGS) <= set(shot) for shot in shots))


def _exif(path: str | os.PathLike[str]) -> dict[str, float]:
    """Exposure time, sensitivity and aperture of a file; missing values are absent."""
    shot = raw.exposure(path) if raw.is_raw(path) else _tags(path)
    if "time" not in shot:
        raise EnvLightsError(f"{os.fsdecode(path)} holds no exposure time in its EXIF; give times")
    return shot


def _tags(path: str | os.PathLike[str]) -> dict[str, float]:
    source = named_source(path)
    kind = kind_of(source, any_format=False)
    return exposure_of(open_native(source, kind, MOST_PIXELS).exif)
