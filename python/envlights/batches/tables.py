"""Files of tables: Parquet, and lines of JSON."""

from __future__ import annotations

import io
import json
import os
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any

from envlights._common.tables import check_suffix, json_lines, save_table
from envlights._native import EnvLightsError

#: Suffixes of tables.
SUFFIXES = (".parquet", ".jsonl")


def save_rows(
    path: str | os.PathLike[str], rows: Sequence[dict[str, Any]], columns: Mapping[str, str]
) -> None:
    """Write rows with typed `columns`; further columns get the type of their values."""
    check_table(path)
    save_table(
        path, {".parquet": lambda: _parquet(rows, columns), ".jsonl": lambda: json_lines(rows)}
    )


def check_table(path: str | os.PathLike[str]) -> None:
    """Refuse a table that could not be written, before the work for it is done."""
    if check_suffix(path, SUFFIXES) == ".parquet":
        _arrow()


def _arrow() -> Any:
    try:
        return import_module("pyarrow")
    except ImportError:
        raise EnvLightsError(
            "a .parquet table needs pyarrow: pip install 'envlights[table]'; or write .jsonl"
        ) from None


def _parquet(rows: Sequence[dict[str, Any]], columns: Mapping[str, str]) -> bytes:
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
    data = io.BytesIO()
    import_module("pyarrow.parquet").write_table(arrow.table(arrays), data)
    return data.getvalue()


def _column(arrow: Any, values: list[Any], kind: Any) -> Any:
    """Column of a type, or of the type of its values; mixed ones become texts of JSON."""
    try:
        return arrow.array(values, kind)
    except (arrow.ArrowInvalid, arrow.ArrowTypeError):
        texts = [None if value is None else json.dumps(value) for value in values]
        return arrow.array(texts, arrow.string())
