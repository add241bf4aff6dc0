"""Exception classes for files, for callers that handle them differently."""

from __future__ import annotations

import errno

from envlights._common.printable import printable
from envlights._native import EnvLightsError


def _on_one_line(refusal: EnvLightsError) -> str:
    """Message in which names from files cannot forge lines or control a terminal."""
    return printable(super(EnvLightsError, refusal).__str__())


# The class is defined in Rust, which raises it too.
EnvLightsError.__str__ = _on_one_line  # type: ignore[method-assign, assignment]


class FileError(EnvLightsError):
    """Error for a file that cannot be read or written; the command line exits with code 1."""


class MissingFileError(FileError, FileNotFoundError):
    """Error for a file that does not exist."""

    def __init__(self, *args: object) -> None:
        super().__init__(*args)
        self.errno: int | None = errno.ENOENT


class DamagedFileError(FileError):
    """Error for a file whose content contradicts its format."""


def unreadable(path: object, error: OSError) -> FileError:
    """Error for a file that the operating system cannot open."""
    if isinstance(error, FileNotFoundError):
        return MissingFileError(f"cannot read {path}: there is no such file; check its path")
    return FileError(
        f"cannot read {path}: {error.strerror or error}; check its path and its rights"
    )
