"""Halves of a stereo panorama: one eye is read."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from envlights._native import EnvLightsError
from envlights.environment.files.hints import Hints
from envlights.environment.layouts.records import EYES, Arguments
from envlights.environment.layouts.shapes import halves

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
