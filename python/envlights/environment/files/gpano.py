"""Panoramas of a part of the sphere, described by GPano properties in XMP (Photo Sphere)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from envlights._common.printable import printable

#: Relative difference of two ratios that may be due to rounding to whole pixels.
_ROUNDING = 0.01
#: Pose angles in degrees, which are reported but not applied.
_POSE = ("PoseHeadingDegrees", "PosePitchDegrees", "PoseRollDegrees")


@dataclass(frozen=True)
class Crop:
    """Position of a picture in the equirectangular image of the whole sphere, in pixels."""

    full_width: int
    """Columns of the whole sphere."""

    full_height: int
    """Rows of the whole sphere."""

    left: int
    """First column of the picture."""

    top: int
    """First row of the picture."""


class View(NamedTuple):
    """Projection of a picture, with the field of view of a cylinder."""

    projection: str
    """Projection in lower case; empty if unknown."""

    field_of_view: float | None = None
    """Horizontal field of view of a cylinder, in degrees."""

    horizon: float | None = None
    """Row of elevation 0 of a cylinder."""

    stereo: str = ""
    """Stereo mode in lower case; empty for one eye."""


#: View of a picture without GPano properties.
NO_VIEW: View = View("")


def view(said: dict[str, str], height: int) -> View:
    """Projection and stereo mode, with the field of view and horizon of a cylinder.

    The top of a cropped cylinder is counted from the horizon, so it is negative. A positive one is
    counted from the top of the whole picture.
    """
    projection = printable(said.get("GPano:ProjectionType", "").lower()[:40])
    stereo = printable(said.get("GSpherical:StereoMode", "").lower()[:40])
    mode = "" if stereo == "mono" else stereo
    if projection != "cylindrical":
        return View(projection, stereo=mode)
    full_width, full_height, crop_width, crop_height, _, top = (
        _number(said, f"{key}Pixels") for key in _KEYS
    )
    degrees = 360 * crop_width / full_width if full_width and crop_width else None
    scale = height / crop_height if crop_height else 1.0
    horizon = None
    if top is not None and top < 0:
        horizon = -top * scale
    elif top is not None and full_height:
        horizon = (full_height / 2 - top) * scale
    is_usable = degrees is not None and 0 < degrees <= 360
    return View(projection, degrees if is_usable else None, horizon, mode)


def pose_notes(said: dict[str, str]) -> list[str]:
    """Note on the pose of a camera that was tilted or not facing north."""
    angles = {key: _number(said, key) for key in _POSE}
    turned = [f"{key} {angle:g}" for key, angle in angles.items() if angle]
    return [f"the camera's pose was not applied: {', '.join(turned)}"] if turned else []


def crop(said: dict[str, str], width: int, height: int) -> tuple[Crop | None, list[str]]:
    """Position of a picture of this size in the sphere, and notes.

    The numbers are scaled to a picture that was resized in proportion. Numbers that contradict the
    picture are from before an edit, so they are passed over. Missing sizes follow from the others:
    the whole sphere is twice as wide as high, and the picture is the crop.
    """
    known = {key: _number(said, f"{key}Pixels") for key in _KEYS}
    if all(number is None for number in known.values()):
        return None, []
    unreadable = [key for key in _KEYS if known[key] is None and f"GPano:{key}Pixels" in said]
    _complete(known, width, height)
    missing = unreadable or [key for key, number in known.items() if number is None]
    if missing:
        return None, [f"its GPano crop was not applied: no number for {', '.join(missing)}"]
    full_width, full_height, crop_width, crop_height, left, top = (n or 0.0 for n in known.values())
    is_whole = (crop_width, crop_height) == (full_width, full_height)
    if is_whole or (width, height) == (full_width, full_height):
        return None, []
    is_inside = min(left, top) >= 0 and left + crop_width <= full_width
    is_inside = is_inside and top + crop_height <= full_height
    is_sphere = full_height > 0 and abs(full_width / full_height - 2) < 2 * _ROUNDING
    if not (is_inside and is_sphere and _is_resized(width, height, crop_width, crop_height)):
        return None, ["its GPano crop contradicts the size of the picture and was not applied"]
    return _to_pixels(full_height, left, top, width, height, width / crop_width)


_KEYS = (
    "FullPanoWidth",
    "FullPanoHeight",
    "CroppedAreaImageWidth",
    "CroppedAreaImageHeight",
    "CroppedAreaLeft",
    "CroppedAreaTop",
)


def _complete(known: dict[str, float | None], width: int, height: int) -> None:
    """Fill in missing sizes that follow from the known ones."""
    full_width, full_height = known["FullPanoWidth"], known["FullPanoHeight"]
    if full_width is not None:
        known["FullPanoHeight"] = full_height if full_height is not None else full_width / 2
    elif full_height is not None:
        known["FullPanoWidth"] = 2 * full_height
    for key, size in (("CroppedAreaImageWidth", width), ("CroppedAreaImageHeight", height)):
        known[key] = size if known[key] is None else known[key]


def _is_resized(width: int, height: int, crop_width: float, crop_height: float) -> bool:
    """True if both sides differ from the crop by the same ratio, up to one pixel."""
    if min(crop_width, crop_height) < 1:
        return False
    expected = crop_height * width / crop_width
    return abs(height - expected) <= max(1.0, _ROUNDING * expected)


def _to_pixels(
    full_height: float, left: float, top: float, width: int, height: int, scale: float
) -> tuple[Crop, list[str]]:
    """Crop converted to pixels of the picture."""
    rows = max(round(full_height * scale), height, -(-width // 2))
    left = min(round(left * scale), 2 * rows - width)
    top = min(round(top * scale), rows - height)
    fraction = (
        f"columns {left} to {left + width} of {2 * rows}, rows {top} to {top + height} of {rows}"
    )
    note = f"the picture shows a part of the sphere (GPano): {fraction}"
    return Crop(2 * rows, rows, int(left), int(top)), [note]


def _number(said: dict[str, str], key: str) -> float | None:
    """Number of a property; None if missing or not finite."""
    try:
        value = float(said[f"GPano:{key}"])
    except (KeyError, ValueError):
        return None
    return value if abs(value) < 1e9 else None
