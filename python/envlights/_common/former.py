"""Support for renamed names: the old name works for a version, and warns."""

from __future__ import annotations

import dataclasses
import functools
import inspect
import warnings
from collections.abc import Callable, Iterable
from operator import attrgetter
from typing import Any, TypeVar

_Class = TypeVar("_Class", bound=type)
_Function = TypeVar("_Function", bound=Callable[..., Any])


def former(old: str, new: str, owner: object, path: str, level: int) -> Any:
    """Attribute `path` of `owner`, with a warning that `old` was renamed to `new`.

    The warning names the line `level` calls above this module.
    """
    _warn(old, new, level + 2)
    return attrgetter(path)(owner)


def former_attributes(**names: str) -> Callable[[_Class], _Class]:
    """Class decorator that redirects old attributes, given as keywords, to the new ones."""

    def decorate(cls: _Class) -> _Class:
        for old, new in names.items():
            get = functools.partial(_attribute, f"{cls.__name__}.{old}", new)
            setattr(cls, old, property(get, doc=f"Former name of `{new}`."))
        return cls

    return decorate


def former_arguments(**names: str) -> Callable[[_Function], _Function]:
    """Decorator that accepts old names of renamed keywords."""

    def decorate(function: _Function) -> _Function:
        @functools.wraps(function)
        def call(*args: Any, **keywords: Any) -> Any:
            for old in [name for name in keywords if name in names]:
                _rename(function, keywords, old, names[old])
            return function(*args, **keywords)

        return call  # type: ignore[return-value]

    return decorate


def former_settings(**names: str) -> Callable[[_Function], _Function]:
    """Decorator that accepts fields of `settings`, and old names of renamed keywords."""

    def decorate(function: _Function) -> _Function:
        default = inspect.signature(function).parameters["settings"].default
        fields = {each.name for each in dataclasses.fields(default)}

        @functools.wraps(function)
        def call(*args: Any, **keywords: Any) -> Any:
            for old in [name for name in keywords if name in names]:
                _rename(function, keywords, old, names[old])
            changes = {name: keywords.pop(name) for name in [*keywords] if name in fields}
            for old in changes:
                _warn(f"{old}= of {function.__qualname__}", f"`{old}` of its settings", 3)
            if changes:
                settings = keywords.get("settings", default)
                keywords["settings"] = dataclasses.replace(settings, **changes)
            return function(*args, **keywords)

        return call  # type: ignore[return-value]

    return decorate


def former_parts(
    parameter: str, whole: Callable[..., Any], parts: Iterable[str], **names: str
) -> Callable[[_Function], _Function]:
    """Decorator that accepts parts of an argument as keywords, and old names of renamed keywords.

    ``whole(value, **parts)`` is the argument with these parts.
    """

    def decorate(function: _Function) -> _Function:
        signature = inspect.signature(function)

        @functools.wraps(function)
        def call(*args: Any, **keywords: Any) -> Any:
            for old in [name for name in keywords if name in names]:
                _rename(function, keywords, old, names[old])
            given = {name: keywords.pop(name) for name in parts if name in keywords}
            if not given:
                return function(*args, **keywords)
            bound = signature.bind_partial(*args, **keywords)
            value = whole(bound.arguments.get(parameter), **given)
            bound.arguments[parameter] = value
            form = ", ".join(f"{name}={part!r}" for name, part in given.items())
            name = function.__qualname__
            _warn(f"{name}(..., {form})", f"{name}(..., {parameter}={value!r})", 3)
            return function(*bound.args, **bound.kwargs)

        return call  # type: ignore[return-value]

    return decorate


def _rename(function: Callable[..., Any], keywords: dict[str, Any], old: str, new: str) -> None:
    """Rename a keyword from its old to its new name; raises an error if both are given."""
    if new in keywords:
        raise TypeError(f"{function.__qualname__} got both {old}= and {new}=, its present name")
    _warn(f"{old}= of {function.__qualname__}", f"{new}=", 4)
    keywords[new] = keywords.pop(old)


def _attribute(old: str, new: str, owner: object) -> Any:
    return former(old, f"`{new}`", owner, new, 2)


def _warn(old: str, new: str, level: int) -> None:
    warnings.warn(f"{old} is called {new} now", DeprecationWarning, stacklevel=level)
