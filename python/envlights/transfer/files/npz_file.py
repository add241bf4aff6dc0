"""Files of arrays: .npz, with a format and a version, without pickle."""

from __future__ import annotations

import math
import os
import sys
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.lib.format import read_array_header_1_0, read_array_header_2_0
from numpy.typing import NDArray

from envlights._common.errors import DamagedFileError, unreadable
from envlights._common.files import DAMAGE, as_path, write_atomically
from envlights._native import EnvLightsError

#: Errors of damaged archives of arrays.
_DAMAGE = (*DAMAGE, zipfile.BadZipFile)

#: Largest size of the members for format and version, in bytes.
_LONGEST_HEAD = 4096
#: Largest accepted ratio of unpacked to packed size. Compression of zeros reaches about 1000.
_MAX_COMPRESSION_RATIO = 100

_Object = TypeVar("_Object")


class Kind(NamedTuple):
    """Kind of file."""

    noun: str
    """Word for an object in a file."""

    format: str
    """First entry of each file."""

    version: int
    """Version to write."""

    readable: tuple[int, ...]
    """Versions that can be read."""

    names: tuple[str, ...]
    """Names of the arrays besides format and version; some may be absent."""


def write(path: str | os.PathLike[str], kind: Kind, arrays: Mapping[str, Any]) -> None:
    """Write arrays to `path`; a failure leaves no file behind."""
    check_suffix(path, kind.noun)
    head = {"format": np.array(kind.format), "version": np.array(kind.version)}
    write_atomically(path, lambda beside: _savez(beside, {**head, **arrays}))


def _savez(path: Path, arrays: Mapping[str, Any]) -> None:
    # Pass an open file, because numpy would append `.npz` to a path that ends in `.NPZ`.
    with path.open("wb") as file:
        np.savez(file, **arrays)


def check_suffix(path: str | os.PathLike[str], noun: str = "model") -> None:
    """Refuse a name that does not end in .npz."""
    if as_path(path).suffix.lower() != ".npz":
        raise EnvLightsError(f"cannot save a {noun} as {path}; the suffix must be .npz")


def load(
    path: str | os.PathLike[str], kind: Kind, build: Callable[[Mapping[str, Any]], _Object]
) -> _Object:
    """Read the arrays that `write` wrote, and call `build` with them."""
    data = _read(path, kind)
    try:
        _check_finite(data)
        return build(data)
    except _DAMAGE as error:
        raise EnvLightsError(f"{path} does not hold a {kind.noun}: {_reason(error)}") from None


def _read(path: str | os.PathLike[str], kind: Kind) -> dict[str, NDArray[Any]]:
    """Arrays of one kind of file; other arrays in the file are not unpacked."""
    try:
        with as_path(path).open("rb") as file, zipfile.ZipFile(file) as archive:
            _check_version(path, kind, archive)
            names = [name for name in kind.names if f"{name}.npy" in archive.namelist()]
            _check_size(path, kind, archive, names)
            return {name: _array(archive, name) for name in names}
    except OSError as error:
        raise unreadable(path, error) from None
    except EnvLightsError:
        raise
    except _DAMAGE as error:
        raise DamagedFileError(f"{path} is not a complete .npz file: {_reason(error)}") from None


def _check_version(path: object, kind: Kind, archive: zipfile.ZipFile) -> None:
    """Refuse files of another kind and unknown versions, before anything else is read."""
    said = {}
    for name in ("format", "version"):
        is_there = f"{name}.npy" in archive.namelist()
        is_short = is_there and archive.getinfo(f"{name}.npy").file_size <= _LONGEST_HEAD
        said[name] = str(_array(archive, name)) if is_short else ""
    if said["format"] != kind.format:
        raise EnvLightsError(
            f"{path} is not a {kind.noun}: it does not say 'format': '{kind.format}'"
        )
    if said["version"] not in map(str, kind.readable):
        found = f"of version {said['version']}" if said["version"] else "without a readable version"
        wanted = ", ".join(map(str, kind.readable))
        raise EnvLightsError(f"{path} is a {kind.noun} {found}; this package reads {wanted}")


def _check_size(path: object, kind: Kind, archive: zipfile.ZipFile, names: list[str]) -> None:
    """Raise an error for arrays that would fill the memory: `save` does not compress."""
    unpacked = sum(archive.getinfo(f"{name}.npy").file_size for name in names)
    packed = sum(archive.getinfo(f"{name}.npy").compress_size for name in names)
    if unpacked > _MAX_COMPRESSION_RATIO * packed:
        raise EnvLightsError(
            f"{path} does not hold a {kind.noun}: {packed} bytes would unpack to {unpacked}, more"
            f" than {_MAX_COMPRESSION_RATIO} times as many, which a {kind.noun} never needs"
        )


def _array(archive: zipfile.ZipFile, name: str) -> NDArray[Any]:
    """Array of a member whose size agrees with its header."""
    member = f"{name}.npy"
    with archive.open(member) as file:
        version = np.lib.format.read_magic(file)
        head = {(1, 0): read_array_header_1_0, (2, 0): read_array_header_2_0}
        shape, _, dtype = head[version](file)
        expected = dtype.itemsize * math.prod(shape)
        actual = archive.getinfo(member).file_size - file.tell()
        if actual != expected:
            raise ValueError(f"{name} must hold {expected} bytes by its header; it holds {actual}")
    with archive.open(member) as file:
        array: NDArray[Any] = np.lib.format.read_array(file, allow_pickle=False)
    if array.dtype.kind == "U":
        _check_text(name, array)
    return array


def _check_text(name: str, array: NDArray[np.str_]) -> None:
    """Refuse codes beyond Unicode, which NumPy puts into strings that Python cannot use."""
    codes = np.frombuffer(array.tobytes(), np.dtype(np.uint32).newbyteorder(array.dtype.byteorder))
    if codes.max(initial=0) > sys.maxunicode:
        raise ValueError(f"{name} holds text that is no Unicode")


def _check_finite(data: Mapping[str, NDArray[Any]]) -> None:
    for name, array in data.items():
        if array.dtype.kind == "f" and not np.isfinite(array).all():
            raise EnvLightsError(f"{name} must be finite")


def _reason(error: Exception) -> str:
    """Message of an error; for `KeyError`, whose message is only the key, a sentence."""
    return f"the entry {error} is missing" if isinstance(error, KeyError) else str(error)
