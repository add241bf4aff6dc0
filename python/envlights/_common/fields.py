"""Fields of results: conversion to plain JSON values, and fields computed on first access."""

from __future__ import annotations

import enum
import math
from collections.abc import Mapping
from dataclasses import fields
from functools import cache
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

import numpy as np

from envlights._common.check import amount, check_choice, count, describe, texts
from envlights._native import EnvLightsError

#: Text for infinity in files, because JSON has none.
INFINITE = "infinite"


def plain(value: Any, infinity: str | None = INFINITE) -> Any:
    """Value converted to numbers, texts, lists and dictionaries; NaN becomes None.

    Raises
    ------
    EnvLightsError
        If it holds anything else.
    """
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, enum.Enum):
        return value.name
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else infinity if math.isinf(value) else None
    if hasattr(value, "_asdict"):
        value = value._asdict()
    if isinstance(value, Mapping):
        return {str(name): plain(each, infinity) for name, each in value.items()}
    if isinstance(value, set | frozenset):  # whose order differs between processes
        return sorted((plain(each, infinity) for each in value), key=repr)
    if isinstance(value, list | tuple | range):
        return [plain(each, infinity) for each in value]
    if hasattr(value, "to_dict"):
        return plain(value.to_dict(), infinity)
    raise EnvLightsError(
        f"a row holds numbers, texts, lists and dictionaries of them; got {describe(value)};"
        " return its numbers instead"
    )


_Class = TypeVar("_Class")


def fields_of(result: Any, *left_out: str) -> dict[str, Any]:
    """Fields as plain values, except fields that equality ignores, such as wall times."""
    names = [each.name for each in fields(result) if each.compare and each.name not in left_out]
    return {name: plain(getattr(result, name)) for name in names}


def read_fields(cls: type[_Class], data: Mapping[str, Any]) -> _Class:
    """Dataclass object from the dictionary that `fields_of` returned; raises an error if invalid.

    A field that the data do not hold gets its default; without one, its name is a `KeyError`.
    """
    kinds = _kinds(cls)  # type: ignore[arg-type]
    needed = {name for name, (_, is_needed) in kinds.items() if is_needed}
    names = [name for name in kinds if name in data or name in needed]
    return cls(**{name: _read(name, kinds[name][0], data[name]) for name in names})


@cache
def _kinds(cls: type[Any]) -> dict[str, tuple[Any, bool]]:
    """Type of each field, and True if the field is required."""
    hints = get_type_hints(cls)
    return {
        each.name: (hints[each.name], each.default is each.default_factory) for each in fields(cls)
    }


def _read(name: str, kind: Any, value: Any) -> Any:
    """Value checked against its type; raises an error that names the field."""
    parts = get_args(kind)
    if type(None) in parts:
        return None if value is None else _read(name, parts[0], value)
    if get_origin(kind) is tuple:
        if parts == (str, ...):
            return tuple(texts(name, value))
        each = [parts[0]] * len(value) if parts[-1] is ... else parts
        return tuple(_read(name, part, one) for part, one in zip(each, value, strict=True))
    if parts:  # a mapping, whose keys are strings in JSON
        return {_key(name, parts[0], key): _read(name, parts[1], one) for key, one in value.items()}
    if issubclass(kind, enum.Enum):
        check_choice(name, value, tuple(kind.__members__))
        return kind[value]
    if kind is float:
        return np.inf if value == INFINITE else amount(name, value)
    if kind is int:
        return count(name, value)
    (text,) = texts(name, value)
    return text


def _key(name: str, kind: Any, key: str) -> Any:
    return count(name, int(key)) if kind is int else key


class _OnDemand:
    """Field of a dataclass whose value may be a function, which is called on first access."""

    def __init__(self, default: Any) -> None:
        self._default = default

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, instance: Any, owner: type) -> Any:
        if instance is None:
            return self._default
        values = vars(instance)
        if callable(values[self._name]):
            values[self._name] = values[self._name]()
        return values[self._name]

    def __set__(self, instance: Any, value: Any) -> None:
        vars(instance)[self._name] = value


def on_demand(default: Any) -> Any:
    """Default of a field that may be set to a function."""
    return _OnDemand(default)


def value_or_function(instance: object, name: str) -> Any:
    """Stored value of such a field, without calling the function."""
    return vars(instance)[name]
