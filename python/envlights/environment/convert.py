"""A map in other layouts: rotation, size, pictures in any projection, a limit of the radiance."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import amount, check_choice, count, rotation
from envlights._common.notes import Note
from envlights._native import EnvLightsError
from envlights.environment import resample
from envlights.environment.files.images import MOST_PIXELS
from envlights.environment.layouts import picture_layout as layouts
from envlights.environment.layouts.conventions import CONVENTIONS, CROSSES
from envlights.environment.layouts.picture import Picture, picture_of, straight
from envlights.environment.layouts.picture_layout import MAPPINGS, PictureLayout
from envlights.environment.layouts.records import REGISTRATIONS
from envlights.environment.peaks import spread_peaks
from envlights.environment.pixels import MapPixels


def checked_width(width: int) -> int:
    """Columns of a map, or a refusal."""
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
    """Pixels without samples above a maximum; see `EnvMap.limited`."""
    level = amount("maximum", maximum)
    is_border, coverage = pixels.is_border_sampled, pixels.coverage
    radiance, notes = spread_peaks(pixels.radiance, level, is_border, coverage)
    below = _below_clip_level(pixels, radiance, coverage, is_border)
    return replace(below, notes=(*below.notes, *notes))


def to(
    pixels: MapPixels,
    projection: str,
    width: int | None,
    faces: str,
    **options: Any,
) -> Picture:
    """Picture in another projection; see `EnvMap.to`, whose other options are `options`."""
    check_choice("projection", projection, (*_TARGETS, SOURCE))
    check_choice("faces", faces, tuple(CONVENTIONS))
    given = options | ({"width": width} if projection == SOURCE else {})
    _check_options(projection, [name for name, value in given.items() if value is not None])
    if projection == SOURCE:
        return _in_layout_of_source(pixels)
    request = _Request(projection, faces=faces, **options)
    columns = _width_of(pixels, request) if width is None else count("width", width, least=2)
    layout = request.layout(columns)
    if layout.height * layout.width > MOST_PIXELS:
        raise EnvLightsError(f"width must give at most {MOST_PIXELS} pixels; got {columns}")
    return _picture(pixels, layout, faces)


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


def _below_clip_level(
    pixels: MapPixels,
    radiance: NDArray[np.float32],
    coverage: NDArray[np.float32] | None,
    is_border: bool,
) -> MapPixels:
    """Other pixels of the same world."""
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
    if source.faces in CROSSES:
        return straight(_picture(pixels, layout, "opengl", source.faces))
    arrangement = "strip" if source.faces and width > height else "stack"
    return straight(_picture(pixels, layout, source.faces, arrangement))


def _width_of(pixels: MapPixels, request: _Request) -> int:
    """Columns of a picture whose mean pixel is as large as a cell of the equator."""
    trial = 64
    width = trial * int(pixels.radiance.shape[1]) / resample.default_width(request.layout(trial))
    return max(2 * round(width / 2), 2)


def _check_options(projection: str, given: list[str]) -> None:
    """Refuse options that a projection does not take."""
    taken = _OPTIONS[projection]
    if others := [name for name in given if name not in taken]:
        allowed = f"it takes {', '.join(taken)}" if taken else "it takes none of them"
        raise EnvLightsError(
            f"{', '.join(others)} is no argument of the projection {projection!r}; {allowed}"
        )


@dataclass(frozen=True)
class _Request:
    """Layout that a user asks for, in any size."""

    projection: str
    faces: str
    registration: str | None
    mapping: str | None
    fov: float | None
    forward: ArrayLike | None

    @property
    def border_sampled(self) -> bool:
        """True if the outer samples of each face lie on its edges."""
        if self.registration is None:
            return CONVENTIONS[self.faces].border_sampled
        check_choice("registration", self.registration, REGISTRATIONS)
        return self.registration == REGISTRATIONS[1]

    def layout(self, width: int) -> PictureLayout:
        """Layout with a number of columns."""
        return _TARGETS[self.projection](self, width)

    def axes(self, default: layouts.Axes = layouts.FRONT) -> layouts.Axes:
        """Axes of the picture."""
        return default if self.forward is None else layouts.looking(self.forward)

    def view(self, default: float | None) -> float:
        """Field of view in radians, or a refusal if it is missing."""
        if self.fov is None and default is None:
            raise EnvLightsError(f"the projection {self.projection!r} needs fov=, in degrees")
        return math.radians(amount("fov", default if self.fov is None else self.fov, 0.1, 360))


def _equirectangular(request: _Request, width: int) -> PictureLayout:
    return layouts.equirectangular(checked_width(width) // 2)


def _cube(request: _Request, width: int) -> PictureLayout:
    return layouts.cube(width, border_sampled=request.border_sampled)


def _octahedral(request: _Request, width: int) -> PictureLayout:
    return layouts.octahedral(width, axes=request.axes(layouts.UP))


def _equal_area(request: _Request, width: int) -> PictureLayout:
    return layouts.octahedral(width, equal_area=True, axes=request.axes(layouts.PBRT))


def _angular(request: _Request, width: int) -> PictureLayout:
    return layouts.angular_map(width, axes=request.axes())


def _mirror_ball(request: _Request, width: int) -> PictureLayout:
    return layouts.mirror_ball(width)


def _fisheye(request: _Request, width: int) -> PictureLayout:
    mapping = MAPPINGS[0] if request.mapping is None else request.mapping
    return layouts.fisheye(width, mapping, request.view(180), axes=request.axes())


def _cylinder(request: _Request, width: int) -> PictureLayout:
    view = request.view(360)
    # Elevations of up to 45 degrees.
    return layouts.cylinder(max(round(2 * width / view), 1), width, field_of_view=view)


def _planar(request: _Request, width: int) -> PictureLayout:
    height = max(round(width / 1.5), 1)
    return layouts.planar(height, width, field_of_view=request.view(None), axes=request.axes())


#: Name of the layout of a map's source.
SOURCE = "source"
#: Layouts by the name of their projection.
_TARGETS: dict[str, Callable[[_Request, int], PictureLayout]] = {
    "equirectangular": _equirectangular,
    "cube": _cube,
    "octahedral": _octahedral,
    "octahedral-equal-area": _equal_area,
    "angular": _angular,
    "mirror-ball": _mirror_ball,
    "fisheye": _fisheye,
    "cylinder": _cylinder,
    "planar": _planar,
}

#: Options of each projection, beside its width and the faces of a cube.
_OPTIONS: dict[str, tuple[str, ...]] = {
    "equirectangular": (),
    "cube": ("registration",),
    "octahedral": ("forward",),
    "octahedral-equal-area": ("forward",),
    "angular": ("forward",),
    "mirror-ball": (),
    "fisheye": ("mapping", "fov", "forward"),
    "cylinder": ("fov",),
    "planar": ("fov", "forward"),
    SOURCE: (),
}
