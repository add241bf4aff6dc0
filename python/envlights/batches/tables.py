"""Files of tables: Parquet, and lines of JSON."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from envlights._common.files import as_path, write_atomically
from envlights._native import EnvLightsError

#: Suffixes of tables.
SUFFIXES = (".parquet", ".jsonl")


def save_table(
    path: str | os.PathLike[str], rows: Sequence[dict[str, Any]], columns: Mapping[str, str]
) -> None:
    """Write rows with typed `columns`; further columns get the type of their values."""
    check_table(path)
    if as_path(path).suffix.lower() == ".jsonl":
        write_atomically(path, lambda beside: _write_lines(beside, rows))
        return
    table = _arrow_table(rows, columns)
    parquet = import_module("pyarrow.parquet")
    write_atomically(path, lambda beside: parquet.write_table(table, beside))


def check_table(path: str | os.PathLike[str]) -> None:
    """Refuse a table that could not be written, before the work for it is done."""
    suffix = as_path(path).suffix.lower()
    if suffix not in SUFFIXES:
        raise EnvLightsError(
            f"cannot write {path}: the suffix must be one of {', '.join(SUFFIXES)}"
        )
    if suffix == ".parquet":
        _arrow()


def _arrow() -> Any:
    try:
        return import_module("pyarrow")
    except ImportError:
        raise EnvLightsError(
            "a .parquet table needs pyarrow: pip install 'envlights[table]'; or write .jsonl"
        ) from None


def _write_lines(path: Path, rows: Sequence[dict[str, Any]]) -> None:
    with path.open("w", encoding="utf-8") as file:
        file.writelines(json.dumps(row) + "\n" for row in rows)


def _arrow_table(rows: Sequence[dict[str, Any]], columns: Mapping[str, str]) -> Any:
    arrow = _arrow()
    types = {
        "text": arrow.string(),
        "texts": arrow.list_(arrow.string()),
        "number": arrow.float64(),
        "count": arrow.int32(),
        "flag": arrow.bool_(),
    }
    names = [*columns, *dict.fromkeys(name for row in rows for name in row if name not in columns)]
    arrays = {}
    for name in names:
        values = [row.get(name) for row in rows]
        kind = types[columns[name]] if name in columns else None
        arrays[name] = _column(arrow, values, kind)
    return arrow.table(arrays)


def _column(arrow: Any, values: list[Any], kind: Any) -> Any:
    """Column of a type, or of the type of its values; mixed ones become texts of JSON."""
    try:
        return arrow.array(values, kind)
    except (arrow.ArrowInvalid, arrow.ArrowTypeError):
        texts = [None if value is None else json.dumps(value) for value in values]
        return arrow.array(texts, arrow.string())
