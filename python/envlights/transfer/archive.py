"""One file for a model: .npz, with a version and without pickle."""

from __future__ import annotations

import json
import math
import os
import struct
import sys
import tokenize
import zipfile
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.lib.format import read_array_header_1_0, read_array_header_2_0
from numpy.typing import NDArray

from envlights._native import EnvLightsError
from envlights._printable import printable_parts
from envlights.io.errors import unreadable
from envlights.io.files import as_path, write_atomically
from envlights.transfer.compact import CompactBasis, places_of
from envlights.transfer.pair_summary import PairSummary
from envlights.transfer.report import TransferReport

#: Errors that numpy and zipfile raise for damaged files. A damaged byte can also look like a
#: request for a password or for an unknown compression.
_DAMAGE = (
    AttributeError,
    EOFError,
    KeyError,
    MemoryError,
    NotImplementedError,
    OverflowError,
    RuntimeError,
    SyntaxError,
    TypeError,
    ValueError,
    struct.error,
    tokenize.TokenError,
    zipfile.BadZipFile,
    zlib.error,
)

_FORMAT = "envlights transfer model"
_VERSION = 3
#: Version 1 had wall times in its report; no model before version 3 was non-negative.
_READABLE_VERSIONS = (1, 2, 3)

#: Arrays of a model file beside format and version; `scales` for a compact basis.
_NAMES = (
    *("basis", "scales", "lit", "transfer", "mean", "size"),
    *("direct", "coefficients", "outside", "energy"),
    *("parameters", "report"),
)
#: Largest size of the members for format and version, in bytes.
_LONGEST_HEAD = 4096
#: Largest accepted ratio of unpacked to packed size. Compression of zeros reaches about 1000.
_MAX_COMPRESSION_RATIO = 100

_Model = TypeVar("_Model")
#: Arrays of a `PairSummary`, in the order of its fields.
_SUMMARY = ("direct", "coefficients", "outside", "energy")


def save(path: str | os.PathLike[str], fields: Mapping[str, Any]) -> None:
    """Write the `fields` of a `TransferModel` to `path`; a failure leaves no file behind."""
    check_suffix(path)
    arrays = {
        "format": np.array(_FORMAT),
        "version": np.array(_VERSION),
        **_basis_arrays(fields["basis"]),
        **{name: fields[name] for name in ("lit", "transfer", "mean")},
        "size": np.array(fields["size"]),
        **vars(fields["learnt"]),
        "parameters": np.array(json.dumps(dict(fields["parameters"]))),
        "report": np.array(json.dumps(fields["report"].to_dict())),
    }
    write_atomically(path, lambda beside: _savez(beside, arrays))


def _basis_arrays(basis: NDArray[Any] | CompactBasis) -> dict[str, Any]:
    if not isinstance(basis, CompactBasis):
        return {"basis": basis}
    return {"basis": basis.values, "scales": basis.scales}


def _savez(path: Path, arrays: Mapping[str, Any]) -> None:
    # Pass an open file: numpy would append `.npz` to a path that ends in `.NPZ`.
    with path.open("wb") as file:
        np.savez(file, **arrays)


def check_suffix(path: str | os.PathLike[str]) -> None:
    """Refuse a name that does not end in .npz."""
    if as_path(path).suffix.lower() != ".npz":
        raise EnvLightsError(f"cannot save a model as {path}; the suffix must be .npz")


def load(path: str | os.PathLike[str], model: Callable[..., _Model]) -> _Model:
    """Read the fields that `save` wrote and call `model` with them, or refuse the file."""
    data = _read(path)
    try:
        _check_finite(data)
        return model(**_fields(data))
    except _DAMAGE as error:
        raise EnvLightsError(f"{path} does not hold a model: {_reason(error)}") from None


def _read(path: str | os.PathLike[str]) -> dict[str, NDArray[Any]]:
    """Arrays of a model; other arrays of the file are not unpacked."""
    try:
        with as_path(path).open("rb") as file, zipfile.ZipFile(file) as archive:
            _check_version(path, archive)
            names = [name for name in _NAMES if f"{name}.npy" in archive.namelist()]
            _check_size(path, archive, names)
            return {name: _array(archive, name) for name in names}
    except OSError as error:
        raise unreadable(path, error) from None
    except EnvLightsError:
        raise
    except _DAMAGE as error:
        raise EnvLightsError(f"{path} is not a complete .npz file: {_reason(error)}") from None


def _check_version(path: object, archive: zipfile.ZipFile) -> None:
    """Refuse files without a model and unknown versions, before anything else is read."""
    said = {}
    for name in ("format", "version"):
        is_there = f"{name}.npy" in archive.namelist()
        is_short = is_there and archive.getinfo(f"{name}.npy").file_size <= _LONGEST_HEAD
        said[name] = str(_array(archive, name)) if is_short else ""
    if said["format"] != _FORMAT:
        raise EnvLightsError(f"{path} is not a model: it does not say 'format': '{_FORMAT}'")
    if said["version"] not in map(str, _READABLE_VERSIONS):
        found = f"of version {said['version']}" if said["version"] else "without a readable version"
        wanted = ", ".join(map(str, _READABLE_VERSIONS))
        raise EnvLightsError(f"{path} is a model {found}; this package reads {wanted}")


def _check_size(path: object, archive: zipfile.ZipFile, names: list[str]) -> None:
    """Refuse arrays that would fill the memory: `save` does not compress."""
    unpacked = sum(archive.getinfo(f"{name}.npy").file_size for name in names)
    packed = sum(archive.getinfo(f"{name}.npy").compress_size for name in names)
    if unpacked > _MAX_COMPRESSION_RATIO * packed:
        raise EnvLightsError(
            f"{path} does not hold a model: {packed} bytes would unpack to {unpacked}, more than"
            f" {_MAX_COMPRESSION_RATIO} times as many, which a model never needs"
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


def _fields(data: Mapping[str, NDArray[Any]]) -> dict[str, Any]:
    """The fields of a `TransferModel`, whose constructor checks them."""
    return {
        "basis": _basis(data),
        **{name: data[name] for name in ("lit", "transfer", "mean")},
        "size": tuple(data["size"].tolist()),
        "learnt": PairSummary(
            *(data[name] for name in ("direct", "coefficients", "outside", "energy"))
        ),
        "parameters": {"nonnegative": False, **json.loads(str(data["parameters"]))},
        "report": TransferReport.from_dict(printable_parts(json.loads(str(data["report"])))),
    }


def _basis(data: Mapping[str, NDArray[Any]]) -> NDArray[Any] | CompactBasis:
    if "scales" not in data:
        return data["basis"]
    return CompactBasis(data["basis"], data["scales"], places_of(data["lit"]))


def _reason(error: Exception) -> str:
    """The message of an error; that of a `KeyError` is the bare key."""
    return f"the entry {error} is missing" if isinstance(error, KeyError) else str(error)
