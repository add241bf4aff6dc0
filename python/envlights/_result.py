"""The base of all results."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import fields
from typing import Any

import numpy as np

from envlights import _html


class Result(ABC):
    """A dataclass whose `repr` is one line, which Jupyter shows in full, and which has an equality.

    Two are equal if they are of one class and all they hold is, arrays value by value; a field with
    ``compare=False``, such as wall times, does not count. What is compared so cannot be hashed.

    Copies and pickles are rebuilt by the constructor. So a class whose constructor checks its
    arrays, or closes them to writing, does so for copies too; this base does neither.
    """

    @abstractmethod
    def in_short(self) -> str:
        """The line, without the name of the class."""

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.in_short()}>"

    def _repr_pretty_(self, printer: Any, _: bool) -> None:
        """All of it where it stands alone, one line where it stands in a list or the like."""
        printer.text(repr(self) if printer.indentation else str(self))

    def _repr_html_(self) -> str:
        return _html.block(type(self).__name__, self.in_short(), *self._html_parts())

    def _html_parts(self) -> Iterable[str]:
        """What stands below the line: tables, pictures, text."""
        return (_html.lines(str(self)),)

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        names = [each.name for each in fields(self) if each.compare]  # type: ignore[arg-type]
        return all(_is_same(getattr(self, name), getattr(other, name)) for name in names)

    __hash__ = None  # type: ignore[assignment]  # as of a list: equality is that of the content

    def __reduce__(self) -> tuple[Any, ...]:
        given = (each for each in fields(self) if each.init)  # type: ignore[arg-type]
        names = (each.name for each in given)
        return type(self), tuple(getattr(self, name) for name in names)


def _is_same(one: object, other: object) -> bool:
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return np.array_equal(one, other)  # type: ignore[arg-type]
    return bool(one == other)
