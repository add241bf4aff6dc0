"""The base of all results."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import fields
from typing import Any


class Result(ABC):
    """A dataclass whose `repr` is one line, and which Jupyter shows in full.

    Copies and pickles are rebuilt by the constructor. So a class whose constructor checks its
    arrays, or closes them to writing, does so for copies too; this base does neither.
    """

    @abstractmethod
    def in_short(self) -> str:
        """The line, without the name of the class."""

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.in_short()}>"

    def _repr_pretty_(self, printer: Any, _: bool) -> None:
        printer.text(str(self))

    def __reduce__(self) -> tuple[Any, ...]:
        given = (each for each in fields(self) if each.init)  # type: ignore[arg-type]
        names = (each.name for each in given)
        return type(self), tuple(getattr(self, name) for name in names)
