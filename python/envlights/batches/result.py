"""Result of a batch: rows of all maps, with their failures."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from envlights._common.errors import DamagedFileError, FileError, MissingFileError
from envlights._common.files import as_path
from envlights._common.result import Result
from envlights._common.tables import MOST_ROWS, frame_of
from envlights._common.words import percent, quantity
from envlights.batches import columns
from envlights.batches.columns import save_rows
from envlights.batches.journal import JOURNAL, row_of_line

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False, repr=False)
class Batch(Result):
    """Rows of the maps of a batch, sorted by name, with reasons of failures.

    The rows of a folder stay in its file and are read when they are needed.
    """

    _is_headed = True

    folder: str
    """Folder with the files and the rows; empty if the rows are in memory."""

    lines: bytes = b""
    """Rows as JSON lines; empty if they are in the folder."""

    unchanged: int = field(default=0, compare=False)
    """Number of maps that were already finished, and therefore skipped."""

    seconds: float = field(default=0.0, compare=False)
    """Wall time of the batch."""

    sources: frozenset[str] | None = field(default=None, compare=False)
    """Sources of the maps in this call; None for all rows of the folder."""

    @classmethod
    def load(cls, folder: str | os.PathLike[str]) -> Batch:
        """Rows in the folder of an earlier batch.

        Raises
        ------
        EnvLightsError
            If there is no batch in the folder.
        """
        path = as_path(folder).absolute()
        if not (path / JOURNAL).is_file():
            raise MissingFileError(f"no batch is in the folder '{folder}': it has no {JOURNAL}")
        batch = cls(str(path))
        if (path / JOURNAL).stat().st_size and not len(batch):
            raise DamagedFileError(f"no batch is in '{folder}': its {JOURNAL} has no row of one")
        return batch

    def rows(self) -> Iterator[dict[str, Any]]:
        """Row of each map in this call, as a dictionary with a list of `lights`."""
        return (row for row in self._rows() if self._is_of_call(row))

    def _rows(self) -> Iterator[dict[str, Any]]:
        """All rows in the folder, except incomplete and damaged lines."""
        if not self.folder:
            yield from filter(None, map(row_of_line, self.lines.splitlines()))
            return
        path = Path(self.folder) / JOURNAL
        try:
            with path.open("rb") as file:
                yield from filter(None, map(row_of_line, file))
        except FileNotFoundError:
            raise MissingFileError(f"the rows of the batch are gone: there is no {path}") from None
        except OSError as error:
            raise FileError(f"cannot read {path}: {error.strerror}") from None

    def _is_of_call(self, row: dict[str, Any]) -> bool:
        return self.sources is None or row["source"] in self.sources

    @cached_property
    def _other_runs(self) -> Counter[str]:
        """Number of rows of each other run in the folder, by method and options."""
        others = (row for row in self._rows() if not self._is_of_call(row))
        return Counter(f"{row['what']} {row['options']}" for row in others)

    @cached_property
    def _summary(self) -> tuple[int, dict[str, str], dict[str, float]]:
        """Number of maps, the failures, and the median of each error."""
        number, failures = 0, dict[str, str]()
        errors: dict[str, list[float]] = {name: [] for name in columns.ERRORS}
        for row in self.rows():
            number += 1
            if row.get("failure"):
                failures[row["name"]] = row["failure"]
            for name, values in errors.items():
                if row.get(name) is not None:
                    values.append(row[name])
        medians = {name: float(np.median(values)) for name, values in errors.items() if values}
        return number, failures, medians

    def __len__(self) -> int:
        return self._summary[0]

    @property
    def failures(self) -> Mapping[str, str]:
        """Class and message of each failure, by map name."""
        return self._summary[1]

    @property
    def medians(self) -> Mapping[str, float]:
        """Median of each error over the maps that have it."""
        return self._summary[2]

    def in_short(self) -> str:
        """Number of maps and of failures."""
        number, failures, _ = self._summary
        again = f", {self.unchanged} unchanged" if self.unchanged else ""
        return f"{quantity(number, 'map')}, {len(failures)} failed{again}"

    def _lines(self) -> list[str]:
        """Medians of the errors, and the first dozen failures."""
        medians = [
            f"median {name.replace('_', ' ')} {percent(value)}"
            for name, value in self.medians.items()
        ]
        failures = [f"failed: {name}: {reason}" for name, reason in self.failures.items()]
        more = len(failures) - MOST_ROWS
        rest = [f"{more} more failed"] if more > 0 else []
        runs = [
            f"not listed: {quantity(number, 'row')} of another run in the folder: {run}"
            for run, number in self._other_runs.most_common(MOST_ROWS)
        ]
        return [*medians, *failures[:MOST_ROWS], *rest, *runs]

    def to_dict(self) -> dict[str, Any]:
        """Counts, medians and failures; `rows` has the numbers of each map."""
        return {
            "folder": self.folder,
            "maps": len(self),
            "unchanged": self.unchanged,
            "medians": dict(self.medians),
            "failures": dict(self.failures),
            "other_runs": dict(self._other_runs),
        }

    def table(self, of: str = "lights") -> Iterator[dict[str, Any]]:
        """Flat rows of "lights" or "maps", all with the same columns."""
        return columns.flat_rows(self.rows(), of)

    def to_frame(self, of: str = "lights") -> pd.DataFrame:
        """Data frame with a row for each light or map; needs pandas, from the extra `frame`."""
        rows = list(self.table(of))
        names: Iterable[str] = dict.fromkeys(name for row in rows for name in row)
        return frame_of({name: _array([row.get(name) for row in rows]) for name in names})

    def save(self, path: str | os.PathLike[str], of: str = "lights") -> None:
        """Write a table as ``.csv``, ``.jsonl`` or ``.parquet``; a failure leaves no file.

        Parameters
        ----------
        path : path-like
            A file with one of these suffixes; ``.parquet`` needs pyarrow. In ``.csv``, lists are
            texts of JSON, and what is missing is empty.
        of : {"lights", "maps"}
            A row for each light, or for each map, also for those that failed.
        """
        columns.check_kind(of)
        save_rows(path, list(self.table(of)), columns.COLUMNS[of])


def _array(values: list[Any]) -> np.ndarray[Any, Any]:
    """Column of a data frame; missing numbers are NaN, lists and texts remain objects."""
    if all(isinstance(value, float | int | bool | None) for value in values):
        if not any(value is None for value in values):
            return np.array(values)
        if not any(isinstance(value, bool) for value in values):
            return np.array([np.nan if value is None else value for value in values])
    column = np.empty(len(values), object)
    column[:] = values
    return column
