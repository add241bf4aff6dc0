"""Base classes of all results."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import fields
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from envlights._common import html
from envlights._common.printable import printable
from envlights._common.tables import Table, frame_of

if TYPE_CHECKING:
    import pandas as pd


class Result(ABC):
    """Dataclass with a one-line `repr`, a text, a Jupyter view, and equality by value.

    A result names its short line, and perhaps a table, lines below it, and details; text and HTML
    follow. Two results are equal if their classes and all fields are equal, arrays value by value.
    A field with ``compare=False``, such as wall times, is not compared. Results cannot be hashed.

    The constructor makes copies and unpickled objects too, so its checks hold for them.
    """

    #: True if the text begins with the one-line summary, as it always does in Jupyter.
    _is_headed: ClassVar[bool] = False

    @abstractmethod
    def in_short(self) -> str:
        """One-line summary without the class name."""

    def _table(self) -> Table | None:
        """Table in the text; None if there is none."""
        return None

    def _lines(self) -> Sequence[str]:
        """Lines of the text below the table."""
        return ()

    def _details(self) -> Sequence[str]:
        """Additional lines of `verbose`."""
        return ()

    def _pictures(self) -> Iterable[str]:
        """HTML above the table."""
        return ()

    def __str__(self) -> str:
        table = self._table()
        head = [printable(self.in_short())] if self._is_headed else []
        rows = [] if table is None else [str(table)]
        return "\n".join([*head, *rows, *map(printable, self._lines())]) or repr(self)

    def verbose(self) -> str:
        """Text with all details; for the short text use `str`."""
        return "\n".join([str(self), *map(printable, self._details())])

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {printable(self.in_short())}>"

    def _repr_pretty_(self, printer: Any, _: bool) -> None:
        """Full text for a single object, one line for an element of a list."""
        printer.text(repr(self) if printer.indentation else str(self))

    def _repr_html_(self) -> str:
        return html.block(type(self).__name__, self.in_short(), *self._html_parts())

    def _html_parts(self) -> Iterable[str]:
        """HTML below the summary: pictures, table, text."""
        table = self._table()
        is_split = self._is_headed or table is not None
        text = "\n".join(map(printable, self._lines())) if is_split else str(self)
        return (*self._pictures(), "" if table is None else table.html(), html.lines(text))

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


class TableResult(Result):
    """Result that consists of a table, and converts to a data frame."""

    @abstractmethod
    def table(self) -> Table:
        """Table for the text, with at most a dozen rows."""

    @abstractmethod
    def columns(self) -> dict[str, NDArray[Any]]:
        """Columns by name, with all rows."""

    def _table(self) -> Table:
        return self.table()

    def to_frame(self) -> pd.DataFrame:
        """Data frame of `columns`; needs pandas, from the extra `frame`."""
        return frame_of(self.columns())


def _is_same(one: object, other: object) -> bool:
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(_is_same, one, other))
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return np.array_equal(one, other)  # type: ignore[arg-type]
    return bool(one == other)
