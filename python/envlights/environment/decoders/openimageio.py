"""Reader of files by OpenImageIO, in their own type, and access to that library.

The library is loaded when a file is first read or written, because loading is slow.
"""

from __future__ import annotations

import contextlib
import os
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from functools import cache
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
from envlights.environment.decoders.jpeg_segments import Segments, segments
from envlights.environment.decoders.raw_image import FileColour, Header, Part, RawImage, Window
from envlights.environment.decoders.source import WANTED, Source
from envlights.environment.decoders.tiff_tags import tags

if TYPE_CHECKING:
    import OpenImageIO as oiio  # noqa: N813, its own name for itself
else:

    class _OnDemand:
        def __getattr__(self, name: str) -> Any:
            return getattr(import_module("OpenImageIO"), name)

    oiio = _OnDemand()

__all__ = [
    "WHITE_LUMINANCE",
    "OpenImageIOFile",
    "failure",
    "oiio",
    "open_with_openimageio",
]

#: Suffix from which the library takes the reader of a kind.
_SUFFIXES = {
    "radiance": ".hdr",
    "openexr": ".exr",
    "png": ".png",
    "jpeg": ".jpg",
    "tiff": ".tif",
    "dds": ".dds",
}
#: Attribute of OpenEXR: luminance of RGB (1, 1, 1) in cd/m2.
WHITE_LUMINANCE = "whiteLuminance"
#: Rows of one read, or more if tiles are taller.
_ROWS_AT_ONCE = 128
#: NumPy type of each sample format that is read.
_DTYPES = {
    "uint8": np.uint8,
    "uint16": np.uint16,
    "half": np.float16,
    "float": np.float32,
    "double": np.float32,
}
#: Releases of OpenEXR that mend the memory faults published up to August 2026, such as
#: CVE-2026-68513 and CVE-2026-68514, by their first two numbers. Older lines have no such release.
_SAFE_OPENEXR = {(3, 2): 11, (3, 3): 13, (3, 4): 14}


@contextlib.contextmanager
def open_with_openimageio(source: Source, kind: str, max_pixels: int) -> Iterator[OpenImageIOFile]:
    """Open file of a kind, by the reader of this kind alone; an empty kind tries all readers."""
    jpeg = segments(source) if kind == "jpeg" else None
    page = tags(source) if kind == "tiff" else None
    for size in (jpeg, page):  # before the library allocates memory
        if size:
            check_size(source.name, size.width, size.height, max_pixels)
    xmp = jpeg.xmp if jpeg else page.xmp if page else b""
    with source.path_with(_SUFFIXES[kind]) if kind else _any_path(source) as path:
        file = _input_of(source.name, path, any_reader=not kind)
        try:
            yield OpenImageIOFile(source.name, path, file, max_pixels, xmp, jpeg)
        finally:
            file.close()


@contextlib.contextmanager
def _any_path(source: Source) -> Iterator[str]:
    """Path with its own suffix."""
    if source.path:
        yield source.path
        return
    with source.path_with(".image") as path:
        yield path


def _input_of(name: str, path: str, *, any_reader: bool) -> oiio.ImageInput:
    # By default OpenImageIO multiplies the colour of some files by alpha.
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    others = oiio.get_int_attribute("try_all_readers", 1)
    oiio.attribute("try_all_readers", int(any_reader))
    try:
        file = oiio.ImageInput.open(path, config)
    finally:
        oiio.attribute("try_all_readers", others)
    if file is None:
        reason = failure(oiio).replace(path, name)
        if "Subsampled channels" in reason:
            raise FileError(f"cannot read {name}: {_SUBSAMPLED}")
        raise DamagedFileError(f"cannot read {name} as an image: {reason}; {WANTED}")
    return file


_SUBSAMPLED = (
    "it holds luminance and chroma of half resolution (Y, RY, BY), which are not converted;"
    " give R, G and B"
)


class OpenImageIOFile:
    """Open file with its parts; see `ImageFile`."""

    def __init__(
        self,
        name: str,
        path: str,
        file: oiio.ImageInput,
        max_pixels: int,
        xmp: bytes,
        jpeg: Segments | None,
    ) -> None:
        self._name, self._path, self._file, self._max_pixels = name, path, file, max_pixels
        self._xmp, self._jpeg = xmp, jpeg
        _check_spec(name, file.spec(), max_pixels)
        self.parts: tuple[Part, ...] = tuple(self._parts())

    def _parts(self) -> Iterator[Part]:
        place = 0
        while self._file.seek_subimage(place, 0):
            spec = self._file.spec()
            said = _text(spec, "oiio:subimagename")
            # The library invents names like "subimage00" when it writes.
            name = "" if re.fullmatch(r"subimage\d+", said) else said
            yield Part(name, tuple(spec.channelnames), _text(spec, "view"))
            place += 1
        failure(self._file)  # there is no such image

    def image(self, part: int, channels: Sequence[str]) -> RawImage:
        """Some `channels` of a part, in this order."""
        if not self._file.seek_subimage(part, 0):
            raise DamagedFileError(f"cannot read {self._name}: {failure(self._file)}")
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
                # The path may be that of a temporary file.
                reason = failure(self._file).replace(self._path, self._name)
                raise DamagedFileError(
                    f"cannot read all pixels of {self._name}: {reason}; give an undamaged file"
                )
            samples = block.reshape(bottom - top, header.width, -1)
            return samples if order == list(range(last - first)) else samples[..., order]

        return rows

    def _header(
        self, spec: oiio.ImageSpec, channels: tuple[str, ...], dtype: np.dtype[Any]
    ) -> Header:
        kind = self._file.format_name()
        kind = "radiance" if kind == "hdr" else kind
        data: Window = (spec.x, spec.y, spec.width, spec.height)
        display: Window = (spec.full_x, spec.full_y, spec.full_width, spec.full_height)
        environment = _environment(spec)
        # Only OpenEXR has windows; offsets of PNG and TIFF are places on a page. The display window
        # of a cube is one face.
        has_windows = kind == "openexr" and data != display and environment != "cube"
        is_applied = kind == "jpeg" and dtype.kind == "f"
        nits = _number(spec.getattribute(WHITE_LUMINANCE)) if kind == "openexr" else None
        description = _text(spec, "ImageDescription")
        notes = (*_notes(kind, nits), *self._gain_map_notes(is_applied=is_applied))
        return Header(
            width=spec.width,
            height=spec.height,
            kind=kind,
            dtype=dtype,
            channels=channels,
            colour=_colour(spec),
            orientation=_orientation(spec),
            data_window=data if has_windows else None,
            display_window=display if has_windows else None,
            exposure=(1 / nits,) * 3 if nits else (1.0, 1.0, 1.0),
            ev100=_ev100(spec) if dtype.kind == "u" else None,
            has_luminance=bool(nits),
            alpha=_alpha(spec),
            border_sampled=bool(spec.getattribute("oiio:sampleborder")),
            environment=environment,
            cube_sides=_text(spec, "dds:CubeMapSides"),
            xmp=self._xmp or _text(spec, "xmp").encode(),
            layout=layout_of_description(description),
            has_gain_map=is_applied,
            notes=(*notes, *estimates_of_description(description)),
        )

    def _gain_map_notes(self, *, is_applied: bool) -> list[str]:
        if is_applied:
            return ["high dynamic range is that of the file's gain map, which ends at its maximum"]
        if self._jpeg and self._jpeg.has_gain_map:
            return ["the file's gain map was not applied, so its high dynamic range was left out"]
        return []

    def attribute(self, name: str) -> Any:
        """Value of an attribute of the first part; None if there is none."""
        self._file.seek_subimage(0, 0)
        return self._file.spec().getattribute(name)

    def number(self, name: str, least: float = 0.0) -> float | None:
        """Value of a numeric attribute above `least`; None if there is none."""
        return _number(self.attribute(name), least)

    def close(self) -> None:
        """Close the file."""
        self._file.close()


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
    refusals = [
        (
            # OpenImageIO 3.2.2 returns freed memory for these.
            spec.tile_width > 0 and spec.format == oiio.DOUBLE,
            "it holds tiles of float64, which OpenImageIO misreads; give float32, or no tiles",
        ),
        (spec.depth > 1, f"it is a volume of {spec.depth} slices; give a flat image"),
        (spec.deep, "it is a deep image; give a flattened one"),
    ]
    for is_so, reason in refusals:
        if is_so:
            raise FileError(f"cannot read {name}: {reason}")


def _dtype(name: str, spec: oiio.ImageSpec, places: list[int]) -> np.dtype[Any]:
    """Type of the samples of some channels; float32 for a mixture."""
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
    """EXIF orientation; values that EXIF does not define are passed over."""
    said = spec.get_int_attribute("Orientation", 1)
    return said if said in range(1, 9) else 1


def _alpha(spec: oiio.ImageSpec) -> str:
    if spec.alpha_channel < 0:
        return "none"
    is_straight = spec.get_int_attribute("oiio:UnassociatedAlpha", 0) == 1
    return "straight" if is_straight else "premultiplied"


def _text(spec: oiio.ImageSpec, key: str) -> str:
    """Text of an attribute; empty if there is none."""
    try:
        value = spec.getattribute(key)
    except UnicodeDecodeError:
        return ""
    return value if isinstance(value, str) else ""


def _number(value: Any, least: float = 0.0) -> float | None:
    """`value` of an attribute, a number or a fraction, as a float above `least`; else None."""
    if isinstance(value, tuple) and len(value) == 1:  # the sensitivity of a TIFF
        value = value[0]
    if isinstance(value, tuple):
        value = value[0] / value[1] if len(value) == 2 and value[1] else None
    is_number = isinstance(value, int | float) and np.isfinite(value) and value > least
    return float(value) if is_number else None


def _ev100(spec: oiio.ImageSpec) -> float | None:
    """Exposure value at ISO 100 of a photograph; None if its EXIF does not determine it."""
    return ev100_of(exposure_tags(lambda name, least=0.0: _number(spec.getattribute(name), least)))


def _notes(kind: str, nits: float | None) -> list[str]:
    """Remarks on a reader with published memory faults, and on the luminance of a value of 1."""
    said = []
    if nits and nits != 1:
        said.append(
            f"a value of 1 is {nits:g} cd/m2 (whiteLuminance); radiance was multiplied by it"
        )
    return [*said, *(vulnerable_openexr() if kind == "openexr" else [])]


@cache
def vulnerable_openexr() -> list[str]:
    """Note on an OpenEXR library with published memory faults; empty for a newer one."""
    said = re.search(r"OpenEXR (\d+)\.(\d+)\.(\d+)", oiio.get_string_attribute("library_list"))
    if not said or is_safe_openexr(*(int(number) for number in said.groups())):
        return []
    version = ".".join(said.groups())
    return [
        f"the OpenEXR library {version} has published memory faults; update openimageio before"
        " you read files of strangers"
    ]


def is_safe_openexr(major: int, minor: int, patch: int) -> bool:
    """True for a release that mends all published memory faults."""
    least = _SAFE_OPENEXR.get((major, minor))
    return (major, minor) > max(_SAFE_OPENEXR) if least is None else patch >= least


def failure(source: Any) -> str:
    """Reason for the last failure of OpenImageIO or one of its files."""
    try:
        message = source.geterror()
    except UnicodeDecodeError:  # it repeats the bytes of a damaged header
        return "its header is damaged"
    lines = [printable(line.strip()) for line in message.splitlines()]
    return "; ".join(filter(None, lines)).rstrip(".?") or "OpenImageIO gives no reason"


def _without_threads() -> None:
    """Let a forked process write by itself.

    The threads of OpenEXR stay in the parent, and the child would wait for them for ever.
    """
    if "OpenImageIO" in sys.modules:
        oiio.attribute("exr_threads", -1)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_without_threads)
