"""Readers of Radiance and PNG in Rust, with what they say in the terms of `raw_image`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.errors import DamagedFileError, FileError
from envlights._native import EnvLightsError, PngFile, RadianceFile
from envlights.environment.decoders.description import (
    description_of_png,
    description_of_radiance,
    estimates_of_description,
    layout_of_description,
)
from envlights.environment.decoders.raw_image import FileColour, Header, Part, RawImage
from envlights.environment.decoders.source import WANTED, Source

#: Names of the channels of PNG files, by their number.
_CHANNELS = {1: ("Y",), 2: ("Y", "A"), 3: ("R", "G", "B"), 4: ("R", "G", "B", "A")}
_RGB = _CHANNELS[3]


class NativeFile:
    """Open Radiance or PNG file, which has one part; see `ImageFile`."""

    def __init__(
        self,
        name: str,
        header: Header,
        rows: Callable[[], Callable[[int, int], NDArray[Any]]],
        radiance: RadianceFile | None = None,
    ) -> None:
        self._name, self._header, self._rows, self._radiance = name, header, rows, radiance
        self.parts: tuple[Part, ...] = (Part("", header.channels),)

    def image(self, part: int, channels: Sequence[str]) -> RawImage:
        """Some `channels` of the only part, in this order."""
        del part  # there is one
        known = self._header.channels
        names = tuple(channels)
        header = self._header if names == known else _with_channels(self._header, names)
        places = [known.index(channel) for channel in names]
        rows = _refusals_named(self._name, self._rows)

        def read(top: int, bottom: int) -> NDArray[Any]:
            samples: NDArray[Any] = _refusals_named(self._name, lambda: rows(top, bottom))
            return samples if names == known else samples[..., places]

        return RawImage(header, read, header.height, self._radiance if names == known else None)

    def close(self) -> None:
        """Close the file; its bytes go with this object."""


def open_radiance(source: Source, max_pixels: int) -> NativeFile:
    """Radiance picture, with its lines found."""
    data = source.content()
    picture = _refusals_named(source.name, lambda: RadianceFile(data, max_pixels))
    description = description_of_radiance(data)
    header = Header(
        width=picture.width,
        height=picture.height,
        kind="radiance",
        dtype=np.dtype(np.float32),
        channels=_RGB,
        colour=FileColour(chromaticities=picture.primaries, is_xyz=picture.is_xyz),
        orientation=picture.orientation,
        exposure=picture.exposure,
        layout=layout_of_description(description),
        notes=estimates_of_description(description),
    )
    return NativeFile(source.name, header, lambda: picture.rows, picture)


def open_png(source: Source, max_pixels: int) -> NativeFile:
    """PNG file, with its header read; the first request for rows unpacks all of them."""
    data = source.content()
    picture = _refusals_named(source.name, lambda: PngFile(data, max_pixels))
    description = description_of_png(data)
    channels = _CHANNELS[picture.channels]
    header = Header(
        width=picture.width,
        height=picture.height,
        kind="png",
        dtype=np.dtype(np.uint16 if picture.is_16_bit else np.uint8),
        channels=channels,
        colour=FileColour(
            cicp=picture.cicp,
            icc=picture.icc,
            is_srgb=picture.is_srgb,
            gamma=picture.gamma,
            chromaticities=picture.chromaticities,
        ),
        orientation=picture.orientation,
        alpha="straight" if "A" in channels else "none",
        xmp=picture.xmp,
        layout=layout_of_description(description),
        notes=(*_note_of_animation(picture), *estimates_of_description(description)),
    )

    def rows() -> Callable[[int, int], NDArray[Any]]:
        samples = picture.read()
        return lambda top, bottom: samples[top:bottom]

    return NativeFile(source.name, header, rows)


def _with_channels(header: Header, channels: tuple[str, ...]) -> Header:
    """Header of fewer channels."""
    return replace(header, channels=channels, alpha=header.alpha if "A" in channels else "none")


def _refusals_named(name: str, work: Callable[[], Any]) -> Any:
    """Result of `work`, whose refusals get the name of the file."""
    try:
        return work()
    except EnvLightsError as refusal:
        if str(refusal).startswith("an image may have up to"):
            way_out = "if it is not damaged, give a higher max_pixels"
            raise FileError(f"cannot read {name}: {refusal}; {way_out}") from None
        raise DamagedFileError(f"cannot read {name}: {refusal}; {WANTED}") from None


def _note_of_animation(picture: PngFile) -> tuple[str, ...]:
    return ("only the first image of the animation was read",) if picture.is_animated else ()
