"""Names of the functions of the user, by which a batch knows its rows again."""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Callable
from functools import partial
from typing import Any

#: Digits of the mark of a text: 2 texts of a function meet by chance once in 2^48.
_DIGITS = 12


def name_of(function: Callable[..., Any]) -> str:
    """Module and name of a function, with a mark of its text and of arguments bound by `partial`.

    A function whose text is not in a file, such as one of C, has its name alone.
    """
    inner = function.func if isinstance(function, partial) else function
    bound = repr(function.args) if isinstance(function, partial) and function.args else ""
    named: Any = inner if hasattr(inner, "__qualname__") else type(inner)
    name = f"{named.__module__}.{named.__qualname__}"
    text = _text_of(named) + bound
    return f"{name}@{hashlib.sha256(text.encode()).hexdigest()[:_DIGITS]}" if text else name


def _text_of(function: Any) -> str:
    try:
        return inspect.getsource(function)
    except (OSError, TypeError):
        return ""
