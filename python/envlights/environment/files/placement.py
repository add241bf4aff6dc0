"""Placement of a picture on the sphere: data window, orientation, GPano crop."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from envlights._native import EnvLightsError
from envlights.environment.decoders import xmp
from envlights.environment.decoders.raw_image import Header, Window
from envlights.environment.files import gpano

_Samples = TypeVar("_Samples", bound=np.generic)


@dataclass(frozen=True)
class Placement:
    """Placement of the samples of a file on the whole sphere."""

    data_window: Window | None = None
    """Rectangle of the samples, if different from the display window."""

    display_window: Window | None = None
    """Rectangle of the whole picture."""

    orientation: int = 1
    """EXIF orientation."""

    crop: gpano.Crop | None = None
    """Position in the sphere; None if the picture is complete."""

    size: tuple[int, int] = (0, 0)
    """Columns and rows after the placement."""

    view: gpano.View = gpano.NO_VIEW
    """Projection of the picture."""

    notes: list[str] = field(default_factory=list)
    """Notes on the placement."""

    @property
    def is_plain(self) -> bool:
        """True if no sample is moved."""
        return not self.data_window and self.orientation == 1 and self.crop is None

    def apply(self, samples: NDArray[_Samples], border: float = 0) -> NDArray[_Samples]:
        """Samples of the whole sphere, (height, width, ...); 0 outside of a crop.

        `border` is the value between the data window and the display window.
        """
        if self.data_window and self.display_window:
            samples = _in_window(samples, self.data_window, self.display_window, border)
        samples = upright(samples, self.orientation)
        return samples if self.crop is None else _in_sphere(samples, self.crop)


def placement(header: Header) -> Placement:
    """Placement by the header; a crop is applied only to equirectangular pictures."""
    notes: list[str] = []
    size, data, display = (header.width, header.height), header.data_window, header.display_window
    if data == display:
        data = display = None
    if data and display:
        size = display[2:]
        notes.append(
            f"the data window {data} was placed in the display window {display}; the border is"
            " black"
        )
    if header.orientation != 1:
        size = size[::-1] if header.orientation > 4 else size
        notes.append(
            f"the image was rotated or mirrored by the orientation {header.orientation} of its"
            " header"
        )
    said = _properties(header)
    view = gpano.view(said, size[1])
    is_plain = view.projection in ("", "equirectangular")
    crop, crop_notes = gpano.crop(said, *size) if is_plain else (None, [])
    if crop:
        size = (crop.full_width, crop.full_height)
    notes += crop_notes + gpano.pose_notes(said)
    return Placement(data, display, header.orientation, crop, size, view, notes)


def _in_window(
    samples: NDArray[_Samples], data: Window, display: Window, border: float
) -> NDArray[_Samples]:
    """Samples moved into the display window."""
    whole = np.full((display[3], display[2], *samples.shape[2:]), border, samples.dtype)
    left, top = data[0] - display[0], data[1] - display[1]
    rows = slice(max(top, 0), min(top + data[3], display[3]))
    columns = slice(max(left, 0), min(left + data[2], display[2]))
    if rows.start < rows.stop and columns.start < columns.stop:
        inside = samples[rows.start - top : rows.stop - top]
        whole[rows, columns] = inside[:, columns.start - left : columns.stop - left]
    return whole


def _properties(header: Header) -> dict[str, str]:
    """XMP properties of a file; raises an error for unreadable packets."""
    try:
        return xmp.properties(header.xmp)
    except xmp.UnknownEncodingError as reason:
        raise EnvLightsError(
            f"its XMP packet cannot be read ({reason}), so its place on the sphere is unknown; save"
            " the packet as UTF-8, or remove it"
        ) from None


def upright(samples: NDArray[_Samples], orientation: int) -> NDArray[_Samples]:
    """Samples with row 0 at the top and column 0 at the left, from an EXIF orientation."""
    if orientation == 1:
        return samples
    if orientation > 4:
        # Rows are columns now, so the directions below refer to the transposed image.
        samples = samples.swapaxes(0, 1)
    rows = -1 if orientation in (3, 4, 7, 8) else 1
    columns = -1 if orientation in (2, 3, 6, 7) else 1
    return np.ascontiguousarray(samples[::rows, ::columns])


def _in_sphere(samples: NDArray[_Samples], crop: gpano.Crop) -> NDArray[_Samples]:
    """Samples of the whole sphere, 0 outside of the picture."""
    whole = np.zeros((crop.full_height, crop.full_width, *samples.shape[2:]), samples.dtype)
    height, width = samples.shape[:2]
    whole[crop.top : crop.top + height, crop.left : crop.left + width] = samples
    return whole
