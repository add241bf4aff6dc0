"""Focal length of a photograph in pixels, from its EXIF."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from envlights.environment.decoders.exif_exposure import above_0
from envlights.environment.decoders.native import open_native
from envlights.environment.decoders.source import Source, kind_of
from envlights.environment.files.images import MOST_PIXELS

#: Diagonal of a picture on 35 mm film, 36 x 24 mm.
_DIAGONAL_MM = math.hypot(36, 24)
#: Kinds of files with EXIF.
_WITH_EXIF = ("jpeg", "tiff", "png")
#: Millimetres per unit of FocalPlaneResolutionUnit (EXIF 2.32, section 4.6.5).
_UNITS_MM = {2.0: 25.4, 3.0: 10.0}


class FocalLength(NamedTuple):
    """Focal length of a pinhole camera, and its source."""

    pixels: float
    """Focal length in pixels of the picture."""

    origin: str
    """Source and value, for a message."""


def focal_length(source: Source, height: int, width: int) -> FocalLength | None:
    """Focal length of a picture of this size; None if missing in its EXIF.

    The equivalent on 35 mm film compares diagonals (CIPA DCG-001), so it holds for upright pictures
    and for any aspect. Without it, focal length and resolution of the sensor are combined.
    """
    kind = kind_of(source, any_format=False)
    if kind not in _WITH_EXIF:
        return None
    exif = open_native(source, kind, MOST_PIXELS).exif
    if on_film := above_0(exif, "FocalLengthIn35mmFilm"):
        pixels = on_film / _DIAGONAL_MM * math.hypot(width, height)
        return FocalLength(
            pixels, f"the EXIF (FocalLengthIn35mmFilm {on_film:g} mm, by the diagonal)"
        )
    return _on_sensor(exif, max(height, width))


def _on_sensor(exif: Mapping[str, float], longest: int) -> FocalLength | None:
    """Focal length by the sensor resolution; the picture may be a reduced one."""
    length = above_0(exif, "FocalLength")
    density = above_0(exif, "FocalPlaneXResolution")
    unit = _UNITS_MM.get(above_0(exif, "FocalPlaneResolutionUnit") or 2.0)
    sides = [above_0(exif, f"Pixel{axis}Dimension") for axis in "XY"]
    if not length or not density or not unit:
        return None
    reduction = longest / max((side for side in sides if side), default=float(longest))
    origin = f"the EXIF (FocalLength {length:g} mm and the resolution of the sensor)"
    return FocalLength(length * density / unit * reduction, origin)
