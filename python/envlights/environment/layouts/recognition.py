"""Recognition of a picture: its projection from arguments, metadata, names, shape and seams."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import PurePath
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import amount, describe, reals
from envlights._native import EnvLightsError
from envlights.environment.files.hints import NO_HINTS, Hints
from envlights.environment.layouts import picture_layout as layouts
from envlights.environment.layouts.attribute import with_statement
from envlights.environment.layouts.cubes import (
    arrange_cube,
    crosses_of,
    every_nth,
    face_of_name,
    is_unfolded_cube,
    log_luminance,
)
from envlights.environment.layouts.picture_layout import Axes, PictureLayout
from envlights.environment.layouts.projections import DISCS, SQUARES, candidates, check_unused
from envlights.environment.layouts.records import (
    EYES,
    NO_ARGUMENTS,
    REGISTRATIONS,
    Arguments,
    ArrangedPicture,
    Origin,
)

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
    registration = REGISTRATIONS[layout.border_sampled]
    source = Origin(kind.projection, (height, width), "", registration, kind.recognised_by, layout)
    return ArrangedPicture(picture, coverage, layout, source, notes)


def refusal_of_discs(height: int, width: int) -> str:
    """Sentence on a picture that seems a panorama and is two discs in black squares."""
    return (
        f"a picture of {width}x{height} pixels with two discs in black squares is a dual"
        " fisheye, whose lenses only its camera knows; stitch it in the camera's program, or"
        " give projection='equirectangular' if it is a panorama"
    )


_Made = tuple[PictureLayout, tuple[str, ...]]


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


#: Columns by which a panorama may miss twice its height.
_OFF = 2
#: Columns for each column that a panorama may miss.
_COLUMNS_PER_MISS = 100


def samples_of(samples: NDArray[Any]) -> NDArray[Any]:
    """Samples as (height, width, channels) or (6, n, n, channels), or a refusal of other shapes."""
    shape = samples.shape
    if samples.ndim == 3 and shape[0] == 6 and shape[1] == shape[2] > 4:
        return samples[..., None]
    if samples.ndim == 2 and shape[1] <= 4 and _healpix_side(shape[0]):
        raise _healpix(shape[0])
    if samples.ndim == 2:
        return samples[..., None]
    if samples.ndim == 3 or (samples.ndim == 4 and shape[0] == 6 and shape[1] == shape[2]):
        return samples
    if samples.ndim == 1 and _healpix_side(len(samples)):
        raise _healpix(len(samples))
    raise EnvLightsError(
        "a map must have the shape (height, width, 3), (height, width) for grey, or (6, n, n, 3)"
        f" for the faces of a cube; got {shape}"
    )


def _healpix_side(pixels: int) -> int:
    """Parameter n_side of a HEALPix map with a number of pixels; 0 if there is none."""
    side = math.isqrt(pixels // 12)
    return side if side and 12 * side * side == pixels else 0


def _healpix(pixels: int) -> EnvLightsError:
    return EnvLightsError(
        f"{pixels} pixels in one row are a HEALPix map of n_side {_healpix_side(pixels)}, which is"
        " not read; `healpy.cartview(..., return_projected_map=True)` makes a panorama of it"
    )


def is_panorama(height: int, width: int) -> bool:
    """True for a size of 2:1, up to two columns in large pictures."""
    off = abs(width - 2 * height)
    return off == 0 or (off <= _OFF and off * _COLUMNS_PER_MISS <= width)


def projection_of_shape(picture: NDArray[Any], name: str = "") -> str:
    """Value of `projection=`, or a refusal with the candidates.

    Parameters
    ----------
    picture : ndarray, shape (height, width, channels) or (6, n, n, channels)
    name : str
        Name of the file.
    """
    if picture.ndim == 4:
        return "cube"
    height, width = picture.shape[:2]
    if is_panorama(height, width):
        return "equirectangular"
    if is_unfolded_cube(picture):
        return "cube"
    if height == width and (face := face_of_name(PurePath(name).stem)):
        raise EnvLightsError(
            f"a square picture with the name {face!r} seems to be one face of a cube map; give its"
            " folder or all six files, or projection= if it is a whole map"
        )
    raise EnvLightsError(
        f"an equirectangular map is twice as wide as high; got {width}x{height} pixels, which may"
        f" be {_candidates(picture)}; give the arguments of one of them, or find the lights of a"
        " photograph with `detect_photograph` or `envlights photograph`"
    )


def _candidates(picture: NDArray[Any]) -> str:
    """Projections that the shape and the corners admit, likely ones first."""
    height, width = picture.shape[:2]
    if height != width:
        eyes = " or two panoramas beside each other (eye='left')" if width == 4 * height else ""
        crosses = crosses_of(height, width)
        cube = [f"a cube map (faces={crosses[0]!r})"] if crosses else []
        return ", ".join([*cube, candidates(("planar", "cylinder", "equirectangular")) + eyes])
    if has_black_corners(picture):
        return candidates((*DISCS, "planar"))
    squares = candidates((*SQUARES, "planar"))
    stereo = "two panoramas, one above the other (eye='left')"
    return f"{stereo}, {squares}" if has_equal_halves(picture) else f"{squares}, or {stereo}"


def halves(array: NDArray[Any], *, above: bool) -> tuple[NDArray[Any], NDArray[Any]]:
    """First and second half of a picture, views: upper and lower, or left and right."""
    half = array.shape[0 if above else 1] // 2
    if above:
        return array[:half], array[half : 2 * half]
    return np.asarray(array)[:, :half], np.asarray(array)[:, half : 2 * half]


#: Arrangements by the stereo mode of GSpherical: True for one above the other, left first.
_MODES = {"top-bottom": True, "left-right": False}


def one_eye(
    picture: NDArray[Any], coverage: NDArray[Any] | None, hints: Hints, arguments: Arguments
) -> tuple[NDArray[Any], NDArray[Any] | None, tuple[str, ...]]:
    """Picture of one eye, its share that is seen, and notes; a picture of one eye is unchanged.

    The left eye is the upper or the left half.
    """
    if hints.stereo and arguments.eye is None:
        raise EnvLightsError(
            f"the picture holds panoramas of two eyes ({hints.stereo}); give eye='left' or"
            " eye='right'"
        )
    if arguments.eye is None:
        return picture, coverage, ()
    above = _is_above(picture, hints)
    place = EYES.index(arguments.eye)
    fraction = None if coverage is None else halves(coverage, above=above)[place]
    side = (("upper", "lower") if above else ("left", "right"))[place]
    note = f"only the {side} half, of the {arguments.eye} eye, was read"
    return halves(picture, above=above)[place], fraction, (note,)


def _is_above(picture: NDArray[Any], hints: Hints) -> bool:
    """True for eyes one above the other, from the metadata or the shape, or a refusal."""
    if hints.stereo in _MODES:
        return _MODES[hints.stereo]
    height, width = picture.shape[:2]
    if picture.ndim == 3 and width in (height, 4 * height):
        return bool(width == height)
    raise EnvLightsError(
        f"eye= reads panoramas of 2:1, one above the other (1:1) or left and right (4:1); got"
        f" {width}x{height} pixels; cut out one eye and give that"
    )


#: Luminance of black corners relative to the mean of the disc; codes of JPEG pictures have noise.
_BLACK = 0.02
#: Fraction of the corners that is black, and of the disc that is brighter than the corners.
_MOST = 0.95
#: Smallest correlation of the log luminance of two halves that show one world.
_ALIKE = 0.9
#: Smallest standard deviation of the log luminance of halves that can be compared.
_CONTRAST = 1e-3


def has_black_corners(samples: NDArray[Any]) -> bool:
    """True if a square picture is black outside its largest circle and bright inside.

    Parameters
    ----------
    samples : ndarray, shape (n, n, channels)
    """
    luminance = np.exp(log_luminance(every_nth(samples)))
    luminance -= luminance.min()
    height, width = luminance.shape
    y, x = (np.arange(side) * 2 / max(side - 1, 1) - 1 for side in (height, width))
    radius = np.hypot(x[None], y[:, None])
    corners, disc = luminance[radius > 1.04], luminance[radius < 0.96]
    if not corners.size or not disc.size:
        return False
    level = _BLACK * float(disc.mean())
    is_black = float((corners <= level).mean()) >= _MOST
    return is_black and float((disc > level).mean()) >= _MOST


def has_equal_halves(samples: NDArray[Any]) -> bool:
    """True if the upper and the lower half of a picture show nearly the same."""
    logs = log_luminance(every_nth(samples))
    half = len(logs) // 2
    upper, lower = logs[:half], logs[-half:]
    if half < 2 or min(upper.std(), lower.std()) < _CONTRAST:
        return False
    return float(np.corrcoef(upper.ravel(), lower.ravel())[0, 1]) > _ALIKE
