"""`compare_folders`: comparison of all maps with the same names in two folders."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import named_arguments
from envlights._common.errors import FileError, MissingFileError
from envlights._common.fields import plain
from envlights._common.files import MAPS, as_path
from envlights._common.printable import printable
from envlights._common.progress import progress_bar
from envlights._common.result import Result
from envlights._common.tables import Table, csv_text, frame_of, json_text, save_table
from envlights._common.words import quantity
from envlights._native import EnvLightsError
from envlights.comparison.compare import Comparison, compare
from envlights.comparison.light_set_difference import NUMBERS
from envlights.comparison.protocol import Protocol, as_protocol
from envlights.detection.lights_file import SUFFIXES as LIGHT_FILES
from envlights.environment.reading import Reading, check_reading

if TYPE_CHECKING:
    import pandas as pd

#: Suffixes of compared files; other files are ignored.
_SUFFIXES = (*MAPS, *LIGHT_FILES)
#: Names of the numbers of each sphere, with a column each.
_OF_SPHERE = ("rmse", "si_rmse", "angle", "relative", "si_relative", "normalised_rmse")


@dataclass(frozen=True, eq=False, repr=False)
class FolderComparison(Result):
    """Comparisons of the maps of two folders, with means, medians and failures."""

    _is_headed = True

    protocol: Protocol
    """Rules of each comparison."""

    comparisons: Mapping[str, Comparison]
    """Comparison for each name without suffix."""

    failures: Mapping[str, str]
    """Reason of failure for each name without a comparison."""

    def columns(self) -> dict[str, NDArray[np.float64]]:
        """Columns of numbers, (pairs,); NaN for missing numbers."""
        rows = [_numbers(each) for each in self.comparisons.values()]
        names = list(dict.fromkeys(name for row in rows for name in row))
        return {name: np.array([row.get(name, np.nan) for row in rows]) for name in names}

    @property
    def mean(self) -> dict[str, float]:
        """Mean of each column, without missing numbers."""
        return {name: float(np.nanmean(values)) for name, values in self.columns().items()}

    @property
    def median(self) -> dict[str, float]:
        """Median of each column, without missing numbers."""
        return {name: float(np.nanmedian(values)) for name, values in self.columns().items()}

    def in_short(self) -> str:
        """Number of pairs and of failures."""
        pairs = quantity(len(self.comparisons), "pair")
        return f"{pairs} by '{self.protocol.name}', {len(self.failures)} failed"

    def __len__(self) -> int:
        return len(self.comparisons)

    def table(self) -> Table:
        """Table of the errors per sphere, with means and medians."""
        spheres = list(self.protocol.materials)
        parts = [f"{name}_{what}" for name in spheres for what in ("rmse", "si_rmse", "angle")]
        each = {name: _numbers(pair) for name, pair in self.comparisons.items()}
        each |= {"mean": self.mean, "median": self.median} if each else {}
        rows = [
            [name, *(f"{numbers.get(part, np.nan):.4g}" for part in parts)]
            for name, numbers in each.items()
        ]
        return Table(["name", *(part.replace("_", " ", 1) for part in parts)], rows)

    def _table(self) -> Table | None:
        return self.table() if self.comparisons else None

    def _lines(self) -> list[str]:
        """Failures, and notes common to all pairs."""
        failures = [f"failed: {name}: {reason}" for name, reason in self.failures.items()]
        notes = [each.notes for each in self.comparisons.values()]
        shared = [note for note in (notes[0] if notes else ()) if all(note in n for n in notes)]
        return [*failures, *shared]

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers and texts, for example for JSON."""
        return {
            "protocol": self.protocol.name,
            "pairs": {name: each.to_dict() for name, each in self.comparisons.items()},
            "mean": plain(self.mean),
            "median": plain(self.median),
            "failures": dict(self.failures),
        }

    def to_frame(self) -> pd.DataFrame:
        """Data frame with a row per pair; needs pandas, from the extra `frame`."""
        names = np.array(list(self.comparisons), dtype=object)
        return frame_of({"name": names, **self.columns()})

    def to_csv(self) -> str:
        """Lossless CSV table with a row per pair; the last column is the reason of a failure."""
        columns = self.columns()
        cells = zip(*(values.tolist() for values in columns.values()), strict=True)
        pairs = [[name, *row, ""] for name, row in zip(self.comparisons, cells, strict=True)]
        failed = [[name, *[""] * len(columns), why] for name, why in self.failures.items()]
        return csv_text([["name", *columns, "failure"], *pairs, *failed])

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the table as ``.csv`` or ``.json``; a failure leaves no file."""
        save_table(path, {".csv": self.to_csv, ".json": lambda: json_text(self.to_dict())})


def _numbers(comparison: Comparison) -> dict[str, float]:
    """Numbers of a pair by column name."""
    spheres = {
        f"{name}_{what}": getattr(errors, what)
        for name, errors in comparison.spheres.items()
        for what in _OF_SPHERE
    }
    errors = {
        "scale": comparison.scale,
        "probe_error": comparison.probe_error,
        "shadow_error": comparison.shadow_error,
        "gloss_error": comparison.gloss_error(),
    }
    lights = {f"lights_{what}": getattr(comparison.lights, what) for what in NUMBERS}
    numbers = {**spheres, **errors, **lights, "vector_angle": comparison.vector_angle}
    return {name: float(value) for name, value in numbers.items() if value is not None}


@named_arguments()
def compare_folders(
    truth: str | os.PathLike[str],
    guess: str | os.PathLike[str],
    protocol: str | Protocol = "exact",
    *,
    progress: bool | None = None,
    reading: Reading | None = None,
) -> FolderComparison:
    """Compare the maps with the same names in two folders.

    Parameters
    ----------
    truth, guess : path-like
        Folders of maps (.exr, .hdr, .png, .jpg, .tif), rigs or lights (.json, .csv). Two files are
        a pair if their names without the suffix are equal.
    protocol : {"exact", "stylelight", "diffusionlight"} or Protocol
        Protocol of `compare`.
    progress : bool, optional
        True: show a bar. When left out, one appears in a terminal or notebook after a second.
    reading : mapping, optional
        Options on how the maps are read, as of `batch`.

    Returns
    -------
    FolderComparison
        A row for each pair, sorted by name. A file that cannot be read, or that has no counterpart,
        has no row; `failures` says why.

    Raises
    ------
    EnvLightsError
        If a folder is missing, or holds no map.

    Examples
    --------
    >>> import tempfile
    >>> import envlights as el
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     for name, gain in (("truth", 1), ("guess", 2)):
    ...         (Path(folder) / name).mkdir()
    ...         el.EnvMap(gain * el.synthetic.hall(32).radiance).save(f"{folder}/{name}/hall.exr")
    ...     table = el.compare_folders(f"{folder}/truth", f"{folder}/guess")
    >>> table
    <FolderComparison: 1 pair by 'exact', 0 failed>
    >>> round(table.mean["matte_relative"], 6)
    1.0
    """
    rules = as_protocol(protocol)
    check_reading(reading)
    sides = [_files(name, folder) for name, folder in (("truth", truth), ("guess", guess))]
    names = sorted({*sides[0], *sides[1]})
    comparisons, failures = {}, {}
    for name in progress_bar(names, "compare", "map", progress):
        try:
            paths = _only(sides[0], name, "truth"), _only(sides[1], name, "guess")
            comparisons[name] = compare(paths[0], paths[1], rules, reading=reading)
        except (EnvLightsError, OSError) as refusal:
            failures[name] = printable(str(refusal))
    return FolderComparison(rules, comparisons, failures)


def _files(name: str, folder: str | os.PathLike[str]) -> dict[str, list[Path]]:
    path = as_path(folder)
    if not path.is_dir():
        raise MissingFileError(f"{name} must be a folder; got '{folder}', which is none")
    try:
        paths = sorted(path.iterdir())
    except OSError as error:
        raise FileError(f"cannot read the folder {folder}: {error.strerror}") from None
    files: dict[str, list[Path]] = {}
    for each in paths:
        if each.suffix.lower() in _SUFFIXES and each.is_file():
            files.setdefault(printable(each.stem), []).append(each)
    if not files:
        raise EnvLightsError(f"{name} has no map: the folder '{folder}' holds no file with one of"
                             f" the suffixes {', '.join(_SUFFIXES)}")  # fmt: skip
    return files


def _only(files: dict[str, list[Path]], name: str, what: str) -> Path:
    found = files.get(name, [])
    if len(found) != 1:
        count = "no file" if not found else f"{len(found)} files"
        raise EnvLightsError(f"{what} has {count} of this name")
    return found[0]
