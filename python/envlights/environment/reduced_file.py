"""Reduction of a file to the cells of a fit, row by row, without the whole map in memory.

It is for files whose rows are the rows of the map: no alpha, no crop, no orientation, no primaries
to be converted. All others are left to `EnvMap.open`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._native import EnvLightsError, ReducedMap, RowReducer
from envlights.environment.clean import Cleaned, notes_of_cleaning
from envlights.environment.clip_level import CodeHistogram, white_of
from envlights.environment.decoders.source import AnySource
from envlights.environment.files.images import OpenImage, open_image
from envlights.environment.files.whole_numbers import WholeNumbers
from envlights.environment.layouts.panorama_check import notes_on_panorama


class ReducedFile(NamedTuple):
    """Reduced map, and facts about the file for the report."""

    cells: ReducedMap
    """Cells, with exact pixels of the bright ones."""

    width: int
    """Columns of the map in the file."""

    notes: tuple[str, ...]
    """Notes on assumptions and on ignored content."""

    clipped_flux_fraction: float
    """Fraction of the flux in clipped pixels; 0 if the file has no clip level."""

    units: str
    """Unit of the cells; see `EnvMap.units`."""


class _Cells(NamedTuple):
    """Parameters of the reduction."""

    columns: int
    source_fraction: float
    floor: bool


def reduce_file(
    source: AnySource, columns: int, source_fraction: float, floor: bool, least_width: int
) -> ReducedFile | None:
    """Reduce a file row by row; None if the whole map is needed.

    Parameters
    ----------
    source : path-like or bytes
        File; see `read_image`.
    columns : int
        Largest number of columns of the reduced map.
    source_fraction : float
        Fraction of the flux of a channel from which a cell becomes a point source.
    floor : bool
        True if a floor hides all light from below the horizon.
    least_width : int
        Columns of the smallest map that is reduced.
    """
    with open_image(source, any_projection=True) as file:
        table = _table(file) if _is_plain(file, least_width) else None
        if table is None:
            return None
        reduced = _of_rows(file, _Cells(columns, source_fraction, floor), table)
        return reduced._replace(notes=(*reduced.notes, *_doubts(file, reduced)))


def _doubts(file: OpenImage, reduced: ReducedFile) -> tuple[str, ...]:
    """Notes on a picture that only its shape suggests to be a panorama."""
    if file.hints.environment or file.hints.projection:
        return ()
    size = file.raw.header.height, file.raw.header.width
    try:
        return notes_on_panorama(reduced.cells.overview, *size)
    except EnvLightsError as refusal:
        raise EnvLightsError(f"{file.name}: {refusal}") from None


def _is_plain(file: OpenImage, least_width: int) -> bool:
    """True if the rows of a file are those of a map, except for a look-up table of samples."""
    header, colour = file.raw.header, file.colour
    return (
        header.width == 2 * header.height
        and header.width >= least_width
        and header.alpha == "none"
        and file.place.is_plain
        and not file.hints.names_other_projection
        and not file.hints.layout
        and not file.hints.stereo
        and colour.matrix is None
        and not header.has_gain_map
        and (header.dtype.kind == "u" or (colour.curve is None and colour.clip_level is None))
        and all(factor == 1 for factor in header.exposure)
    )


def _table(file: OpenImage) -> NDArray[np.float32] | None:
    """Linear value of each code, empty for floats; None if values do not increase with codes."""
    header = file.raw.header
    if header.dtype.kind == "f":
        return np.zeros(0, np.float32)
    table = np.ascontiguousarray(file.colour.table(8 * header.dtype.itemsize))
    is_one = table.ndim == 1 and bool(np.isfinite(table).all())
    return table if is_one and bool((np.diff(table) >= 0).all()) else None


def _of_rows(file: OpenImage, cells: _Cells, table: NDArray[np.float32]) -> ReducedFile:
    """Reduction of the rows, read in their own sample type."""
    header = file.raw.header
    size = (header.height, header.width, header.border_sampled)
    reducer = RowReducer(size, cells, header.dtype.name, table)
    whole = WholeNumbers()
    for rows in _whole_blocks(_rows(file), reducer.block):
        reducer.add(rows)
        if not table.size:
            whole.add(rows)
    reduced, cleaned, fraction = _finish(file, reducer)
    notes = [*whole.notes(), *notes_of_cleaning(cleaned)]
    if table.size:
        fraction, said = _clipped(reducer, header.height, table)
        notes = [*said, *notes]
    return ReducedFile(reduced, header.width, (*file.notes, *notes), fraction, file.units)


def _finish(file: OpenImage, reducer: RowReducer) -> tuple[ReducedMap, Cleaned, float]:
    """Reduced map, counts of replaced samples, and the fraction of the flux in infinite samples."""
    try:
        return reducer.finish()
    except EnvLightsError as refusal:  # no sample is finite
        raise EnvLightsError(f"{file.name}: {refusal}") from None


def _clipped(
    reducer: RowReducer, height: int, table: NDArray[np.float32]
) -> tuple[float, list[str]]:
    """Fraction of the flux in clipped pixels, and notes on the clip level."""
    histogram = CodeHistogram(height)
    histogram.sums = reducer.histogram
    clip_level, notes = white_of(histogram, table)
    shares = reducer.clipped(_native.LEAST_WHITE * clip_level)
    return shares[1] if shares else 0.0, notes


def _rows(file: OpenImage) -> Iterator[NDArray[Any]]:
    """Blocks of rows as flat arrays, three samples per pixel."""
    height, step = file.raw.header.height, file.raw.rows_at_once
    for top in range(0, height, step):
        rows = file.raw.rows(top, min(top + step, height))
        yield np.repeat(rows, 3, axis=2) if rows.shape[2] == 1 else np.ascontiguousarray(rows)


def _whole_blocks(parts: Iterator[NDArray[Any]], block: int) -> Iterator[NDArray[Any]]:
    """Samples regrouped into whole row blocks, with a smaller one at the end."""
    rest: NDArray[Any] | None = None
    for part in parts:
        rows = part if rest is None else np.concatenate([rest, part])
        whole = len(rows) // block * block
        if whole:
            yield rows[:whole]
        rest = rows[whole:] if whole < len(rows) else None
    if rest is not None:
        yield rest
