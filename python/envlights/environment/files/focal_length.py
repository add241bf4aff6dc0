"""Focal length of a photograph in pixels, from its EXIF."""

from __future__ import annotations

import math
from typing import NamedTuple

from envlights.environment.decoders.openimageio import OpenImageIOFile, open_with_openimageio
from envlights.environment.decoders.source import Source, kind_of
from envlights.environment.files.images import MOST_PIXELS

#: Diagonal of a picture on 35 mm film, 36 x 24 mm.
_DIAGONAL_MM = math.hypot(36, 24)
#: Kinds of files with EXIF.
_WITH_EXIF = ("jpeg", "tiff", "png")
#: Millimetres of the units of FocalPlaneResolutionUnit (EXIF 2.32, section 4.6.5).
_UNITS_MM = {2.0: 25.4, 3.0: 10.0}


class FocalLength(NamedTuple):
    """Focal length of a pinhole camera, and its source."""

    pixels: float
    """Focal length in pixels of the picture."""

    origin: str
    """Source, with its value, for a sentence."""


def focal_length(source: Source, height: int, width: int) -> FocalLength | None:
    """Focal length of a picture of this size; None if its EXIF holds none.

    The equivalent on 35 mm film compares diagonals (CIPA DCG-001), so it holds for upright pictures
    and for any aspect. Without it, focal length and resolution of the sensor are combined.
    """
    kind = kind_of(source, any_format=False)
    if kind not in _WITH_EXIF:
        return None
    with open_with_openimageio(source, kind, MOST_PIXELS) as file:
        on_film = file.number("Exif:FocalLengthIn35mmFilm")
        if on_film:
            pixels = on_film / _DIAGONAL_MM * math.hypot(width, height)
            return FocalLength(
                pixels, f"the EXIF (FocalLengthIn35mmFilm {on_film:g} mm, by the diagonal)"
            )
        return _on_sensor(file, max(height, width))


def _on_sensor(file: OpenImageIOFile, longest: int) -> FocalLength | None:
    """Focal length by the resolution of the sensor, of a picture that may have been reduced."""
    length = file.number("Exif:FocalLength")
    density = file.number("Exif:FocalPlaneXResolution")
    unit = _UNITS_MM.get(file.number("Exif:FocalPlaneResolutionUnit") or 2.0)
    sides = [file.number(f"Exif:Pixel{axis}Dimension") for axis in "XY"]
    if not length or not density or not unit:
        return None
    reduction = longest / max((side for side in sides if side), default=float(longest))
    origin = f"the EXIF (FocalLength {length:g} mm and the resolution of the sensor)"
    return FocalLength(length * density / unit * reduction, origin)
