"""Reduction of the rows of a file to the cells of a fit, without the whole map in memory.

It is for files whose rows are the rows of the map: no alpha, no crop, no orientation, no primaries
to be converted. All others are left to `EnvMap.open`, and so are files that it cleans.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._native import EnvLightsError, ReducedMap, RowReducer, UnusableSamplesError
from envlights.environment.clean import note_of_negative
from envlights.environment.clip_level import CodeHistogram, white_of
from envlights.environment.decoders.source import AnySource
from envlights.environment.files.images import OpenImage, open_image
from envlights.environment.layouts.recognition import refusal_of_discs

#: Rows of a step through samples in memory; counts of 16-bit codes need 0.2 MB for each 16 rows.
_ROWS_AT_ONCE = 128


class ReducedFile(NamedTuple):
    """A reduced map, and what a report says about the file."""

    cells: ReducedMap
    """Cells, and the pixels of bright ones."""

    width: int
    """Columns of the map."""

    notes: tuple[str, ...]
    """Remarks on assumptions and on ignored content."""

    clipped_flux_fraction: float
    """Fraction of the flux in clipped pixels; 0 for a file without a clip level."""

    units: str
    """Unit of the cells; see `EnvMap.units`."""


class _Cells(NamedTuple):
    """Size of the reduced map."""

    columns: int
    source_fraction: float
    floor: bool


def reduce_file(
    source: AnySource, columns: int, source_fraction: float, floor: bool
) -> ReducedFile | None:
    """Reduce the rows of a file; None if the whole map is needed.

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
    """
    cells = _Cells(columns, source_fraction, floor)
    with open_image(source, any_projection=True) as file:
        if not _is_plain(file):
            return None
        try:
            reduced = _of_radiance(file, cells) or _of_rows(file, cells)
        except UnusableSamplesError:
            return None
        if reduced and reduced.cells.has_two_discs:
            size = file.raw.header.height, file.raw.header.width
            raise EnvLightsError(f"{file.name}: {refusal_of_discs(*size)}")
        return reduced


def _is_plain(file: OpenImage) -> bool:
    """True if the rows of a file are those of a map, after a look-up of each sample."""
    header, colour = file.raw.header, file.colour
    return (
        header.width == 2 * header.height
        and header.height > 1
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


def _of_radiance(file: OpenImage, cells: _Cells) -> ReducedFile | None:
    """Rows of a Radiance file, which are decoded in any order; None for other files."""
    if file.raw.radiance is None:
        return None
    reduced = _native.reduce_radiance(file.raw.radiance, *cells)
    return ReducedFile(reduced, file.raw.header.width, file.notes, 0.0, file.units)


def _of_rows(file: OpenImage, cells: _Cells) -> ReducedFile | None:
    """Rows in their own type, as the reader gives them."""
    header, table = file.raw.header, _table(file)
    if table is None:
        return None
    has_codes = header.dtype.kind == "u"
    size = (header.height, header.width, header.border_sampled)
    reducer = _native.RowReducer(size, cells, table, has_codes)
    for rows in _whole_blocks(_rows(file), reducer.block):
        if not reducer.add(rows):
            return None
    reduced = reducer.finish()
    fraction, notes = _clipped(reducer, header.height, table) if has_codes else (0.0, [])
    if reduced is None or fraction is None:
        return None
    if reducer.negative:
        notes.append(note_of_negative(reducer.negative))
    return ReducedFile(reduced, header.width, (*file.notes, *notes), fraction, file.units)


def _clipped(
    reducer: RowReducer, height: int, table: NDArray[np.float32]
) -> tuple[float | None, list[str]]:
    """Fraction of the flux in clipped pixels, None if unknown, and notes on the clip level."""
    histogram = CodeHistogram(height)
    histogram.sums = reducer.histogram
    clip_level, notes = white_of(histogram, table)
    shares = reducer.clipped(_native.LEAST_WHITE * clip_level)
    return None if shares is None else shares[1], notes


def _table(file: OpenImage) -> NDArray[np.float32] | None:
    """Linear value of each code or half float; empty for floats, None for tables of channels."""
    header = file.raw.header
    if header.dtype == np.float16:
        return np.arange(1 << 16, dtype=np.uint16).view(np.float16).astype(np.float32)
    if header.dtype.kind == "f":
        return np.zeros(0, np.float32)
    table = file.colour.table(8 * header.dtype.itemsize)
    return np.ascontiguousarray(table) if table.ndim == 1 else None


def _rows(file: OpenImage) -> Iterator[NDArray[Any]]:
    """Samples of some rows at a time, three for each pixel; half floats as their bits."""
    header, step = file.raw.header, file.raw.rows_at_once
    if header.kind == "png":  # whole in memory
        step = _ROWS_AT_ONCE
    for top in range(0, header.height, step):
        rows = file.raw.rows(top, min(top + step, header.height))
        if rows.shape[2] == 1:
            rows = np.repeat(rows, 3, axis=2)
        rows = np.ascontiguousarray(rows)
        yield rows.view(np.uint16) if rows.dtype == np.float16 else rows


def _whole_blocks(parts: Iterator[NDArray[Any]], block: int) -> Iterator[NDArray[Any]]:
    """Samples of whole rows of blocks, and the rest at the end."""
    rest: NDArray[Any] | None = None
    for part in parts:
        rows = part if rest is None else np.concatenate([rest, part])
        whole = len(rows) // block * block
        if whole:
            yield rows[:whole]
        rest = rows[whole:] if whole < len(rows) else None
    if rest is not None:
        yield rest
