"""Lines of a file's description: the layout of its picture, and estimates in its pixels.

| format   | description                                   |
|----------|-----------------------------------------------|
| OpenEXR  | attribute ``comments``                        |
| TIFF     | tag ``ImageDescription``                      |
| PNG      | text ``Description``                          |
| Radiance | lines of the header                           |
"""

from __future__ import annotations

import re

from envlights._common.notes import Note

#: Start of the line.
LAYOUT = "envlights:layout="
#: Codes of notes that a reader of the file needs: part of the light is an estimate.
_ESTIMATES = ("repaired", "sun-added")
#: Bytes of a Radiance file that are searched for the end of the header.
_LONGEST = 2**16
#: Keyword of a PNG text for a description.
_KEYWORD = b"Description\0"


def layout_of_description(description: str) -> str:
    """Statement on the layout, without the start of its line; empty if there is none."""
    for line in description.splitlines():
        text = line.lstrip("# \t")
        if text.startswith(LAYOUT):
            return text[len(LAYOUT) :].strip()
    return ""


def estimates_of_description(description: str) -> tuple[str, ...]:
    """Notes on estimates that `EnvMap.save` wrote, such as that of a repair."""
    lines = (line.lstrip("# \t") for line in description.splitlines())
    return tuple(line for line in lines if Note(line).code in _ESTIMATES)


def projection_of_layout(statement: str) -> str:
    """Value of `projection=` in a statement on the layout; empty if it names none."""
    found = re.search(r'"projection": *"([a-z-]{1,40})"', statement)
    return found[1] if found else ""


def description_of_radiance(data: bytes) -> str:
    """Header of a Radiance file."""
    return data[:_LONGEST].partition(b"\n\n")[0].decode("utf-8", "replace")


def description_of_png(data: bytes) -> str:
    """Description of a PNG file, before its samples; empty if there is none."""
    start = 8
    while start + 8 <= len(data):
        length, kind = int.from_bytes(data[start : start + 4], "big"), data[start + 4 : start + 8]
        content = data[start + 8 : start + 8 + min(length, _LONGEST)]
        if kind == b"tEXt" and content.startswith(_KEYWORD):
            return content[len(_KEYWORD) :].decode("latin-1")
        if kind == b"IDAT":
            break
        start += 12 + length
    return ""
