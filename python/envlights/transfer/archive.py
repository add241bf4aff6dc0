"""One file for a model: .npz, versioned, without pickle."""

from __future__ import annotations

import json
import os
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from envlights._native import EnvLightsError
from envlights.files import as_path, write_atomically
from envlights.transfer.compact import LARGEST, SHARE, TILE, CompactBasis, places_of
from envlights.transfer.learnt import Learnt
from envlights.transfer.report import TransferReport

if TYPE_CHECKING:
    from envlights.transfer.model import TransferModel

#: What numpy and zipfile raise at damaged bytes, which may ask for a password or a compression.
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


def save(path: str | os.PathLike[str], model: TransferModel) -> None:
    """Write `model` to `path`, whole or not at all."""
    check_suffix(path)
    arrays = {
        "format": np.array(_FORMAT),
        "version": np.array(_VERSION),
        **_basis_arrays(model.basis),
        "lit": model.lit,
        "transfer": model.transfer,
        "mean": model.mean,
        "size": np.array(model.size),
        "direct": model.learnt.direct,
        "coefficients": model.learnt.coefficients,
        "outside": model.learnt.outside,
        "energy": model.learnt.energy,
        "parameters": np.array(json.dumps(dict(model.parameters))),
        "report": np.array(json.dumps(model.report.to_dict())),
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
    """Refuse a name that does not say what the file holds."""
    if as_path(path).suffix.lower() != ".npz":
        raise EnvLightsError(f"cannot save a model as {path}; the suffix must be .npz")


def load(path: str | os.PathLike[str]) -> TransferModel:
    """Read the model that `save` wrote, or say why it cannot be one."""
    try:
        # numpy leaves a file open that it opened and cannot read.
        with as_path(path).open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            data = {name: arrays[name] for name in arrays.files}
    except OSError as error:
        raise EnvLightsError(f"cannot read {path}: {error.strerror or error}") from None
    except _DAMAGE as error:
        raise EnvLightsError(f"{path} is no whole .npz file: {error}") from None
    _check_version(path, data)
    try:
        return _model(data)
    except _DAMAGE as error:
        raise EnvLightsError(f"{path} holds no possible model: {error}") from None


def _check_version(path: object, data: Mapping[str, Any]) -> None:
    if str(data.get("format")) != _FORMAT:
        raise EnvLightsError(f"{path} is no model: it does not say 'format': '{_FORMAT}'")
    if (seen := str(data.get("version"))) != str(_VERSION):
        raise EnvLightsError(f"{path} is a model of version {seen}; this package reads {_VERSION}")


def _model(data: Mapping[str, Any]) -> TransferModel:
    from envlights.transfer.model import TransferModel

    _check_shapes(data)
    parameters = json.loads(str(data["parameters"]))
    if set(parameters) != {"rank", "ridge", "error"}:
        raise ValueError(f"parameters are {parameters}")
    height, width = (int(side) for side in data["size"])
    learnt = Learnt(data["direct"], data["coefficients"], data["outside"], data["energy"])
    return TransferModel(
        basis=_basis(data),
        lit=data["lit"],
        transfer=data["transfer"],
        mean=data["mean"],
        size=(height, width),
        parameters=parameters,
        learnt=learnt,
        report=TransferReport.from_dict(json.loads(str(data["report"]))),
    )


def _basis(data: Mapping[str, Any]) -> NDArray[Any] | CompactBasis:
    if "scales" not in data:
        return data["basis"]  # type: ignore[no-any-return]
    return CompactBasis(data["basis"], data["scales"], places_of(data["lit"]))


def _check_shapes(data: Mapping[str, Any]) -> None:
    """Refuse arrays that do not fit together."""
    if data["lit"].ndim != 2 or data["lit"].dtype != np.bool_:
        raise ValueError("lit is no mask of texels")
    rank = _check_tiles(data) if "scales" in data else _check_columns(data)
    lit = int(np.count_nonzero(data["lit"]))
    if data["size"].shape != (2,) or (data["size"] < 1).any():
        raise ValueError(f"size is {data['size'].tolist()}")
    texels = int(np.prod(data["size"]))
    pairs = len(data["direct"])
    seen_by_each = 3 * texels if len(data["mean"]) else texels
    wanted = {
        "mean": (lit,) if len(data["mean"]) else (0,),
        "transfer": (3, seen_by_each, rank),
        "direct": (pairs, 3, texels),
        "coefficients": (pairs, 3, rank),
        "outside": (pairs, 3, 3),
        "energy": (pairs,),
    }
    for name, shape in wanted.items():
        if data[name].shape != shape or data[name].dtype.kind != "f":
            raise ValueError(f"{name} has the shape {data[name].shape}, not {shape}")
        if not np.isfinite(data[name]).all():
            raise ValueError(f"{name} is not finite")


def _check_columns(data: Mapping[str, Any]) -> int:
    """The rank of a basis in full, or a refusal."""
    lit, rank = data["basis"].shape
    if np.count_nonzero(data["lit"]) != lit:
        raise ValueError(f"basis has {lit} texels, lit another number")
    if data["basis"].dtype.kind != "f" or not np.isfinite(data["basis"]).all():
        raise ValueError("basis is not finite")
    return int(rank)


def _check_tiles(data: Mapping[str, Any]) -> int:
    """The rank of a compact basis, or a refusal."""
    tiles, rank, lanes = data["basis"].shape
    if lanes != TILE or data["basis"].dtype.name not in LARGEST:
        raise ValueError(f"basis has tiles of {lanes} texels in {data['basis'].dtype}")
    shape = (tiles, rank, TILE // SHARE)
    if data["scales"].shape != shape or data["scales"].dtype != np.float32:
        raise ValueError(f"scales has the shape {data['scales'].shape}, not {shape}")
    if not np.isfinite(data["scales"]).all() or not np.isfinite(data["basis"]).all():
        raise ValueError("basis is not finite")
    places = places_of(data["lit"])
    if places.max() + 1 != tiles:
        raise ValueError(f"basis has {tiles} tiles, lit another number")
    return int(rank)
