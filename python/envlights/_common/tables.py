"""Tables of results: aligned text, HTML, data frames, CSV and lines of JSON.

What is missing, None or NaN, is empty in CSV and null in JSON.
"""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.files import as_path, write_content
from envlights._common.printable import printable
from envlights._native import EnvLightsError

if TYPE_CHECKING:
    import pandas as pd

#: Largest number of visible rows.
MOST_ROWS = 12


class Table(NamedTuple):
    """Table cells as text, and a summary of the hidden rows."""

    columns: Sequence[str]
    """Column names; an unnamed column holds remarks and is left-aligned."""

    rows: Sequence[Sequence[str]]
    """The cells of each row."""

    rest: str = ""
    """Summary of the hidden rows, or the text for an empty table."""

    colours: Sequence[str] = ()
    """Colour of each row as ``#rrggbb``, shown in HTML."""

    def __str__(self) -> str:
        """Text with aligned columns."""
        rest = printable(self.rest)
        if not self.rows:
            return rest
        lines = [[printable(cell) for cell in row] for row in (self.columns, *self.rows)]
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        aligns = [">" if name else "<" for name in self.columns]
        layout = list(zip(aligns, widths, strict=True))
        texts = (
            "  ".join(
                f"{cell:{align}{width}}" for cell, (align, width) in zip(line, layout, strict=True)
            )
            for line in lines
        )
        return "\n".join(filter(None, [*(text.rstrip() for text in texts), rest]))

    def html(self) -> str:
        """HTML table in the colours of its page."""
        rest = f"<div>{escape(self.rest)}</div>" if self.rest else ""
        if not self.rows:
            return rest
        names = [*([""] if self.colours else []), *self.columns]
        head = "".join(f"<th>{escape(name)}</th>" for name in names)
        swatches = [_swatch(colour) for colour in self.colours] or [""] * len(self.rows)
        body = "".join(
            f"<tr>{swatch}{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>"
            for swatch, row in zip(swatches, self.rows, strict=True)
        )
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{rest}"


def frame_of(columns: Mapping[str, NDArray[Any]]) -> pd.DataFrame:
    """Data frame of pandas; raises an error if pandas is not installed."""
    try:
        import pandas as pd
    except ImportError:
        raise EnvLightsError(
            "to_frame needs pandas: pip install 'envlights[frame]', or pip install pandas;"
            " `to_dict` needs nothing"
        ) from None
    return pd.DataFrame(columns)


def csv_text(rows: Iterable[Iterable[Any]]) -> str:
    """Lossless lines of CSV."""
    text = io.StringIO()
    lines = (["" if cell is None or cell != cell else cell for cell in row] for row in rows)
    csv.writer(text, lineterminator="\n").writerows(lines)
    return text.getvalue()


def csv_of(columns: Mapping[str, ArrayLike]) -> str:
    """CSV text of columns, with a header line."""
    cells = (np.asarray(column).tolist() for column in columns.values())
    return csv_text([columns, *zip(*cells, strict=True)])


def json_lines(rows: Iterable[Any]) -> str:
    """JSON lines, in which infinity is text."""
    import json

    return "".join(json.dumps(row, allow_nan=False) + "\n" for row in rows)


def json_text(content: Any) -> str:
    """Content of a file of JSON."""
    import json

    return json.dumps(content, indent=2) + "\n"


def check_suffix(path: str | os.PathLike[str], suffixes: Iterable[str]) -> str:
    """Suffix of a file in lower case; raises an error if it is not among `suffixes`."""
    suffix = as_path(path).suffix.lower()
    if suffix not in suffixes:
        wanted = ", ".join(suffixes)
        raise EnvLightsError(f"cannot write {path}: the suffix must be one of {wanted}")
    return suffix


def save_table(
    path: str | os.PathLike[str], writers: Mapping[str, Callable[[], str | bytes]]
) -> None:
    """Write the content that the writer for the suffix returns."""
    write_content(path, writers[check_suffix(path, writers)]())


def _swatch(colour: str) -> str:
    style = f"background:{colour};border:1px solid #808080"
    return f'<td><span style="display:inline-block;width:1em;height:1em;{style}"></span></td>'
