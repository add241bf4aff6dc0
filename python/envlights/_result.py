"""What every result can do."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import fields
from typing import Any


class Result(ABC):
    """A dataclass that says what it is in a line, and all of it where Jupyter shows it.

    A copy, or what a pickle holds, is made by the constructor: what that checks, and the arrays
    that it closes to writing, hold for it too.
    """

    @abstractmethod
    def in_short(self) -> str:
        """The line, without the name of the class."""

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.in_short()}>"

    def _repr_pretty_(self, printer: Any, _: bool) -> None:
        printer.text(str(self))

    def __reduce__(self) -> tuple[Any, ...]:
        names = (each.name for each in fields(self))  # type: ignore[arg-type]
        return type(self), tuple(getattr(self, name) for name in names)
