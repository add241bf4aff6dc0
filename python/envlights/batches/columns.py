"""Columns of the tables of a batch, with their types."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from typing import Any

from envlights._common.check import check_choice

#: Errors of a rig.
ERRORS = ("error", "shadow_error", "gloss_error")

_TEXT, _TEXTS, _NUMBER, _COUNT, _FLAG = "text", "texts", "number", "count", "flag"

_OF_MAP = {
    "name": _TEXT,
    "source": _TEXT,
    "sha256": _TEXT,
    "what": _TEXT,
    "options": _TEXT,
    "version": _TEXT,
    "units": _TEXT,
    "notes": _TEXTS,
    **dict.fromkeys(ERRORS, _NUMBER),
    "ambient_red": _NUMBER,
    "ambient_green": _NUMBER,
    "ambient_blue": _NUMBER,
}
_VECTORS = {"direction": ("x", "y", "z"), "irradiance": ("red", "green", "blue")}
#: Columns of each table by name, with the type of their values; any value may be missing.
COLUMNS = {
    "maps": {
        **_OF_MAP,
        "number_of_lights": _COUNT,
        "file": _TEXT,
        "seconds": _NUMBER,
        "failure": _TEXT,
    },
    "lights": {
        **_OF_MAP,
        "light": _COUNT,
        **{name: _NUMBER for names in _VECTORS.values() for name in names},
        "angular_radius": _NUMBER,
        "fraction": _NUMBER,
        "direction_uncertainty": _NUMBER,
        "direction_tolerance": _NUMBER,
        "is_clipped": _FLAG,
        "is_cut": _FLAG,
    },
}


def check_kind(of: object) -> None:
    """Refuse the name of a table that does not exist."""
    check_choice("of", of, tuple(COLUMNS))


def flat_rows(rows: Iterable[dict[str, Any]], of: str) -> Iterator[dict[str, Any]]:
    """Rows of the table `of` lights or maps, all with the same columns."""
    check_kind(of)
    for row in rows:
        red, green, blue = row.get("ambient") or (None, None, None)
        shared = {**row, "ambient_red": red, "ambient_green": green, "ambient_blue": blue}
        if of == "lights":
            for number, light in enumerate(row.get("lights", ())):
                yield _with_columns({**shared, **_flat_light(light), "light": number}, of)
        else:
            lights = row.get("lights")
            shared["number_of_lights"] = None if lights is None else len(lights)
            yield {**_values(row.get("values", {})), **_with_columns(shared, of)}


def _with_columns(row: dict[str, Any], of: str) -> dict[str, Any]:
    return {name: row.get(name) for name in COLUMNS[of]}


def _flat_light(light: dict[str, Any]) -> dict[str, Any]:
    """A light with a column for each component of its vectors."""
    flat = dict(light)
    for vector, names in _VECTORS.items():
        flat |= dict(zip(names, flat.pop(vector), strict=True))
    return flat


def _values(values: dict[str, Any]) -> dict[str, Any]:
    """Values of a function of the user; a dict becomes text of JSON."""
    return {
        f"value_{name}": json.dumps(value) if isinstance(value, dict) else value
        for name, value in values.items()
    }
