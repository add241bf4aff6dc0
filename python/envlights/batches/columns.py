"""Columns of the tables of a batch, with their types."""

from __future__ import annotations

import io
import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from importlib import import_module
from typing import Any

from envlights._common.check import check_choice
from envlights._common.files import check_writable
from envlights._common.tables import check_suffix, csv_text, json_lines, save_table
from envlights._native import EnvLightsError

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
    """Raise an error for an unknown table name."""
    check_choice("of", of, tuple(COLUMNS))


def flat_rows(rows: Iterable[dict[str, Any]], of: str) -> Iterator[dict[str, Any]]:
    """Flat rows of the table `of` lights or maps, all with the same columns."""
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
    flat = dict(light)
    for vector, names in _VECTORS.items():
        flat |= dict(zip(names, flat.pop(vector), strict=True))
    return flat


def _values(values: dict[str, Any]) -> dict[str, Any]:
    """Values that a user's function returned; dictionaries become JSON text."""
    return {
        f"value_{name}": json.dumps(value) if isinstance(value, dict) else value
        for name, value in values.items()
    }


#: Suffixes of tables.
SUFFIXES = (".csv", ".jsonl", ".parquet")


def save_rows(
    path: str | os.PathLike[str], rows: Sequence[dict[str, Any]], columns: Mapping[str, str]
) -> None:
    """Write rows with typed `columns`; the types of other columns follow from their values."""
    check_table(path)
    writers: dict[str, Callable[[], str | bytes]] = {
        ".csv": lambda: _csv(rows, columns),
        ".jsonl": lambda: json_lines(rows),
        ".parquet": lambda: _parquet(rows, columns),
    }
    save_table(path, writers)


def check_table(path: str | os.PathLike[str]) -> None:
    """Raise an error for a table that cannot be written, before the work."""
    if check_suffix(path, SUFFIXES) == ".parquet":
        _arrow()
    check_writable(path)


def _arrow() -> Any:
    try:
        return import_module("pyarrow")
    except ImportError:
        raise EnvLightsError(
            "a .parquet table needs pyarrow: pip install 'envlights[table]'; or write .csv"
        ) from None


def _names(rows: Sequence[dict[str, Any]], columns: Mapping[str, str]) -> list[str]:
    """Column names, including columns that only some rows have."""
    return [*columns, *dict.fromkeys(name for row in rows for name in row if name not in columns)]


def _csv(rows: Sequence[dict[str, Any]], columns: Mapping[str, str]) -> str:
    names = _names(rows, columns)
    cells = ([row.get(name) for name in names] for row in rows)
    texts = ([json.dumps(c) if isinstance(c, list) else c for c in row] for row in cells)
    return csv_text([names, *texts])


def _parquet(rows: Sequence[dict[str, Any]], columns: Mapping[str, str]) -> bytes:
    arrow = _arrow()
    types = {
        "text": arrow.string(),
        "texts": arrow.list_(arrow.string()),
        "number": arrow.float64(),
        "count": arrow.int32(),
        "flag": arrow.bool_(),
    }
    arrays = {}
    for name in _names(rows, columns):
        values = [row.get(name) for row in rows]
        kind = types[columns[name]] if name in columns else None
        arrays[name] = _column(arrow, values, kind)
    data = io.BytesIO()
    import_module("pyarrow.parquet").write_table(arrow.table(arrays), data)
    return data.getvalue()


def _column(arrow: Any, values: list[Any], kind: Any) -> Any:
    """Column with a type, or with the type of its values; mixed values become JSON text."""
    try:
        return arrow.array(values, kind)
    except (arrow.ArrowInvalid, arrow.ArrowTypeError):
        texts = [None if value is None else json.dumps(value) for value in values]
        return arrow.array(texts, arrow.string())
