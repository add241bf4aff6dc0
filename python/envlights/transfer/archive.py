"""One file for a model: .npz, with a version and without pickle."""

from __future__ import annotations

import json
import os
import zipfile
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from envlights._native import EnvLightsError
from envlights.io.files import as_path, write_atomically
from envlights.transfer.compact import CompactBasis, places_of
from envlights.transfer.learnt import Learnt
from envlights.transfer.report import TransferReport

#: Errors of numpy and zipfile at damaged bytes, which may ask for a password or a compression.
_DAMAGE = (
    AttributeError,
    EOFError,
    KeyError,
    MemoryError,
    RuntimeError,
    TypeError,
    ValueError,
    zipfile.BadZipFile,
    zlib.error,
)

_FORMAT = "envlights transfer model"
_VERSION = 1

_Model = TypeVar("_Model")


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
    # An open file keeps its name: numpy would add a suffix to one in capitals.
    with path.open("wb") as file:
        np.savez(file, **arrays)


def check_suffix(path: str | os.PathLike[str]) -> None:
    """Refuse a name that does not end in .npz."""
    if as_path(path).suffix.lower() != ".npz":
        raise EnvLightsError(f"cannot save a model as {path}; the suffix must be .npz")


def load(path: str | os.PathLike[str], model: Callable[..., _Model]) -> _Model:
    """Read the fields that `save` wrote and call `model` with them, or refuse the file."""
    data = _read(path)
    _check_version(path, data)
    try:
        _check_finite(data)
        return model(**_fields(data))
    except _DAMAGE as error:
        raise EnvLightsError(f"{path} does not hold a model: {_reason(error)}") from None


def _read(path: str | os.PathLike[str]) -> dict[str, NDArray[Any]]:
    """All arrays of the file."""
    try:
        # numpy leaves a file open that it opened and cannot read.
        with as_path(path).open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            return {name: arrays[name] for name in arrays.files}
    except OSError as error:
        raise EnvLightsError(f"cannot read {path}: {error.strerror or error}") from None
    except _DAMAGE as error:
        raise EnvLightsError(f"{path} is not a complete .npz file: {error}") from None


def _check_version(path: object, data: Mapping[str, Any]) -> None:
    if str(data.get("format")) != _FORMAT:
        raise EnvLightsError(f"{path} is not a model: it does not say 'format': '{_FORMAT}'")
    if (found := str(data.get("version"))) != str(_VERSION):
        raise EnvLightsError(f"{path} is a model of version {found}; this package reads {_VERSION}")


def _check_finite(data: Mapping[str, NDArray[Any]]) -> None:
    for name, array in data.items():
        if array.dtype.kind == "f" and not np.isfinite(array).all():
            raise EnvLightsError(f"{name} must be finite")


def _fields(data: Mapping[str, NDArray[Any]]) -> dict[str, Any]:
    """The fields of a `TransferModel`, whose constructor checks them."""
    return {
        "basis": _basis(data),
        **{name: data[name] for name in ("lit", "transfer", "mean")},
        "size": tuple(np.ravel(data["size"]).tolist()),
        "learnt": Learnt(data["direct"], data["coefficients"], data["outside"], data["energy"]),
        "parameters": json.loads(str(data["parameters"])),
        "report": TransferReport.from_dict(json.loads(str(data["report"]))),
    }


def _basis(data: Mapping[str, NDArray[Any]]) -> NDArray[Any] | CompactBasis:
    if "scales" not in data:
        return data["basis"]
    return CompactBasis(data["basis"], data["scales"], places_of(data["lit"]))


def _reason(error: Exception) -> str:
    """The message of an error; that of a `KeyError` is the bare key."""
    return f"the entry {error} is missing" if isinstance(error, KeyError) else str(error)
