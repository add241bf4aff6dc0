"""Recognition of a picture: its projection from arguments, metadata, names, shape and seams."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import amount, describe, reals
from envlights._native import EnvLightsError
from envlights.environment.files.hints import NO_HINTS, Hints
from envlights.environment.layouts import layout as layouts
from envlights.environment.layouts.attribute import with_statement
from envlights.environment.layouts.cubes import arrange_cube
from envlights.environment.layouts.evidence import is_dual_fisheye
from envlights.environment.layouts.layout import Axes, Layout
from envlights.environment.layouts.projections import candidates, check_unused
from envlights.environment.layouts.records import (
    NO_ARGUMENTS,
    REGISTRATIONS,
    Arguments,
    ArrangedPicture,
    Source,
)
from envlights.environment.layouts.shapes import is_panorama, projection_of_shape, samples_of
from envlights.environment.layouts.stereo import one_eye

#: Projections of GPano by the value of `projection=`.
_GPANO = {"equirectangular": "equirectangular", "cylindrical": "cylinder"}


class _Kind(NamedTuple):
    """Projection of a picture, and its evidence."""

    projection: str
    recognised_by: str


def recognise(
    samples: NDArray[Any],
    hints: Hints = NO_HINTS,
    arguments: Arguments = NO_ARGUMENTS,
    coverage: NDArray[Any] | None = None,
) -> ArrangedPicture:
    """Recognise the projection of a picture, and arrange its samples for it.

    Parameters
    ----------
    samples : ndarray, shape (height, width), (height, width, channels) or (6, n, n, channels)
        Samples of any type. Six squares are the faces of a cube.
    hints : Hints, optional
        Statements of the file, from `read_image`.
    arguments : Arguments, optional
        Statements of the user, which go before all others.
    coverage : ndarray, optional
        Share of each pixel that is seen, without channels.

    Returns
    -------
    ArrangedPicture
        Equirectangular pictures and all others but cubes keep their array. A cube becomes the stack
        of its six upright faces, front right back left up down.

    Raises
    ------
    EnvLightsError
        If the projection cannot be decided; the sentence lists the candidates with their arguments.

    Examples
    --------
    >>> recognise(np.ones((64, 128, 3))).source.projection
    'equirectangular'
    >>> recognise(np.ones((64, 64, 3)), arguments=Arguments("angular")).layout.mapping
    'equidistant'
    """
    arguments.check()
    picture = samples_of(samples)
    arguments, is_stated = with_statement(arguments, hints, picture.shape[-3:-1])
    picture, coverage, notes = one_eye(picture, coverage, hints, arguments)
    kind = _kind(picture, hints, arguments)
    check_unused(kind.projection, arguments.names())
    if kind.projection == "cube":
        found = arrange_cube(picture, coverage, hints, arguments, kind.recognised_by)
    else:
        found = _arrange(picture, coverage, hints, arguments, kind)
    source = found.source._replace(recognised_by="attribute") if is_stated else found.source
    return found._replace(source=source, notes=(*notes, *found.notes))


def _kind(picture: NDArray[Any], hints: Hints, arguments: Arguments) -> _Kind:
    """Projection from the strongest statement."""
    if arguments.projection is not None:
        return _Kind(arguments.projection, "argument")
    if arguments.faces is not None:
        return _Kind("cube", "argument")
    if arguments.mapping is not None:
        return _Kind("fisheye", "argument")
    if hints.order:
        return _Kind("cube", "name")
    if hints.environment == "cube":
        return _Kind("cube", "attribute")
    if hints.environment == "latlong":
        return _Kind("equirectangular", "attribute")
    if hints.projection:
        return _kind_of_gpano(hints)
    projection = projection_of_shape(picture, hints.name)
    is_partial = projection == "equirectangular" and arguments.fov not in (None, 360)
    if is_partial or (projection != "cube" and arguments.circle is not None):
        raise _without_projection(picture, arguments)
    return _Kind(projection, "shape")


def _kind_of_gpano(hints: Hints) -> _Kind:
    if hints.projection in _GPANO:
        return _Kind(_GPANO[hints.projection], "attribute")
    raise EnvLightsError(
        f"the GPano projection of the picture is {hints.projection!r}; give projection= and its"
        f" arguments: {candidates(('equirectangular', 'cylinder', 'fisheye', 'planar'))}"
    )


def _without_projection(picture: NDArray[Any], arguments: Arguments) -> EnvLightsError:
    height, width = picture.shape[:2]
    given = ", ".join(arguments.names())
    names = ("equirectangular", "cylinder", "fisheye", "planar")
    return EnvLightsError(
        f"{given} needs projection= as well for a picture of {width}x{height} pixels: it may be"
        f" {candidates(names)}"
    )


def _arrange(
    picture: NDArray[Any],
    coverage: NDArray[Any] | None,
    hints: Hints,
    arguments: Arguments,
    kind: _Kind,
) -> ArrangedPicture:
    """Picture of one piece, whose array is not changed."""
    if picture.ndim == 4:
        raise EnvLightsError(
            f"six squares are the faces of a cube, not {kind.projection!r}; leave out projection=,"
            " or give projection='cube'"
        )
    height, width = picture.shape[:2]
    layout, notes = _LAYOUTS[kind.projection](height, width, hints, arguments)
    if layout.is_whole_sphere and arguments.projection is None and is_dual_fisheye(picture):
        raise EnvLightsError(
            f"a picture of {width}x{height} pixels with two discs in black squares is a dual"
            " fisheye, whose lenses only its camera knows; stitch it in the camera's program, or"
            " give projection='equirectangular' if it is a panorama"
        )
    registration = REGISTRATIONS[layout.border_sampled]
    source = Source(kind.projection, (height, width), "", registration, kind.recognised_by, layout)
    return ArrangedPicture(picture, coverage, layout, source, notes)


_Made = tuple[Layout, tuple[str, ...]]


def _equirectangular(height: int, width: int, hints: Hints, arguments: Arguments) -> _Made:
    is_border = hints.border_sampled
    if arguments.registration is not None:
        is_border = arguments.registration == REGISTRATIONS[1]
    if arguments.fov is not None and (arguments.fov < 360 or not is_panorama(height, width)):
        view = math.radians(arguments.fov)
        part = layouts.crop(height, width, field_of_view=view, horizon=arguments.horizon)
        return part, (f"the picture is a part of a panorama, {arguments.fov:g} degrees wide",)
    if not is_panorama(height, width):
        eyes = ", eye='left' if it holds two eyes" if width in (height, 4 * height) else ""
        raise EnvLightsError(
            f"an equirectangular map is twice as wide as high; got {width}x{height} pixels; give"
            f" the degrees of azimuth that a part of one covers as fov={eyes}, or another"
            " projection="
        )
    if height < 2:
        raise EnvLightsError(f"a map needs at least 4x2 pixels; got {width}x{height}")
    whole = layouts.equirectangular(height, width, border_sampled=is_border)
    if width == 2 * height:
        return whole, ()
    note = (
        f"{width}x{height} pixels, which are nearly twice as wide as high, are read as the whole"
        " sphere"
    )
    return whole, (note,)


def _cylinder(height: int, width: int, hints: Hints, arguments: Arguments) -> _Made:
    degrees = _first(arguments.fov, hints.field_of_view)
    horizon = _first(arguments.horizon, hints.horizon)
    if degrees is None:
        raise _needs("a cylindrical panorama", "fov=", "the degrees of azimuth that it covers")
    made = layouts.cylinder(height, width, field_of_view=math.radians(degrees), horizon=horizon)
    is_known = horizon is not None or hints.layout
    notes = [] if is_known else ["the horizon is taken to be the middle row (horizon=)"]
    if arguments.fov is None:
        notes.insert(0, f"a cylindrical panorama of {degrees:.4g} degrees (GPano)")
    return made, tuple(notes)


def _octahedral(height: int, width: int, hints: Hints, arguments: Arguments) -> _Made:
    n = _square(height, width, "an octahedral map")
    return layouts.octahedral(n, axes=_axes(arguments, layouts.UP)), ()


def _equal_area(height: int, width: int, hints: Hints, arguments: Arguments) -> _Made:
    n = _square(height, width, "an octahedral map")
    axes = _axes(arguments, layouts.PBRT)
    return layouts.octahedral(n, equal_area=True, axes=axes), ()


def _angular(height: int, width: int, hints: Hints, arguments: Arguments) -> _Made:
    n = _square(height, width, "an angular map")
    return layouts.angular_map(n, axes=_axes(arguments)), ()


def _mirror_ball(height: int, width: int, hints: Hints, arguments: Arguments) -> _Made:
    circle = _circle(arguments)
    n = _square(height, width, "a mirror ball") if circle is None else min(height, width)
    made = layouts.mirror_ball(n, circle=circle)._replace(height=height, width=width)
    note = (
        "a mirror ball as photographed: the camera, seen in its centre, becomes the front of the"
        " map (+z), and its right becomes +x"
    )
    return made, (note,)


def _fisheye(height: int, width: int, hints: Hints, arguments: Arguments) -> _Made:
    if arguments.mapping is None:
        maps = " or ".join(map(repr, layouts.MAPPINGS))
        raise _needs("a fisheye picture", "mapping=", f"{maps}")
    if arguments.fov is None:
        raise _needs("a fisheye picture", "fov=", "the degrees across its circle")
    view, circle, axes = math.radians(arguments.fov), _circle(arguments), _axes(arguments)
    size = (height, width)
    return layouts.fisheye(size, arguments.mapping, view, circle=circle, axes=axes), ()


def _planar(height: int, width: int, hints: Hints, arguments: Arguments) -> _Made:
    if arguments.fov is None:
        raise _needs("a photograph", "fov=", "its horizontal field of view in degrees")
    view = math.radians(arguments.fov)
    return layouts.planar(height, width, field_of_view=view, axes=_axes(arguments)), ()


_LAYOUTS: dict[str, Callable[[int, int, Hints, Arguments], _Made]] = {
    "equirectangular": _equirectangular,
    "cylinder": _cylinder,
    "octahedral": _octahedral,
    "octahedral-equal-area": _equal_area,
    "angular": _angular,
    "mirror-ball": _mirror_ball,
    "fisheye": _fisheye,
    "planar": _planar,
}


def _first(*values: float | None) -> float | None:
    return next((value for value in values if value is not None), None)


def _needs(what: str, argument: str, meaning: str) -> EnvLightsError:
    return EnvLightsError(f"{what} needs {argument}, {meaning}; give it")


def _square(height: int, width: int, what: str) -> int:
    """Side of a square picture, or a refusal."""
    if height != width:
        raise EnvLightsError(
            f"{what} is square; got {width}x{height} pixels; crop the picture, or give another"
            " projection="
        )
    return height


def _axes(arguments: Arguments, default: Axes = layouts.FRONT) -> Axes:
    if arguments.forward is not None:
        return layouts.looking(arguments.forward)
    return default if arguments.axes is None else layouts.checked_axes(arguments.axes)


def _circle(arguments: Arguments) -> tuple[float, float, float] | None:
    """Centre and radius as numbers, or a refusal."""
    if arguments.circle is None:
        return None
    values: ArrayLike = arguments.circle
    x, y, radius = (*reals("circle", values, 1), *(math.nan,) * 3)[:3]
    if np.shape(values) != (3,) or not (np.isfinite([x, y, radius]).all() and radius > 0):
        raise EnvLightsError(
            "circle must be centre x, centre y and a radius above 0, in pixels; got"
            f" {describe(values)}"
        )
    return amount("circle", float(x), -1e9), amount("circle", float(y), -1e9), float(radius)
