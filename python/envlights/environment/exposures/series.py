"""Merge of exposures of a panorama into one linear image, step by step."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.words import percent
from envlights._native import EnvLightsError
from envlights.environment.exposures import alignment, checks
from envlights.environment.exposures.clip_level import whites
from envlights.environment.exposures.comparison import Comparison, comparisons
from envlights.environment.exposures.merge import Exposure, dilate, distance, merge
from envlights.environment.exposures.pictures import Picture, check_sizes, read, series_of
from envlights.environment.exposures.response import Response, by_hand, known_responses
from envlights.environment.exposures.times import exposure_times
from envlights.kernels.sphere import pixel_solid_angles

#: Distance of clipped codes to the clip level, which JPEG moves by a few codes.
_CLIPPED = 4 / 255
#: Fraction of the clip level from which linear samples count as clipped.
_CLIPPED_LINEAR = 0.985
#: Fraction of the sphere above which moving objects are reported.
_LEAST_SHARE = 1e-3


@dataclass(frozen=True, eq=False)
class MergeResult:
    """Radiance of a series of exposures."""

    radiance: NDArray[np.float32]
    """Radiance for an exposure of 1 s, (height, width, 3)."""

    clip_level: float | None
    """Clip level if the shortest exposure is clipped."""

    border_sampled: bool
    """True if the outer pixels lie on the seam and the poles."""

    notes: tuple[str, ...]
    """Notes on the series."""

    ev100: float | None = None
    """Exposure value at ISO 100 of the radiance; None if the times have no unit."""


def merge_exposures(
    pictures: Iterable[ArrayLike | str | os.PathLike[str]],
    times: Iterable[float] | None,
    response: str | ArrayLike | None,
) -> MergeResult:
    """Merge pictures taken from one position, in any order, into one linear image."""
    series, are_exposures = _read_all(pictures, times)
    notes = list(dict.fromkeys(note for picture in series for note in picture.notes))
    levels = whites(series)
    _note_whites(series, levels, notes)
    curve, seconds = _response_and_times(series, levels, response, notes)
    exposures = [
        _exposure_of(picture, level, curve, time)
        for picture, level, time in zip(series, levels, seconds, strict=True)
    ]
    border_sampled = any(picture.border_sampled for picture in series)
    if not border_sampled:
        exposures = _without_motion(exposures, series, notes)
    radiance, is_moved, is_lost = merge(exposures)
    _note_ghosts(is_moved, notes)
    clip_level = exposures[0].clip_level / exposures[0].time if is_lost else None
    shown = f"{seconds[0]:.3g} to {seconds[-1]:.3g}"
    about = f"{len(series)} exposures were merged, with times from {shown}"
    # An exposure of 1 s at ISO 100 and f/1 has the exposure value 0.
    ev100 = 0.0 if are_exposures else None
    return MergeResult(radiance, clip_level, border_sampled, (about, *notes), ev100)


def _read_all(pictures: object, times: object) -> tuple[list[Picture], bool]:
    """Pictures of a series, shortest first, and True if their times have a unit."""
    sources = series_of(pictures)
    seconds, are_exposures = exposure_times(sources, times)
    order = np.argsort(seconds, kind="stable")
    series = [read(sources[place], int(place) + 1, seconds[place]) for place in order]
    check_sizes(series)
    if len({picture.is_linear for picture in series}) > 1:
        kinds = ", ".join(str(picture.number) for picture in series if picture.is_linear)
        raise EnvLightsError(
            f"exposures must be of one kind; {kinds} of {len(series)} are linear, the others are"
            " codes of a camera; give files of one format"
        )
    return series, are_exposures


def _note_whites(series: list[Picture], levels: list[float], notes: list[str]) -> None:
    """Add notes on clip levels below code 254."""
    low = {
        f"{255 * level:.0f}": picture.number
        for picture, level in zip(series, levels, strict=True)
        if not picture.is_linear and 255 * level < 253.5
    }
    if low:
        notes.append(f"the pictures end at code {', '.join(low)} of 255, which was taken for white")


def _response_and_times(
    series: list[Picture], levels: list[float], response: object, notes: list[str]
) -> tuple[Response, list[float]]:
    """Camera response, and times after a check against the pictures."""
    clip_level = min(max(levels), 1.0)
    log_times = np.log([picture.time for picture in series])
    numbers = [picture.number for picture in series]
    is_linear = series[0].is_linear
    if response is not None:
        candidates = [by_hand(response, 1.0 if is_linear else clip_level)]
    else:
        candidates = [by_hand("linear", 1.0)] if is_linear else known_responses(clip_level)
    pairs = _pairs(series, levels)
    found = checks.agreement(
        candidates, pairs, log_times, clip_level, may_estimate=response is None and not is_linear
    )
    checks.refuse_contradiction(found, pairs, log_times, numbers)
    if response is None and not is_linear and found.response.name != "sRGB":
        notes.append(f"the response of the camera is not sRGB; used: {found.response.name}")
    if found.response.name == "estimated":
        # Codes near white are not measured: the scale was 1.05 to 1.7 times the true one.
        notes[-1] += "; the radiance is relative: its scale may be off by a factor of 2"
    if found.wrong is not None:
        wrong = series[found.wrong]
        factor = np.exp(found.log_times[found.wrong] - log_times[found.wrong])
        notes.append(
            f"the time of exposure {wrong.number} is wrong: {wrong.time:.3g} was replaced by"
            f" {wrong.time * factor:.3g}, which its pixels show"
        )
    notes += checks.notes_of_pairs(found, pairs, numbers)
    notes += checks.notes_of_drift(found, pairs, numbers)
    return found.response, [float(time) for time in np.exp(found.log_times)]


def _pairs(series: list[Picture], levels: list[float]) -> list[Comparison]:
    near = []
    for picture, level in zip(series, levels, strict=True):
        clipped: NDArray[np.bool_] = np.asarray(_is_clipped(picture, level).any(axis=2))
        near.append(dilate(clipped, distance(clipped.shape[1])))
    samples = [picture.samples for picture in series]
    return comparisons(samples, near, [min(level, 1.0) for level in levels])


def _is_clipped(picture: Picture, level: float) -> NDArray[np.bool_]:
    least = level * _CLIPPED_LINEAR if picture.is_linear else level - _CLIPPED
    return picture.samples >= np.float32(least)


def _exposure_of(picture: Picture, level: float, curve: Response, time: float) -> Exposure:
    """Linear exposure of a picture."""
    clipped = _is_clipped(picture, level)
    if picture.is_linear and curve.name == "linear":
        return Exposure(time, picture.samples, level, _CLIPPED_LINEAR * level, clipped, False)
    linear = curve.exposure(picture.samples)
    clip_level, clip = (float(curve.exposure(np.array([x]))[0]) for x in (level, level - _CLIPPED))
    return Exposure(time, linear, clip_level, clip, clipped, picture.rings)


def _without_motion(
    exposures: list[Exposure], series: list[Picture], notes: list[str]
) -> list[Exposure]:
    """Exposures with the motion between them removed."""
    width = exposures[0].linear.shape[1]
    motions = [
        alignment.motion(
            short.linear,
            long.linear,
            float(np.log(long.time / short.time)),
            min(short.clip, long.clip),
        )
        for short, long in pairwise(exposures)
    ]
    moves = alignment.positions(motions)
    result = []
    for exposure, move, picture in zip(exposures, moves, series, strict=True):
        if not alignment.is_moved(move, width):
            result.append(exposure)
            continue
        notes.append(
            f"exposure {picture.number} was moved by {move.pixels(width):.1f} pixels onto the"
            " others"
        )
        mask = alignment.align(exposure.clipped.astype(np.float32), move) > 0.01
        linear = alignment.align(exposure.linear, move)
        result.append(
            Exposure(
                exposure.time, linear, exposure.clip_level, exposure.clip, mask, exposure.rings
            )
        )
    return result


def _note_ghosts(is_moved: NDArray[np.bool_], notes: list[str]) -> None:
    solid_angles = pixel_solid_angles(*is_moved.shape)
    fraction = float(solid_angles[is_moved].sum() / solid_angles.sum())
    if fraction > _LEAST_SHARE:
        notes.append(
            f"exposures contradict each other on {percent(fraction, 2)} of the sphere, where"
            " something may have moved; only the best exposure was used there"
        )
