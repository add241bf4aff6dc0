"""Base class of all results."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import fields
from functools import partial
from typing import Any, ClassVar

import numpy as np

from envlights._common import html


class Result(ABC):
    """Dataclass with a one-line `repr`, a text, a view in Jupyter, and an equality by value.

    Two results are equal if their classes and all fields are equal, arrays value by value. A field
    with ``compare=False``, such as wall times, is not compared. Results cannot be hashed.

    The constructor makes copies and unpickled objects too, so its checks hold for them.
    """

    @abstractmethod
    def in_short(self) -> str:
        """One line, without the name of the class."""

    def verbose(self) -> str:
        """Text with all details; `str` gives the short one."""
        return str(self)

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.in_short()}>"

    def _repr_pretty_(self, printer: Any, _: bool) -> None:
        """The whole text for a single object, one line for an element of a list."""
        printer.text(repr(self) if printer.indentation else str(self))

    def _repr_html_(self) -> str:
        return html.block(type(self).__name__, self.in_short(), *self._html_parts())

    def _html_parts(self) -> Iterable[str]:
        """HTML below the line: tables, pictures, text."""
        return (html.lines(str(self)),)

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        names = [each.name for each in fields(self) if each.compare]  # type: ignore[arg-type]
        return all(_is_same(getattr(self, name), getattr(other, name)) for name in names)

    __hash__: ClassVar[None] = None  # type: ignore[assignment]  # as of a list: equality is that of the content

    def __reduce__(self) -> tuple[Any, ...]:
        arguments = [each for each in fields(self) if each.init]  # type: ignore[arg-type]
        names = {each.name: getattr(self, each.name) for each in arguments if each.kw_only}
        build = partial(type(self), **names) if names else type(self)
        return build, tuple(getattr(self, each.name) for each in arguments if not each.kw_only)


def _is_same(one: object, other: object) -> bool:
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(_is_same, one, other))
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return np.array_equal(one, other)  # type: ignore[arg-type]
    return bool(one == other)
