"""Refusals of unknown keywords that name the public function and its arguments."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from difflib import get_close_matches
from typing import Any, TypeVar

_Function = TypeVar("_Function", bound=Callable[..., Any])

#: Kinds of parameters without a name of their own.
_MANY = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)


def named_arguments(*others: Callable[..., Any]) -> Callable[[_Function], _Function]:
    """Function whose refusal of an unknown keyword names it and the argument that is meant.

    It also has the options of `others`.
    """

    def decorate(function: _Function) -> _Function:
        functions: list[Callable[..., Any]] = [function, *others]
        given = [each for one in functions for each in _parameters(one)]
        names = dict.fromkeys(each.name for each in given if each.kind not in _MANY)

        @functools.wraps(function)
        def call(*args: Any, **keywords: Any) -> Any:
            for name in keywords:
                if name not in names:
                    raise TypeError(_refusal(function.__qualname__, name, [*names]))
            return function(*args, **keywords)

        return call  # type: ignore[return-value]

    return decorate


def _parameters(function: Callable[..., Any]) -> list[inspect.Parameter]:
    return [*inspect.signature(function).parameters.values()]


def _refusal(function: str, name: str, names: list[str]) -> str:
    near = get_close_matches(name, names, n=1)
    meant = f" (did you mean {near[0]}=?)" if near else ""
    return (
        f"{function}() got an unexpected keyword argument '{name}'{meant}; it has"
        f" {', '.join(names)}"
    )
