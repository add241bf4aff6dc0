"""Conversion of a map: rotation, size, limit, projection, file."""

from __future__ import annotations

import math
import os
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import amount, count, rotation
from envlights._common.notes import Note
from envlights._native import EnvLightsError
from envlights.environment import resample
from envlights.environment.files.image_output import (
    COMPRESSIONS,
    map_suffix,
    with_alpha,
    write_exr,
    write_hdr,
)
from envlights.environment.files.images import MOST_PIXELS
from envlights.environment.layouts import picture_layout as layouts
from envlights.environment.layouts.conventions import CROSSES
from envlights.environment.layouts.picture import Picture, picture_of, straight
from envlights.environment.layouts.picture_layout import PictureLayout
from envlights.environment.layouts.projections import (
    PROJECTIONS,
    SOURCE,
    Layout,
    complete,
    layout_of,
    place,
)
from envlights.environment.peaks import spread_peaks
from envlights.environment.pixels import PROJECTION, MapPixels


def checked_width(width: int) -> int:
    """Number of columns as an int; raises an error unless it is even, and at most 32768."""
    columns = count("width", width, least=4)
    if columns % 2 or columns * columns > 2 * MOST_PIXELS:
        raise EnvLightsError(f"width must be an even number of columns, up to 32768; got {columns}")
    return columns


def rotate(pixels: MapPixels, matrix: ArrayLike) -> MapPixels:
    """Pixels of the rotated map; see `EnvMap.rotated`."""
    radiance, coverage, is_border = resample.rotate(
        pixels.radiance,
        pixels.coverage,
        rotation(matrix),
        border_sampled=pixels.is_border_sampled,
    )
    return _below_clip_level(pixels, radiance, coverage, is_border)


def resize(pixels: MapPixels, width: int) -> MapPixels:
    """Pixels of a map of another size; see `EnvMap.resized`."""
    target = layouts.equirectangular(checked_width(width) // 2)
    image = resample.resample(pixels.radiance, pixels.coverage, pixels.layout, target)
    return _below_clip_level(pixels, *image, is_border=False)


def limit(pixels: MapPixels, maximum: float) -> MapPixels:
    """Pixels limited to a maximum; see `EnvMap.limited`."""
    level = amount("maximum", maximum)
    is_border, coverage = pixels.is_border_sampled, pixels.coverage
    radiance, notes = spread_peaks(pixels.radiance, level, is_border, coverage)
    below = _below_clip_level(pixels, radiance, coverage, is_border)
    return replace(below, notes=(*below.notes, *notes))


def to(pixels: MapPixels, layout: str | Layout, width: int | None) -> Picture:
    """Picture in another layout; see `EnvMap.to`."""
    if layout == SOURCE:
        if width is not None:
            raise EnvLightsError("width is no argument of the layout 'source'")
        return _in_layout_of_source(pixels)
    target = complete(layout_of(layout, SOURCE))
    columns = _width_of(pixels, target) if width is None else count("width", width, least=2)
    if target.projection == PROJECTION:
        checked_width(columns)
    made = _target(target, columns)
    if made.height * made.width > MOST_PIXELS:
        raise EnvLightsError(f"width must give at most {MOST_PIXELS} pixels; got {columns}")
    return _picture(pixels, made, target.faces or "")


def view(
    pixels: MapPixels, direction: ArrayLike, fov: float, width: int, height: int | None
) -> Picture:
    """Picture of a level camera; see `EnvMap.view`."""
    columns = count("width", width, least=1)
    rows = max(round(columns / 1.5), 1) if height is None else count("height", height, least=1)
    if rows * columns > MOST_PIXELS:
        raise EnvLightsError(f"a view has at most {MOST_PIXELS} pixels; got {columns}x{rows}")
    angle = math.radians(amount("fov", fov, 0.1, 179))
    axes = layouts.looking(direction, "direction")
    layout = layouts.planar(rows, columns, field_of_view=angle, axes=axes)
    return _picture(pixels, layout, "opengl")


def save(pixels: MapPixels, path: str | os.PathLike[str], *, half: bool, compression: str) -> None:
    """Write a map to a file; see `EnvMap.save`."""
    if map_suffix(path) == ".hdr":
        if half or compression != COMPRESSIONS[0]:
            raise EnvLightsError(f"cannot save {path}: half and compression are of .exr files")
        write_hdr(path, pixels.cells(), comments=pixels.notes)
        return
    write_exr(
        path,
        with_alpha(pixels.radiance, pixels.coverage),
        half=half,
        compression=compression,
        environment="latlong" if pixels.is_border_sampled else "",
        comments=pixels.notes,
        units=pixels.units,
    )


def _below_clip_level(
    pixels: MapPixels,
    radiance: NDArray[np.float32],
    coverage: NDArray[np.float32] | None,
    is_border: bool,
) -> MapPixels:
    """Pixels with resampled radiance, limited to the clip level of the map."""
    if pixels.clip_level is not None:
        radiance = np.minimum(radiance, np.float32(pixels.clip_level))
    return pixels.changed(radiance, coverage, pixels.notes, is_border_sampled=is_border)


def _picture(
    pixels: MapPixels, layout: PictureLayout, faces: str, arrangement: str = "stack"
) -> Picture:
    image, coverage = pixels.radiance, pixels.coverage
    if layout != pixels.layout:
        image, coverage = resample.resample(image, coverage, pixels.layout, layout)
    notes = tuple(map(Note, pixels.notes))
    picture = picture_of(
        image, layout, faces=faces, coverage=coverage, notes=notes, arrangement=arrangement
    )
    return replace(picture, units=pixels.units)


def _in_layout_of_source(pixels: MapPixels) -> Picture:
    source = pixels.source
    layout, (height, width) = source.layout, source.size
    if layout == pixels.layout:
        return _picture(pixels, layout, source.faces)
    if layout.kind == "equirectangular":
        layout = layout._replace(border_sampled=False)
    if layout.kind == "cube":  # Cube faces wider than 90 degrees are written with 90 degrees.
        layout = layout._replace(field_of_view=0.0)
    if source.faces in CROSSES:
        return straight(_picture(pixels, layout, "opengl", source.faces))
    arrangement = "strip" if source.faces and width > height else "stack"
    return straight(_picture(pixels, layout, source.faces, arrangement))


def _width_of(pixels: MapPixels, layout: Layout) -> int:
    """Columns of a picture whose mean pixel is as large as a map pixel on the equator."""
    trial = 64
    width = trial * int(pixels.radiance.shape[1]) / resample.default_width(_target(layout, trial))
    return max(2 * round(width / 2), 2)


def _target(layout: Layout, width: int) -> PictureLayout:
    """Complete layout of a picture with this number of columns."""
    rows = PROJECTIONS[layout.projection or ""].rows(width, layout)
    return place(layout, (rows, width))[0]
