"""Sources of a file: path, bytes, file object, standard input, address of fsspec."""

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

#: Image files that are read.
READABLE = "a Radiance .hdr, OpenEXR, PNG, JPEG or TIFF image"
#: End of every refusal of a file.
WANTED = f"give {READABLE}"

#: Path or address of a file, its bytes, or a file object of bytes; "-" is the standard input.
AnySource = str | os.PathLike[str] | bytes | bytearray | memoryview | IO[bytes]

#: Start of an address of fsspec.
ADDRESS = re.compile(r"[a-z][a-z0-9+.-]*(::[a-z0-9+.-]+)*://", re.IGNORECASE)


@dataclass(frozen=True)
class Source:
    """A file on disk, or its bytes in memory, with a name for sentences."""

    name: str
    """Printable name."""

    path: str = ""
    """Path of a file on disk; empty for bytes."""

    data: bytes | memoryview = b""
    """Content, if there is no path."""

    def open(self) -> IO[bytes]:
        """Readable file object of the content."""
        return Path(self.path).open("rb") if self.path else io.BytesIO(self.data)

    def head(self, length: int) -> bytes:
        """First bytes."""
        with self.open() as file:
            return file.read(length)

    def content(self) -> bytes:
        """All bytes."""
        return Path(self.path).read_bytes() if self.path else bytes(self.data)

    @contextlib.contextmanager
    def path_with(self, suffix: str) -> Iterator[str]:
        """Path with this suffix, from which image libraries take the format.

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
    """True for anything that is read as a file; a memoryview may be an array as well."""
    return isinstance(value, str | os.PathLike | bytes | bytearray) or hasattr(value, "read")


def name_of(source: Any) -> str:
    """Printable name of a source, for sentences."""
    if isinstance(source, bytes | bytearray | memoryview):
        return "the bytes"
    if hasattr(source, "read"):
        name = getattr(source, "name", None)
        return printable(name) if isinstance(name, str) else "the file object"
    return printable(os.fsdecode(source))


def named_source(source: Any) -> Source:
    """Source of any kind, or a refusal of one that holds nothing."""
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
    """Bytes of a file object from its position to its end."""
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
    """Content behind an address of fsspec, such as ``https://`` or ``s3://``."""
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
    """Reason why no image can be read from a path; empty if there is none."""
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
    """Symbolic link to `path`, or a copy on systems that allow no links."""
    try:
        beside.symlink_to(path)
    except OSError:
        beside.write_bytes(path.read_bytes())
