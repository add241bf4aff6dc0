"""Conversion of a picture to a map, in six steps.

| step         | of a file                     | of an array        |
|--------------|-------------------------------|--------------------|
| bytes        | `decoders`                    |                    |
| samples      | `files.images.open_image`     | `arrays`           |
| linear light | `files.images.OpenImage`      | `arrays`           |
| layout       | `layouts.recognise`           | the same           |
| clean        | `clean`                       | the same           |
| map          | `_on_sphere`                  | the same           |

`reduced_file.py` takes the rows of a file after the second step; `exposures/` and photographs take
the image after the third one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native
from envlights._common.check import positive
from envlights._common.errors import FileError
from envlights._common.notes import log
from envlights._native import EnvLightsError
from envlights.environment import resample
from envlights.environment.arrays import image_of_array
from envlights.environment.clean import clean
from envlights.environment.convert import checked_width
from envlights.environment.coverage import multiply_by_coverage
from envlights.environment.exposures import merge_exposures
from envlights.environment.files.hints import Hints
from envlights.environment.files.images import Image
from envlights.environment.layouts.panorama_check import notes_on_panorama
from envlights.environment.layouts.picture_layout import equirectangular
from envlights.environment.layouts.projections import REGISTRATIONS, Layout, layout_of
from envlights.environment.layouts.recognition import recognise
from envlights.environment.layouts.records import ArrangedPicture, Origin
from envlights.environment.picture_files import PictureSource, read_picture
from envlights.environment.pixels import PROJECTION, MapPixels, with_coverage
from envlights.kernels.probe import WORKING_COLUMNS


def open_map(
    path: PictureSource,
    layout: str | Layout | None,
    width: int | None,
    clip_level: float | None,
    **options: Any,
) -> MapPixels:
    """Map of one file or six; see `EnvMap.open`, whose other arguments are `options`."""
    wanted = layout_of(layout)
    level = None if clip_level is None else positive("clip_level", clip_level)
    image = read_picture(path, **options)  # bytes, samples, linear light
    try:
        pixels = map_of_image(image, wanted, width, level)
    except FileError:
        raise
    except EnvLightsError as refusal:
        name = f"{image.hints.name}: " if image.hints.name else ""
        raise EnvLightsError(f"{name}{refusal}") from None
    log(pixels.notes)
    return pixels


def map_of_image(
    image: Image,
    layout: Layout = Layout(),  # noqa: B008, it is frozen
    width: int | None = None,
    clip_level: float | None = None,
) -> MapPixels:
    """Map of a linear image in any layout."""
    columns = None if width is None else checked_width(width)
    picture = recognise(image.pixels, image.hints, layout, image.coverage)
    notes = [*image.notes, *picture.notes]
    radiance, infinite = clean(_seen(picture), notes)
    notes += [each for each in _doubts(radiance, picture) if each not in notes]
    known = (level for level in (clip_level, image.clip_level, infinite) if level is not None)
    pixels = MapPixels(
        radiance,
        picture.layout.border_sampled,
        picture.source,
        clip_level=next(known, None),
        notes=tuple(notes),
        units=image.units,
        ev100=image.ev100,
    )
    return _on_sphere(pixels, picture, columns)


def map_of_array(
    array: ArrayLike | Mapping[str, ArrayLike],
    coverage: ArrayLike | None,
    layout: str | Layout | None,
    width: int | None,
    clip_level: float | None,
    notes: list[str],
    units: str,
) -> MapPixels:
    """Map of an array, or of six arrays; see `EnvMap`."""
    wanted = layout_of(layout)
    level = None if clip_level is None else positive("clip_level", clip_level)
    image = image_of_array(array, coverage, known_level=level)
    image = replace(image, notes=(*notes, *image.notes), units=units)
    return map_of_image(image, wanted, width, level)


def map_of_exposures(pictures: Any, times: Any, response: Any) -> MapPixels:
    """Map of a series of exposures; see `EnvMap.from_exposures`."""
    merged = merge_exposures(pictures, times, response)
    hints = Hints(border_sampled=merged.border_sampled)
    image = Image(merged.radiance, merged.border_sampled, tuple(merged.notes), hints=hints)
    return map_of_image(replace(image, clip_level=merged.clip_level, ev100=merged.ev100))


def unchecked_map(array: ArrayLike) -> MapPixels:
    """Map of an array whose samples a kernel will check; layouts are recognised as usual.

    `doubts_of_array` examines the overview that the kernel makes of a panorama.
    """
    image = image_of_array(array)
    height, width = image.pixels.shape[:2]
    if image.pixels.ndim != 3 or width != 2 * height:
        return map_of_image(image)
    layout = equirectangular(height, width)
    source = Origin(PROJECTION, (height, width), "", REGISTRATIONS[0], "shape", layout)
    picture = ArrangedPicture(image.pixels, image.coverage, layout, source, ())
    pixels = MapPixels(_seen(picture), False, source, None, image.clip_level, image.notes)
    return with_coverage(pixels, image.coverage)


def doubts_of_array(pixels: MapPixels, overview: NDArray[np.float32]) -> tuple[str, ...]:
    """Notes on an unchecked map that may not be a panorama, except notes that it already has."""
    source = pixels.source
    if source.recognised_by != "shape" or source.projection != PROJECTION:
        return ()
    doubts = notes_on_panorama(overview, *source.size)
    return tuple(doubt for doubt in doubts if doubt not in pixels.notes)


def _seen(picture: ArrangedPicture) -> NDArray[np.float32]:
    """Samples set to black where the coverage is 0."""
    if picture.coverage is None or (picture.coverage == 1).all():
        return picture.samples
    return multiply_by_coverage(picture.samples, np.float32(1) * (picture.coverage > 0))


def _doubts(radiance: NDArray[np.float32], picture: ArrangedPicture) -> tuple[str, ...]:
    """Notes on a picture that only its shape suggests to be a panorama."""
    layout = picture.layout
    if not layout.is_whole_sphere or picture.source.recognised_by != "shape":
        return ()
    cells = _native.overview(radiance, layout.border_sampled, WORKING_COLUMNS)
    return notes_on_panorama(cells, layout.height, layout.width)


def _on_sphere(pixels: MapPixels, picture: ArrangedPicture, columns: int | None) -> MapPixels:
    """Picture resampled to a map; a complete panorama is unchanged."""
    image, coverage, is_border = resample.on_sphere(
        pixels.radiance, picture.coverage, picture.layout, columns
    )
    notes = pixels.notes
    if image.shape != pixels.radiance.shape:
        notes = (*notes, _note_of_conversion(picture.source, image))
        if pixels.clip_level is not None:
            image = np.minimum(image, np.float32(pixels.clip_level))
    pixels = replace(pixels, radiance=image, is_border_sampled=is_border, notes=notes)
    return with_coverage(pixels, coverage)


def _note_of_conversion(source: Origin, image: NDArray[np.float32]) -> str:
    """Note on the layout and size of the original picture."""
    (rows, columns), (height, width) = source.size, image.shape[:2]
    return f"{source.projection} of {columns}x{rows} pixels, converted to {width}x{height} cells"
