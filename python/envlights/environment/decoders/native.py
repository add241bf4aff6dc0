"""Reader of picture files by the Rust decoders, with headers in the types of `raw_image`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.errors import DamagedFileError, FileError
from envlights._native import DamagedBytesError, EnvLightsError, PictureFile
from envlights.environment.decoders.description import (
    estimates_of_description,
    layout_of_description,
    note_of_view,
)
from envlights.environment.decoders.exif_exposure import ev100_of, exposure_of
from envlights.environment.decoders.raw_image import FileColour, Header, Part, RawImage
from envlights.environment.decoders.source import WANTED, Source

#: Kinds of files that the Rust decoders read.
KINDS = ("radiance", "openexr", "png", "jpeg", "tiff")

#: Note on a picture of high dynamic range.
_NOTE_OF_GAIN_MAP = "high dynamic range is that of the file's gain map, which ends at its maximum"
#: Rows per read; more if rows are decoded in taller groups.
_ROWS_AT_ONCE = 64


class NativeFile:
    """Open picture file; see `ImageFile`."""

    def __init__(self, name: str, file: PictureFile) -> None:
        self._name, self._file, self._said = name, file, file.parts
        self.parts: tuple[Part, ...] = tuple(
            Part(said["name"], tuple(name for name, _ in said["channels"]), said["view"])
            for said in self._said
        )

    @property
    def exif(self) -> dict[str, float]:
        """Numeric EXIF tags of the first part, by name."""
        numbers: dict[str, float] = self._said[0]["exif"]
        return numbers

    def image(self, part: int, channels: Sequence[str]) -> RawImage:
        """Image of some `channels` of a part, in this order."""
        said = self._said[part]
        types = dict(said["channels"])
        places = [self.parts[part].channels.index(channel) for channel in channels]
        chosen = {types[channel] for channel in channels}
        dtype = np.dtype(chosen.pop() if len(chosen) == 1 else np.float32)
        header = _header(said, tuple(channels), dtype)

        def rows(top: int, bottom: int) -> NDArray[Any]:
            try:
                return self._file.rows(part, places, top, bottom)
            except DamagedBytesError as refusal:
                raise DamagedFileError(
                    f"cannot read all pixels of {self._name}: {refusal}; give an undamaged file"
                ) from None
            except EnvLightsError as refusal:
                raise FileError(f"cannot read {self._name}: {refusal}") from None

        block = said["block"]
        gain = self._file.apply_gain_map if said["has_gain_map"] else None
        return RawImage(header, rows, -(-_ROWS_AT_ONCE // block) * block, gain)

    def close(self) -> None:
        """Close the file."""


def open_native(source: Source, kind: str, max_pixels: int) -> NativeFile:
    """Open file of one of `KINDS`, with its headers read."""
    data = source.content()
    file = _with_name(source.name, lambda: PictureFile(data, kind, max_pixels))
    return NativeFile(source.name, file)


def _header(said: dict[str, Any], channels: tuple[str, ...], dtype: np.dtype[Any]) -> Header:
    nits, description = said["white_luminance"], said["description"]
    is_single = dtype.kind == "u" and not said["has_gain_map"]  # exposure
    return Header(
        width=said["width"],
        height=said["height"],
        kind=said["kind"],
        dtype=dtype,
        channels=channels,
        colour=FileColour(**said["colour"]),
        orientation=said["orientation"],
        data_window=said["data_window"],
        display_window=said["display_window"],
        exposure=(1 / nits,) * 3 if nits else said["exposure"],
        ev100=ev100_of(exposure_of(said["exif"])) if is_single else None,
        has_luminance=bool(nits),
        alpha=said["alpha"] if len(channels) in (2, 4) else "none",
        border_sampled=said["border_sampled"],
        environment=said["environment"],
        xmp=said["xmp"],
        has_gain_map=said["has_gain_map"],
        layout=layout_of_description(description),
        notes=(
            *said["notes"],
            *([_NOTE_OF_GAIN_MAP] if said["has_gain_map"] else []),
            *_note_of_luminance(nits),
            *(note_of_view(description) if said["kind"] == "radiance" else ()),
            *estimates_of_description(description),
        ),
    )


def _note_of_luminance(nits: float | None) -> tuple[str, ...]:
    """Note on the luminance of a value of 1."""
    if not nits or nits == 1:
        return ()
    return (f"a value of 1 is {nits:g} cd/m2 (whiteLuminance); radiance was multiplied by it",)


def _with_name(name: str, work: Callable[[], Any]) -> Any:
    """Result of `work`; error messages get the name of the file."""
    try:
        return work()
    except DamagedBytesError as refusal:
        raise DamagedFileError(f"cannot read {name}: {refusal}; {WANTED}") from None
    except EnvLightsError as refusal:
        is_size = str(refusal).startswith("an image may have up to")
        way_out = "; if it is not damaged, give a higher max_pixels" if is_size else ""
        raise FileError(f"cannot read {name}: {refusal}{way_out}") from None
