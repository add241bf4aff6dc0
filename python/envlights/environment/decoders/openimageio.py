"""Reader of file formats without a Rust decoder, by OpenImageIO, an optional dependency."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable, Iterator, Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.errors import DamagedFileError, FileError
from envlights._common.printable import printable
from envlights.environment.decoders.description import (
    estimates_of_description,
    layout_of_description,
)
from envlights.environment.decoders.exif_exposure import ev100_of, exposure_of
from envlights.environment.decoders.raw_image import (
    FileColour,
    Header,
    Part,
    RawImage,
    check_size,
)
from envlights.environment.decoders.source import WANTED, Source

if TYPE_CHECKING:
    import OpenImageIO as oiio  # noqa: N813, its own name for itself

__all__ = ["OpenImageIOFile", "open_with_openimageio"]

#: Rows per read; more if tiles are taller.
_ROWS_AT_ONCE = 128
#: NumPy type of each readable sample format.
_DTYPES = {
    "uint8": np.uint8,
    "uint16": np.uint16,
    "half": np.float16,
    "float": np.float32,
    "double": np.float32,
}


def _library(name: str) -> Any:
    """Module OpenImageIO; raises an error for the file `name` if it is not installed."""
    try:
        return import_module("OpenImageIO")
    except ImportError:
        raise FileError(
            f"cannot read {name}: its format needs OpenImageIO, which is not installed; install the"
            " extra `formats`, or write the picture as .exr, .hdr or .png"
        ) from None


@contextlib.contextmanager
def open_with_openimageio(source: Source, kind: str, max_pixels: int) -> Iterator[OpenImageIOFile]:
    """Open file, read by the reader of `kind` only, or by any reader if `kind` is empty."""
    library = _library(source.name)
    with source.path_with(f".{kind}") if kind else _any_path(source) as path:
        file = _input_of(library, source.name, path, any_reader=not kind)
        try:
            yield OpenImageIOFile(source.name, path, file, max_pixels)
        finally:
            file.close()


@contextlib.contextmanager
def _any_path(source: Source) -> Iterator[str]:
    """Path of the source with its own suffix."""
    if source.path:
        yield source.path
        return
    with source.path_with(".image") as path:
        yield path


def _input_of(library: Any, name: str, path: str, *, any_reader: bool) -> oiio.ImageInput:
    # By default OpenImageIO multiplies the colour of some files by alpha.
    config = library.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    others = library.get_int_attribute("try_all_readers", 1)
    library.attribute("try_all_readers", int(any_reader))
    try:
        file = library.ImageInput.open(path, config)
    finally:
        library.attribute("try_all_readers", others)
    if file is None:
        reason = _failure(library).replace(path, name)
        raise DamagedFileError(f"cannot read {name} as an image: {reason}; {WANTED}")
    opened: oiio.ImageInput = file
    return opened


class OpenImageIOFile:
    """Open file with its parts; see `ImageFile`."""

    def __init__(
        self,
        name: str,
        path: str,
        file: oiio.ImageInput,
        max_pixels: int,
    ) -> None:
        self._name, self._path, self._file, self._max_pixels = name, path, file, max_pixels
        _check_spec(name, file.spec(), max_pixels)
        self.parts: tuple[Part, ...] = tuple(self._parts())

    def _parts(self) -> Iterator[Part]:
        place = 0
        while self._file.seek_subimage(place, 0):
            spec = self._file.spec()
            said = _text(spec, "oiio:subimagename")
            # Ignore names like "subimage00", which the library invents when it writes.
            name = "" if re.fullmatch(r"subimage\d+", said) else said
            yield Part(name, tuple(spec.channelnames), _text(spec, "view"))
            place += 1
        _failure(self._file)  # there is no such image

    def image(self, part: int, channels: Sequence[str]) -> RawImage:
        """Image of some `channels` of a part, in this order."""
        if not self._file.seek_subimage(part, 0):
            raise DamagedFileError(f"cannot read {self._name}: {_failure(self._file)}")
        spec = self._file.spec()
        _check_spec(self._name, spec, self._max_pixels)
        places = [spec.channelnames.index(channel) for channel in channels]
        header = self._header(spec, tuple(channels), _dtype(self._name, spec, places))
        tile = max(spec.tile_height, 1)
        return RawImage(header, self._reader(header, places), -(-_ROWS_AT_ONCE // tile) * tile)

    def _reader(self, header: Header, places: list[int]) -> Callable[[int, int], NDArray[Any]]:
        first, last = min(places), max(places) + 1
        as_type = _NAMES[header.dtype.type]
        order = [place - first for place in places]

        def rows(top: int, bottom: int) -> NDArray[Any]:
            block = _block(self._file, top, bottom, (first, last), as_type)
            if block is None or self._file.has_error:
                # Replace the path, which may belong to a temporary file.
                reason = _failure(self._file).replace(self._path, self._name)
                raise DamagedFileError(
                    f"cannot read all pixels of {self._name}: {reason}; give an undamaged file"
                )
            samples = block.reshape(bottom - top, header.width, -1)
            return samples if order == list(range(last - first)) else samples[..., order]

        return rows

    def _header(
        self, spec: oiio.ImageSpec, channels: tuple[str, ...], dtype: np.dtype[Any]
    ) -> Header:
        description = _text(spec, "ImageDescription")
        tags = {name.removeprefix("Exif:"): _number(spec.getattribute(name)) for name in _EXPOSURE}
        exif = {name: value for name, value in tags.items() if value is not None}
        return Header(
            width=spec.width,
            height=spec.height,
            kind=self._file.format_name(),
            dtype=dtype,
            channels=channels,
            colour=_colour(spec),
            orientation=_orientation(spec),
            ev100=ev100_of(exposure_of(exif)) if dtype.kind == "u" else None,
            alpha=_alpha(spec),
            environment=_environment(spec),
            cube_sides=_text(spec, "dds:CubeMapSides"),
            xmp=(_text(spec, "xmp").encode(),),
            layout=layout_of_description(description),
            notes=estimates_of_description(description),
        )

    def close(self) -> None:
        """Close the file."""
        self._file.close()


#: Attributes of the exposure of a photograph.
_EXPOSURE = (
    "ExposureTime",
    "FNumber",
    "Exif:ApertureValue",
    "Exif:ShutterSpeedValue",
    "Exif:PhotographicSensitivity",
)

#: Name in OpenImageIO of each NumPy type.
_NAMES = {np.uint8: "uint8", np.uint16: "uint16", np.float16: "half", np.float32: "float"}


def _block(
    file: oiio.ImageInput, top: int, bottom: int, channels: tuple[int, int], as_type: str
) -> NDArray[Any] | None:
    """Samples of some rows and of a range of channels, or None on failure."""
    spec, part = file.spec(), file.current_subimage()
    rows = (spec.y + top, spec.y + bottom)
    if spec.tile_width:
        columns = (spec.x, spec.x + spec.width)
        return file.read_tiles(part, 0, *columns, *rows, 0, 1, *channels, as_type)
    return file.read_scanlines(part, 0, *rows, 0, *channels, as_type)


def _check_spec(name: str, spec: oiio.ImageSpec, max_pixels: int) -> None:
    check_size(name, spec.width, spec.height, max_pixels)
    check_size(name, spec.full_width, spec.full_height, max_pixels)
    if spec.depth > 1:
        raise FileError(
            f"cannot read {name}: it is a volume of {spec.depth} slices; give a flat image"
        )
    if spec.deep:
        raise FileError(f"cannot read {name}: it is a deep image; give a flattened one")


def _dtype(name: str, spec: oiio.ImageSpec, places: list[int]) -> np.dtype[Any]:
    """Common type of the samples of some channels; float32 if types differ."""
    formats = {str(spec.channelformat(place)) for place in places}
    if others := formats - set(_DTYPES):
        raise FileError(
            f"cannot read {name}: its samples are {', '.join(sorted(others))};"
            " give floating point, uint8 or uint16"
        )
    types = {_DTYPES[one] for one in formats}
    return np.dtype(types.pop() if len(types) == 1 else np.float32)


def _colour(spec: oiio.ImageSpec) -> FileColour:
    profile = spec.getattribute("ICCProfile")
    primaries = spec.getattribute("chromaticities")
    return FileColour(
        icc=b"" if profile is None else np.asarray(profile, dtype=np.uint8).tobytes(),
        is_srgb=spec.get_int_attribute("Exif:ColorSpace", 0) == 1,
        chromaticities=tuple(float(value) for value in primaries) if primaries else None,
        name=_text(spec, "oiio:ColorSpace"),
    )


def _environment(spec: oiio.ImageSpec) -> str:
    """Environment attribute: "latlong", "cube", or empty."""
    said = _text(spec, "textureformat")
    return "cube" if "CubeFace" in said else "latlong" if "LatLong" in said else ""


def _orientation(spec: oiio.ImageSpec) -> int:
    """EXIF orientation; 1 for values that EXIF does not define."""
    said = spec.get_int_attribute("Orientation", 1)
    return said if said in range(1, 9) else 1


def _alpha(spec: oiio.ImageSpec) -> str:
    if spec.alpha_channel < 0:
        return "none"
    is_straight = spec.get_int_attribute("oiio:UnassociatedAlpha", 0) == 1
    return "straight" if is_straight else "premultiplied"


def _text(spec: oiio.ImageSpec, key: str) -> str:
    """Text of an attribute; empty if missing."""
    try:
        value = spec.getattribute(key)
    except UnicodeDecodeError:
        return ""
    return value if isinstance(value, str) else ""


def _number(value: Any) -> float | None:
    """Number or fraction of an attribute as a finite float; None for other values."""
    if isinstance(value, tuple):
        value = value[0] / value[1] if len(value) == 2 and value[1] else None
    return float(value) if isinstance(value, int | float) and np.isfinite(value) else None


def _failure(source: Any) -> str:
    """Message of the last failure of OpenImageIO or of a file."""
    try:
        message = source.geterror()
    except UnicodeDecodeError:  # it repeats the bytes of a damaged header
        return "its header is damaged"
    lines = [printable(line.strip()) for line in message.splitlines()]
    return "; ".join(filter(None, lines)).rstrip(".?") or "OpenImageIO gives no reason"
