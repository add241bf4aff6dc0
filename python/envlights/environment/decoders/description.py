"""Lines in the description of a file: the layout of its picture, and estimates in its pixels.

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

#: Beginning of the line with the layout.
LAYOUT = "envlights:layout="
#: Codes of notes that matter to later users of the file: part of the light is an estimate.
_ESTIMATES = ("repaired", "sun-added")


def layout_of_description(description: str) -> str:
    """Layout text of the description, without the beginning of its line; empty if missing."""
    for line in description.splitlines():
        text = line.lstrip("# \t")
        if text.startswith(LAYOUT):
            return text[len(LAYOUT) :].strip()
    return ""


def estimates_of_description(description: str) -> tuple[str, ...]:
    """Notes on estimates that `EnvMap.save` wrote, such as the note of a repair."""
    lines = (line.lstrip("# \t") for line in description.splitlines())
    return tuple(line for line in lines if Note(line).code in _ESTIMATES)


def projection_of_layout(statement: str) -> str:
    """Name of the projection in a layout text; empty if missing."""
    found = re.search(r'"projection": *"([a-z-]{1,40})"', statement)
    return found[1] if found else ""


#: Views of Radiance by the letter after ``-vt``; none of them is equirectangular.
_VIEWS = {
    "v": "a perspective",
    "l": "a parallel projection",
    "c": "a cylinder",
    "h": "a hemispherical fisheye",
    "a": "an angular fisheye",
    "s": "a planisphere",
}


def note_of_view(description: str) -> tuple[str, ...]:
    """Note on the view in a Radiance header; indented lines of older files do not count."""
    views = re.findall(r"^VIEW=(.*)", description, re.MULTILINE)
    # A view with angles and without a type is a perspective, as in Radiance.
    found = re.findall(r"-vt([a-z])", views[-1]) if views else []
    kind = found[-1] if found else "v" if views and re.search(r"-v[hv] ", views[-1]) else ""
    if kind not in _VIEWS:
        return ()
    return (
        f"the header says that the picture is {_VIEWS[kind]} (VIEW -vt{kind}), which was"
        " not applied; name its projection if it is no panorama",
    )
