"""One file for a prior: .npz, with a version and without pickle."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import numpy as np

from envlights.transfer.files import npz_file
from envlights.transfer.files.npz_file import Kind

_ARRAYS = ("hits", "between", "visible", "albedo", "covered", "direct_albedo")
_KIND = Kind("prior", "envlights transfer prior", 1, (1,), (*_ARRAYS, "rays", "size", "irradiance"))

_Prior = TypeVar("_Prior")


def save(path: str | os.PathLike[str], fields: Mapping[str, Any]) -> None:
    """Write the `fields` of a `TransferPrior` to `path`; a failure leaves no file behind."""
    npz_file.write(path, _KIND, {name: np.asarray(fields[name]) for name in _KIND.names})


def load(path: str | os.PathLike[str], prior: Callable[..., _Prior]) -> _Prior:
    """Read the fields that `save` wrote and call `prior` with them, or refuse the file."""
    return npz_file.load(path, _KIND, lambda data: prior(**_fields(data)))


def _fields(data: Mapping[str, Any]) -> dict[str, Any]:
    return {
        **{name: data[name] for name in _ARRAYS},
        "rays": int(data["rays"]),
        "size": tuple(data["size"].tolist()),
        "irradiance": bool(data["irradiance"]),
    }
