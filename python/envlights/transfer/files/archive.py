"""One file for a model: .npz, with a version and without pickle."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from envlights._common.printable import printable_parts
from envlights.transfer.compact import CompactBasis, places_of
from envlights.transfer.files import npz_file
from envlights.transfer.files.npz_file import Kind
from envlights.transfer.pairs import PairSummary
from envlights.transfer.report import TransferReport

#: Arrays of a `PairSummary`, in the order of its fields.
_SUMMARY = ("direct", "coefficients", "outside", "energy")
#: Version 1 had wall times in its report; no model before version 3 was non-negative, and none
#: before version 4 had a prior. `scales` are those of a compact basis.
_KIND = Kind(
    "model",
    "envlights transfer model",
    4,
    (1, 2, 3, 4),
    (
        *("basis", "scales", "lit", "transfer", "mean", "size"),
        *_SUMMARY,
        *("parameters", "report"),
    ),
)

_Model = TypeVar("_Model")


def save(path: str | os.PathLike[str], fields: Mapping[str, Any]) -> None:
    """Write the `fields` of a `TransferModel` to `path`; a failure leaves no file behind."""
    arrays = {
        **_basis_arrays(fields["basis"]),
        **{name: fields[name] for name in ("lit", "transfer", "mean")},
        "size": np.array(fields["size"]),
        **vars(fields["learnt"]),
        "parameters": np.array(json.dumps(dict(fields["parameters"]))),
        "report": np.array(json.dumps(fields["report"].to_dict())),
    }
    npz_file.write(path, _KIND, arrays)


def _basis_arrays(basis: NDArray[Any] | CompactBasis) -> dict[str, Any]:
    if not isinstance(basis, CompactBasis):
        return {"basis": basis}
    return {"basis": basis.values, "scales": basis.scales}


def load(path: str | os.PathLike[str], model: Callable[..., _Model]) -> _Model:
    """Read the fields that `save` wrote and call `model` with them, or refuse the file."""
    return npz_file.load(path, _KIND, lambda data: model(**_fields(data)))


def _fields(data: Mapping[str, NDArray[Any]]) -> dict[str, Any]:
    """The fields of a `TransferModel`, whose constructor checks them."""
    return {
        "basis": _basis(data),
        **{name: data[name] for name in ("lit", "transfer", "mean")},
        "size": tuple(data["size"].tolist()),
        "learnt": PairSummary(*(data[name] for name in _SUMMARY)),
        "parameters": {"nonnegative": False, "prior": False, **json.loads(str(data["parameters"]))},
        "report": TransferReport.from_dict(printable_parts(json.loads(str(data["report"])))),
    }


def _basis(data: Mapping[str, NDArray[Any]]) -> NDArray[Any] | CompactBasis:
    if "scales" not in data:
        return data["basis"]
    return CompactBasis(data["basis"], data["scales"], places_of(data["lit"]))
