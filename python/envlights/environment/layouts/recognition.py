"""Recognition of a projection, from arguments, metadata, names, shape and seams."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import PurePath
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights._native import EnvLightsError
from envlights.environment.files.hints import NO_HINTS, Hints
from envlights.environment.layouts.attribute import with_statement
from envlights.environment.layouts.cubes import arrange_cube, is_unfolded_cube
from envlights.environment.layouts.face_names import face_of_name
from envlights.environment.layouts.faces import crosses_of
from envlights.environment.layouts.near_ball import straighten
from envlights.environment.layouts.projections import (
    EYES,
    REGISTRATIONS,
    Layout,
    argument_for,
    candidates,
    is_panorama,
    of_shape,
    place,
)
from envlights.environment.layouts.records import ArrangedPicture, Origin
from envlights.environment.layouts.seams import every_nth, log_luminance

#: Projections by their GPano names.
_GPANO = {"equirectangular": "equirectangular", "cylindrical": "cylinder"}


class _Kind(NamedTuple):
    """Projection of a picture, with its evidence."""

    projection: str
    recognised_by: str


def recognise(
    samples: NDArray[Any],
    hints: Hints = NO_HINTS,
    layout: Layout = Layout(),  # noqa: B008, it is frozen
    coverage: NDArray[Any] | None = None,
) -> ArrangedPicture:
    """Recognise the projection of a picture, and arrange its samples for it.

    Parameters
    ----------
    samples : ndarray, shape (height, width), (height, width, channels) or (6, n, n, channels)
        Samples of any type. Six squares are the faces of a cube.
    hints : Hints, optional
        Statements of the file, from `read_image`.
    layout : Layout, optional
        Statements of the user, which go before all others.
    coverage : ndarray, optional
        Fraction of each pixel that is seen, without channels.

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
    >>> recognise(np.ones((64, 64, 3)), layout=Layout("angular")).layout.mapping
    'equidistant'
    """
    picture = samples_of(samples)
    layout, is_stated = with_statement(layout, hints, picture.shape[-3:-1])
    picture, coverage, notes = one_eye(picture, coverage, hints, layout)
    kind = _kind(picture, hints, layout)
    layout = replace(layout, projection=kind.projection)
    if kind.projection == "cube":
        found = arrange_cube(picture, coverage, hints, layout, kind.recognised_by)
    else:
        found = _arrange(picture, coverage, hints, layout, kind)
    source = found.source._replace(recognised_by="attribute") if is_stated else found.source
    return found._replace(source=source, notes=(*notes, *found.notes))


def _kind(picture: NDArray[Any], hints: Hints, layout: Layout) -> _Kind:
    """Projection by the strongest evidence."""
    if layout.projection is not None:
        return _Kind(layout.projection, "argument")
    if layout.faces is not None:
        return _Kind("cube", "argument")
    if layout.mapping is not None:
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
    is_partial = projection == "equirectangular" and layout.fov not in (None, 360)
    if is_partial or (projection != "cube" and layout.circle is not None):
        raise _without_projection(picture, layout)
    return _Kind(projection, "shape")


def _kind_of_gpano(hints: Hints) -> _Kind:
    if hints.projection in _GPANO:
        return _Kind(_GPANO[hints.projection], "attribute")
    raise EnvLightsError(
        f"the GPano projection of the picture is {hints.projection!r}; give layout=, of"
        f" {candidates(('equirectangular', 'cylinder', 'fisheye', 'planar'))}"
    )


def _without_projection(picture: NDArray[Any], layout: Layout) -> EnvLightsError:
    height, width = picture.shape[:2]
    given = ", ".join(layout.arguments())
    names = ("equirectangular", "cylinder", "fisheye", "planar")
    return EnvLightsError(
        f"{given} needs a projection as well for a picture of {width}x{height} pixels: it may be"
        f" {candidates(names)}"
    )


def _arrange(
    picture: NDArray[Any],
    coverage: NDArray[Any] | None,
    hints: Hints,
    layout: Layout,
    kind: _Kind,
) -> ArrangedPicture:
    """Picture of a single image, whose array is unchanged."""
    if picture.ndim == 4:
        raise EnvLightsError(
            f"six squares are the faces of a cube, not {kind.projection!r}; give"
            " layout='cube', or leave it out"
        )
    height, width = picture.shape[:2]
    made, notes = place(layout, (height, width), hints)
    if layout.distance is not None:
        circle = made.circle or (width / 2, height / 2, min(width, height) / 2)
        picture = straighten(picture, circle, layout.distance)
        if coverage is not None:
            coverage = straighten(coverage[..., None], circle, layout.distance)[..., 0]
    registration = REGISTRATIONS[made.border_sampled]
    source = Origin(kind.projection, (height, width), "", registration, kind.recognised_by, made)
    return ArrangedPicture(picture, coverage, made, source, notes)


def samples_of(samples: NDArray[Any]) -> NDArray[Any]:
    """Samples as (height, width, channels) or (6, n, n, channels), after a check."""
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
    """HEALPix parameter n_side for a number of pixels; 0 if no HEALPix map has that number."""
    side = math.isqrt(pixels // 12)
    return side if side and 12 * side * side == pixels else 0


def _healpix(pixels: int) -> EnvLightsError:
    return EnvLightsError(
        f"{pixels} pixels in one row are a HEALPix map of n_side {_healpix_side(pixels)}, which is"
        " not read; `healpy.cartview(..., return_projected_map=True)` makes a panorama of it"
    )


def projection_of_shape(picture: NDArray[Any], name: str = "") -> str:
    """Name of the projection; raises an error that lists the candidates if it is ambiguous.

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
            " folder or all six files, or layout= if it is a whole map"
        )
    raise EnvLightsError(
        f"an equirectangular map is twice as wide as high; got {width}x{height} pixels, which may"
        f" be {_candidates(picture)}; give one of them, or find the lights of a"
        " photograph with `detect_photograph` or `envlights photograph`"
    )


#: Argument that selects the left eye of a stereo panorama.
_LEFT_EYE = argument_for(Layout.equirectangular(eye="left"))


def _candidates(picture: NDArray[Any]) -> str:
    """Projections that fit the shape and the corners, most likely first."""
    height, width = picture.shape[:2]
    if height != width:
        is_stereo = width == 4 * height
        eyes = f" or two panoramas beside each other ({_LEFT_EYE})" if is_stereo else ""
        cube = [
            f"a cube map ({argument_for(Layout.cube(faces=name))})"
            for name in crosses_of(height, width)[:1]
        ]
        return ", ".join([*cube, candidates(of_shape("any", "panorama")[::-1]) + eyes])
    if has_black_corners(picture):
        return candidates((*of_shape("disc"), "planar"))
    squares = candidates((*of_shape("square"), "planar"))
    stereo = f"two panoramas, one above the other ({_LEFT_EYE})"
    return f"{stereo}, {squares}" if has_equal_halves(picture) else f"{squares}, or {stereo}"


def halves(array: NDArray[Any], *, above: bool) -> tuple[NDArray[Any], NDArray[Any]]:
    """First and second half of a picture as views: upper and lower, or left and right."""
    half = array.shape[0 if above else 1] // 2
    if above:
        return array[:half], array[half : 2 * half]
    return np.asarray(array)[:, :half], np.asarray(array)[:, half : 2 * half]


#: Stereo arrangements by the GSpherical mode: True for one above the other; the left eye is first.
_MODES = {"top-bottom": True, "left-right": False}


def one_eye(
    picture: NDArray[Any], coverage: NDArray[Any] | None, hints: Hints, layout: Layout
) -> tuple[NDArray[Any], NDArray[Any] | None, tuple[str, ...]]:
    """Picture of one eye, its coverage, and notes; a picture that is not stereo is unchanged.

    The left eye is the upper or the left half.
    """
    if hints.stereo and layout.eye is None:
        raise EnvLightsError(
            f"the picture holds panoramas of two eyes ({hints.stereo}); give"
            f" {_LEFT_EYE}, or eye='right'"
        )
    if layout.eye is None:
        return picture, coverage, ()
    above = _is_above(picture, hints)
    half = EYES.index(layout.eye)
    fraction = None if coverage is None else halves(coverage, above=above)[half]
    side = (("upper", "lower") if above else ("left", "right"))[half]
    note = f"only the {side} half, of the {layout.eye} eye, was read"
    return halves(picture, above=above)[half], fraction, (note,)


def _is_above(picture: NDArray[Any], hints: Hints) -> bool:
    """True if the eyes are one above the other; raises an error if that is unknown."""
    if hints.stereo in _MODES:
        return _MODES[hints.stereo]
    height, width = picture.shape[:2]
    if picture.ndim == 3 and width in (height, 4 * height):
        return bool(width == height)
    raise EnvLightsError(
        f"eye= reads panoramas of 2:1, one above the other (1:1) or left and right (4:1); got"
        f" {width}x{height} pixels; cut out one eye and give that"
    )


#: Largest luminance of black corners relative to the mean of the disc; JPEG codes have noise.
_BLACK = 0.02
#: Smallest fraction of the corners that is black, and of the disc that is brighter.
_MOST = 0.95
#: Smallest correlation of log luminance between the two halves of a stereo picture.
_ALIKE = 0.9
#: Smallest standard deviation of log luminance for which halves can be compared.
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
    """True if the upper and lower halves of a picture are nearly equal."""
    logs = log_luminance(every_nth(samples))
    half = len(logs) // 2
    upper, lower = logs[:half], logs[-half:]
    if half < 2 or min(upper.std(), lower.std()) < _CONTRAST:
        return False
    return float(np.corrcoef(upper.ravel(), lower.ravel())[0, 1]) > _ALIKE
