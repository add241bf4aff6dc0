"""Tables of results: aligned text for a terminal, HTML for a notebook, data frames."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING, Any, NamedTuple

from numpy.typing import NDArray

from envlights._native import EnvLightsError

if TYPE_CHECKING:
    import pandas as pd

#: Largest number of visible rows.
MOST_ROWS = 12


class Table(NamedTuple):
    """Cells as text, and a line on hidden rows."""

    columns: Sequence[str]
    """Names of the columns; a column without a name holds remarks and is left-aligned."""

    rows: Sequence[Sequence[str]]
    """The cells of each row."""

    rest: str = ""
    """Summary of the hidden rows."""

    colours: Sequence[str] = ()
    """Colour of each row as ``#rrggbb``, shown in HTML."""

    def __str__(self) -> str:
        """Text with aligned columns."""
        lines = [self.columns, *self.rows]
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        aligns = [">" if name else "<" for name in self.columns]
        layout = list(zip(aligns, widths, strict=True))
        texts = (
            "  ".join(
                f"{cell:{align}{width}}" for cell, (align, width) in zip(line, layout, strict=True)
            )
            for line in lines
        )
        return "\n".join(filter(None, [*(text.rstrip() for text in texts), self.rest]))

    def html(self) -> str:
        """HTML table in the colours of its page."""
        names = [*([""] if self.colours else []), *self.columns]
        head = "".join(f"<th>{escape(name)}</th>" for name in names)
        swatches = [_swatch(colour) for colour in self.colours] or [""] * len(self.rows)
        body = "".join(
            f"<tr>{swatch}{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>"
            for swatch, row in zip(swatches, self.rows, strict=True)
        )
        rest = f"<div>{escape(self.rest)}</div>" if self.rest else ""
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{rest}"


def frame_of(columns: Mapping[str, NDArray[Any]]) -> pd.DataFrame:
    """Data frame of pandas, or a refusal if it is not installed."""
    try:
        import pandas as pd
    except ImportError:
        raise EnvLightsError(
            "to_frame needs pandas: pip install 'envlights[frame]', or pip install pandas;"
            " `to_dict` needs nothing"
        ) from None
    return pd.DataFrame(columns)


def _swatch(colour: str) -> str:
    style = f"background:{colour};border:1px solid #808080"
    return f'<td><span style="display:inline-block;width:1em;height:1em;{style}"></span></td>'
