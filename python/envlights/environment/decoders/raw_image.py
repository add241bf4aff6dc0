"""Header and samples of a file, in the sample type of the file.

A reader opens a `Source` as an `ImageFile`, whose `image` is a `RawImage`. Nothing is converted.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from envlights._common.errors import FileError

#: Rectangle of pixels: x and y of its corner, width, height.
Window = tuple[int, int, int, int]


@dataclass(frozen=True)
class FileColour:
    """Metadata of a file on its colour space; entries may contradict each other."""

    cicp: tuple[int, int, int, int] | None = None
    """Codes of primaries, transfer, matrix and full range (ITU-T H.273); PNG cICP."""

    icc: bytes = b""
    """ICC profile."""

    is_srgb: bool = False
    """True if the file names sRGB: PNG sRGB, EXIF ColorSpace 1."""

    gamma: float | None = None
    """Encoding exponent, such as 0.45455; PNG gAMA."""

    chromaticities: tuple[float, ...] | None = None
    """x and y of red, green, blue and the white point: OpenEXR, PNG cHRM, Radiance PRIMARIES."""

    is_xyz: bool = False
    """True if the samples are CIE XYZ: Radiance XYZE."""

    name: str = ""
    """Name that OpenImageIO derives, ``oiio:ColorSpace``; used only without other metadata."""


@dataclass(frozen=True)
class Header:
    """Metadata of a file on its samples."""

    width: int
    """Columns of the samples."""

    height: int
    """Rows of the samples."""

    kind: str
    """Format: "radiance", "openexr", "png", "jpeg", "tiff", or the name in OpenImageIO."""

    dtype: np.dtype[Any]
    """Type of a sample: uint8, uint16, float16 or float32; float32 for Radiance."""

    channels: tuple[str, ...]
    """Names of the channels, in the order of the samples."""

    colour: FileColour = field(default_factory=FileColour)
    """Metadata on the colour space."""

    orientation: int = 1
    """EXIF orientation, 1 to 8."""

    data_window: Window | None = None
    """Rectangle of the samples; None if they are the whole picture."""

    display_window: Window | None = None
    """Rectangle of the whole picture, in the same coordinates as the data window."""

    exposure: tuple[float, float, float] = (1.0, 1.0, 1.0)
    """Exposure multiplier of each channel; samples are divided by it.

    EXPOSURE times COLORCORR of Radiance; 1 / whiteLuminance of OpenEXR."""

    ev100: float | None = None
    """Exposure value at ISO 100 from the EXIF of integers; None if unknown."""

    has_luminance: bool = False
    """True if samples divided by `exposure` are cd/m2: OpenEXR's whiteLuminance."""

    alpha: str = "none"
    """Meaning of the alpha channel: "none", "straight" or "premultiplied"."""

    border_sampled: bool = False
    """True if the outer samples lie on the seam and the poles."""

    environment: str = ""
    """Environment attribute: "latlong", "cube", or empty."""

    cube_sides: str = ""
    """Sides of a DDS cube, in the order of the file: "+x -x +y -y +z -z"."""

    xmp: tuple[bytes, ...] = ()
    """XMP packets."""

    layout: str = ""
    """Layout text that `envlights` wrote; see `description`."""

    has_gain_map: bool = False
    """True if a gain map raises the linear samples, up to a largest value."""

    notes: tuple[str, ...] = ()
    """Notes of the reader."""


@dataclass(frozen=True)
class RawImage:
    """Header, and access to the samples while the file is open."""

    header: Header
    """Metadata of the file."""

    read_rows: Callable[[int, int], NDArray[Any]]
    """Function that returns the samples of rows from `top` to `bottom`, (rows, width, channels)."""

    rows_at_once: int = 128
    """Rows per read; a multiple of the rows that are decoded together."""

    apply_gain_map: Callable[[NDArray[np.float32], int], None] | None = None
    """Function that applies the gain map to rows of linear samples, (rows, width, 1 or 3), given
    the index of the first row.

    None for files without a gain map."""

    def rows(self, top: int, bottom: int) -> NDArray[Any]:
        """Samples of some rows, (bottom - top, width, channels), in the type of the file."""
        return self.read_rows(top, bottom)

    @property
    def samples(self) -> NDArray[Any]:
        """All samples, (height, width, channels), in the type of the file."""
        return self.rows(0, self.header.height)


@dataclass(frozen=True)
class Part:
    """Image in a file that may hold several."""

    name: str
    """Name in the file; empty if missing."""

    channels: tuple[str, ...]
    """Names of all channels."""

    view: str = ""
    """Stereo view, such as "left"; empty if the file names none."""


class ImageFile(Protocol):
    """Open file, from which channels of a part can be read."""

    @property
    def parts(self) -> tuple[Part, ...]:
        """All images in the file, in order."""

    def image(self, part: int, channels: Sequence[str]) -> RawImage:
        """Image of some `channels` of a part, in this order."""

    def close(self) -> None:
        """Close the file."""


def check_size(name: str, width: int, height: int, max_pixels: int) -> None:
    """Raise an error above `max_pixels`, because a damaged header may claim any size."""
    if width * height > max_pixels:
        raise FileError(
            f"cannot read {name}: it claims to hold {width}x{height} pixels, more than"
            f" {max_pixels}; if it is not damaged, give a higher max_pixels"
        )
