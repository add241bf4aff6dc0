"""Sources of a file: path, bytes, file object, standard input, address; kind by first bytes."""

from __future__ import annotations

import contextlib
import io
import os
import re
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import IO, Any

from envlights._common.errors import FileError, MissingFileError
from envlights._common.printable import printable
from envlights._native import EnvLightsError

#: Readable image files, for messages.
READABLE = "a Radiance .hdr, OpenEXR, PNG, JPEG or TIFF image"
#: End of every error message about a file.
WANTED = f"give {READABLE}"

#: Path or address of a file, its bytes, or a file object of bytes; "-" is the standard input.
AnySource = str | os.PathLike[str] | bytes | bytearray | memoryview | IO[bytes]

#: Pattern for the beginning of an fsspec address.
ADDRESS = re.compile(r"[a-z][a-z0-9+.-]*(::[a-z0-9+.-]+)*://", re.IGNORECASE)


@dataclass(frozen=True)
class Source:
    """File on disk, or its bytes in memory, with a name for messages."""

    name: str
    """Printable name."""

    path: str = ""
    """Path of a file on disk; empty for bytes."""

    data: bytes | memoryview = b""
    """Content, if there is no path."""

    def open(self) -> IO[bytes]:
        """Open file object for the content."""
        return Path(self.path).open("rb") if self.path else io.BytesIO(self.data)

    def head(self, length: int) -> bytes:
        """First bytes of the content."""
        with self.open() as file:
            return file.read(length)

    def content(self) -> bytes:
        """All bytes."""
        return Path(self.path).read_bytes() if self.path else bytes(self.data)

    @contextlib.contextmanager
    def path_with(self, suffix: str) -> Iterator[str]:
        """Path with this suffix, because image libraries derive the format from it.

        A path with another suffix gets a symbolic link, bytes get a temporary file.
        """
        if self.path and Path(self.path).suffix.lower() == suffix:
            yield self.path
            return
        with tempfile.TemporaryDirectory(prefix="envlights-") as folder:
            beside = Path(folder) / f"image{suffix}"
            if self.path:
                _link(beside, Path(self.path).absolute())
            else:
                beside.write_bytes(self.data)
            yield str(beside)


def is_source(value: object) -> bool:
    """True for anything that is read as a file; a memoryview is not, because it may be an array."""
    return isinstance(value, str | os.PathLike | bytes | bytearray) or hasattr(value, "read")


def name_of(source: Any) -> str:
    """Printable name of a source, for messages."""
    if isinstance(source, bytes | bytearray | memoryview):
        return "the bytes"
    if hasattr(source, "read"):
        name = getattr(source, "name", None)
        return printable(name) if isinstance(name, str) else "the file object"
    return printable(os.fsdecode(source))


def named_source(source: Any) -> Source:
    """Source of any kind; raises an error if it is empty."""
    if isinstance(source, Source):
        return source
    if isinstance(source, bytes | bytearray | memoryview):
        return _of_bytes(name_of(source), bytes(source))
    if hasattr(source, "read"):
        return _of_bytes(name_of(source), _content(source, name_of(source)))
    try:
        text = os.fsdecode(source)
    except TypeError:
        raise EnvLightsError(
            f"a path must be text, or the bytes of a file; got {type(source).__name__}; {WANTED}"
        ) from None
    if text == "-":
        return _standard_input()
    if ADDRESS.match(text):
        return _of_address(text)
    return _of_path(text)


def _of_bytes(name: str, data: bytes) -> Source:
    if not data:
        raise FileError(f"cannot read {name}: there are no bytes; {WANTED}")
    return Source(name, data=data)


def _content(file: Any, name: str) -> bytes:
    """Bytes of a file object, from its position to its end."""
    try:
        data = file.read()
    except (OSError, ValueError) as error:  # a closed file, or text that is not decodable
        raise FileError(
            f"cannot read {name}: {printable(str(error))}; give a file object opened with 'rb'"
        ) from None
    if not isinstance(data, bytes | bytearray | memoryview):
        raise FileError(
            f"cannot read {name}: it gives {type(data).__name__} instead of bytes;"
            " give a file object opened with 'rb'"
        )
    return bytes(data)


def _standard_input() -> Source:
    file = getattr(sys.stdin, "buffer", sys.stdin)
    if file is None or file.isatty():
        raise FileError(
            "cannot read the standard input: it is a terminal; send a file to it with `<` or `|`"
        )
    return _of_bytes("the standard input", _content(file, "the standard input"))


def _of_address(address: str) -> Source:
    """Content at an fsspec address, such as ``https://`` or ``s3://``."""
    name = printable(address)
    try:
        fsspec = import_module("fsspec")
    except ImportError:
        raise FileError(
            f"cannot read {name}: addresses are read by fsspec, which is not installed; install"
            " it, or give the path of a file"
        ) from None
    try:
        with fsspec.open(address, "rb") as file:
            data = file.read()
    except FileNotFoundError:
        raise MissingFileError(f"cannot read {name}: there is no such file; {WANTED}") from None
    except Exception as error:  # each file system of fsspec has its own errors
        reason = printable(str(error)) or type(error).__name__
        raise FileError(f"cannot read {name}: {reason}; give the path of a file") from None
    return _of_bytes(name, data)


def _of_path(text: str) -> Source:
    """File on disk, after a check that an image may be there."""
    name = printable(text) or "an empty path"
    try:
        obstacle = _obstacle(text)
    except (FileNotFoundError, NotADirectoryError):
        raise MissingFileError(f"cannot read {name}: there is no such file; {WANTED}") from None
    except (OSError, ValueError) as error:  # a name that is too long, or no Unicode
        obstacle = printable(getattr(error, "strerror", None) or str(error))
    if obstacle:
        raise FileError(f"cannot read {name}: {obstacle}; {WANTED}")
    return Source(name, path=text)


def _obstacle(text: str) -> str:
    """Reason why no image can be read from a path; empty if readable."""
    text.encode()
    path = Path(text)
    if not text:
        raise FileNotFoundError
    path.stat()  # raises for an impossible name, for which `exists` is False since Python 3.14
    if path.is_dir():
        return "it is a folder; give a file in it"
    if not path.is_file():
        return "it is not a regular file"
    if path.stat().st_size == 0:
        return "the file is empty"
    with path.open("rb"):
        return ""


def _link(beside: Path, path: Path) -> None:
    """Symbolic link to `path`, or a copy on systems that forbid links."""
    try:
        beside.symlink_to(path)
    except OSError:
        beside.write_bytes(path.read_bytes())


#: Number of first bytes that determine the kind.
_LENGTH = 32

#: First bytes of the supported kinds.
_READ = (
    ("radiance", b"#?"),
    ("openexr", b"\x76\x2f\x31\x01"),
    ("png", b"\x89PNG\r\n\x1a\n"),
    ("jpeg", b"\xff\xd8\xff"),
    ("tiff", b"II*\0"),
    ("tiff", b"MM\0*"),
    ("tiff", b"II+\0"),  # BigTIFF
    ("tiff", b"MM\0+"),
)

#: Advice for photographs of phones.
_HEIC = "HEIC image (`heif-convert` of libheif writes it as PNG)"

#: Advice for videos, and offset and signature of their formats.
_VIDEO = "video; `ffmpeg -i VIDEO -frames:v 1 frame.png` writes a frame of it"
_OF_VIDEO = (
    *((4, b"ftyp" + brand) for brand in (b"isom", b"iso2", b"mp4", b"avc1", b"qt  ", b"M4V")),
    (0, b"\x1aE\xdf\xa3"),  # Matroska and WebM
    (8, b"AVI "),
)

#: Name, offset and signature of image formats that are read on request. DDS is among them, though
#: cubes are often stored so: its reader had memory faults (CVE-2022-41838, CVE-2022-41999).
_ON_REQUEST = (
    ("GIF image", 0, b"GIF8"),
    ("WebP image", 8, b"WEBP"),
    ("Photoshop file", 0, b"8BPS"),
    (_HEIC, 4, b"ftyphe"),
    (_HEIC, 4, b"ftypmif1"),
    (_HEIC, 4, b"ftypmsf1"),
    ("AVIF image", 4, b"ftypavif"),
    ("Canon raw file", 4, b"ftypcrx"),
    ("DDS texture", 0, b"DDS "),
    ("BMP image", 0, b"BM"),
    ("JPEG XL image", 0, b"\xff\x0a"),
    ("JPEG XL image", 4, b"JXL "),
    ("JPEG 2000 image", 4, b"jP  "),
    ("JPEG 2000 image", 0, b"\xff\x4f\xff\x51"),
    ("PFM image", 0, b"PF"),
    ("PFM image", 0, b"Pf"),
    *((f"PNM image (P{digit})", 0, b"P%d" % digit) for digit in range(1, 8)),
    ("DPX image", 0, b"SDPX"),
    ("DPX image", 0, b"XPDS"),
    ("Cineon image", 0, b"\x80\x2a\x5f\xd7"),
    ("FITS image", 0, b"SIMPLE"),
    ("QOI image", 0, b"qoif"),
    ("Windows icon", 0, b"\0\0\1\0"),
    ("SGI image", 0, b"\x01\xda"),
    ("IFF image", 0, b"FOR4"),
)

#: Advice for textures that no library here can read.
_KTX = (
    "KTX texture, which no reader here decodes; `ktx extract` of KTX-Software writes its six faces"
    " as PNG or OpenEXR: give those"
)

#: Name, offset and signature of files that are not images.
_NO_IMAGE = (
    (_KTX, 1, b"KTX "),
    ("web page", 0, b"<!DOCTYPE html"),
    ("web page", 0, b"<!doctype html"),
    ("web page", 0, b"<html"),
    ("text of XML or SVG", 0, b"<?xml"),
    ("drawing (SVG)", 0, b"<svg"),
    (
        "pointer of Git LFS, not the file itself: `git lfs pull` fetches it",
        0,
        b"version https://git-lfs",
    ),
    ("ZIP archive", 0, b"PK\x03\x04"),
    ("gzip archive", 0, b"\x1f\x8b"),
    ("PDF document", 0, b"%PDF"),
    ("NumPy array, which `numpy.load` reads", 0, b"\x93NUMPY"),
    ("Blender file", 0, b"BLENDER"),
    ("JSON text, perhaps a rig, which `Rig.load` and `envlights export` read", 0, b"{"),
    *((_VIDEO, place, mark) for place, mark in _OF_VIDEO),
)


def kind_of(source: Source, *, any_format: bool) -> str:
    """Kind of a file; empty if OpenImageIO must read it, with `any_format`.

    Raises
    ------
    EnvLightsError
        If the first bytes are of another kind and `any_format` is False.
    """
    head = source.head(_LENGTH)
    for kind, start in _READ:
        if head.startswith(start):
            return kind
    if any_format and not head.startswith(b"KTX ", 1):
        # Name the kind of DDS, so that no other reader tries the file.
        return "dds" if head.startswith(b"DDS ") else ""
    name = _name(head, _ON_REQUEST)
    if name:
        raise FileError(
            f"cannot read {source.name}: it looks like a {name}, which is read only with"
            f" any_format=True; {WANTED}"
        )
    name = _name(head, _NO_IMAGE)
    if name:
        raise FileError(f"cannot read {source.name}: it looks like a {name}; {WANTED}")
    raise FileError(
        f"cannot read {source.name}: its first bytes are of no known image; {WANTED}, or"
        " any_format=True"
    )


def _name(head: bytes, kinds: tuple[tuple[str, int, bytes], ...]) -> str:
    for name, place, mark in kinds:
        if head[place : place + len(mark)] == mark:
            return name
    return ""
