"""OpenUSD: distant lights and a dome with a time sample for each frame."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from envlights.export.formats.usd_stage import Stage
from envlights.export.formats.usd_text import prim
from envlights.sequence.frame_rig import FrameRig
from envlights.sequence.light_tracks import LightTrack, tracks_of


def usd(
    rigs: Iterable[FrameRig],
    fps: float | None = None,
    *,
    up: str = "y",
    metres_per_unit: float = 1.0,
) -> str:
    """A stage of animated lights as text; a time code is the number of a frame.

    Parameters
    ----------
    rigs : iterable of FrameRig
        Rigs of the frames, such as a `RigSequence`.
    fps : float, optional
        Frames in a second. Default: 24.
    up, metres_per_unit
        Up axis and unit of the stage, as in `el.export.usd`.

    Returns
    -------
    str
        Prims as in `el.export.usd`, ``light_`` and the identity; transform, color, intensity and
        angle have a sample in each frame. A light has the intensity 0 in frames without it. Over a
        floor, the dome lights from below too.

    Examples
    --------
    >>> import envlights as el
    >>> lamp = el.Lights([[0, 1, 0]], [[3, 1.5, 0]], [0.1])
    >>> text = usd([el.sequence.FrameRig([0, 0, 0], lamp, 0.0, frame=k, ids=(2,)) for k in (0, 1)])
    >>> "float inputs:intensity.timeSamples = {0: 3.0, 1: 3.0}" in text
    True
    """
    stage = Stage(up, metres_per_unit).checked()
    tracks = tracks_of(rigs, "usd", fps)
    prims = [_light(stage, track, tracks.frames) for track in tracks.lights]
    if tracks.ambient.any():
        most = tracks.ambient.max(axis=1)
        colour = tracks.ambient / np.where(most > 0, most, 1)[:, None]
        prims.append(prim("DomeLight", "ambient", _colour(colour, most, tracks.frames)))
    return stage.text(
        prims,
        tracks.statement,
        startTimeCode=tracks.frames[0],
        endTimeCode=tracks.frames[-1],
        timeCodesPerSecond=tracks.fps,
    )


def _light(stage: Stage, track: LightTrack, frames: Sequence[int]) -> str:
    matrices = [stage.light_matrix(direction) for direction in track.direction]
    angles = [repr(float(2 * np.rad2deg(radius))) for radius in track.radius]
    return prim(
        "DistantLight",
        f"light_{track.id}",
        [
            f"float inputs:angle.timeSamples = {_samples(frames, angles)}",
            *_colour(track.colour, track.intensity, frames),
            "bool inputs:normalize = 1",
            f"matrix4d xformOp:transform.timeSamples = {_samples(frames, matrices)}",
            'uniform token[] xformOpOrder = ["xformOp:transform"]',
        ],
    )


def _colour(
    colour: NDArray[np.float64], intensity: NDArray[np.float64], frames: Sequence[int]
) -> list[str]:
    colours = [repr(tuple(each)) for each in colour.tolist()]
    intensities = [repr(each) for each in intensity.tolist()]
    return [
        f"color3f inputs:color.timeSamples = {_samples(frames, colours)}",
        f"float inputs:intensity.timeSamples = {_samples(frames, intensities)}",
    ]


def _samples(frames: Sequence[int], values: list[str]) -> str:
    pairs = zip(frames, values, strict=True)
    return "{" + ", ".join(f"{frame}: {value}" for frame, value in pairs) + "}"
