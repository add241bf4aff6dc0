"""Text from files and paths on one line, without control characters."""

from __future__ import annotations

from typing import Any


def printable(text: str) -> str:
    r"""`text` on one line, with non-printable characters escaped as in `repr`.

    Neither escape sequences of terminals nor line breaks or changes of the direction of writing
    remain. Backslashes stay, so that text is not escaped twice.

    Examples
    --------
    >>> print(printable("Küche\x1b[31m\nnote: all is well"))
    Küche\x1b[31m\nnote: all is well
    """
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def printable_parts(data: Any) -> Any:
    """Content of a JSON file with all texts made printable."""
    if isinstance(data, str):
        return printable(data)
    if isinstance(data, list):
        return [printable_parts(each) for each in data]
    if isinstance(data, dict):
        return {printable(name): printable_parts(each) for name, each in data.items()}
    return data
