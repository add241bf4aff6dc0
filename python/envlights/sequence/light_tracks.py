"""Lights of a sequence as curves over its frames, for keyframes in files."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import describe
from envlights._native import EnvLightsError
from envlights.export.targets import target_named
from envlights.sequence.frame_rig import FrameRig
from envlights.sequence.steadiness import frame_rate

#: Default frames per second of a file: the rate of film.
DEFAULT_FPS = 24.0


class LightTrack(NamedTuple):
    """Light over all frames; when absent it is black and keeps its direction."""

    id: int
    direction: NDArray[np.float64]
    """Unit vectors towards the light, (frames, 3)."""
    intensity: NDArray[np.float64]
    """Largest channel of the irradiance at normal incidence, (frames,)."""
    colour: NDArray[np.float64]
    """Irradiance over `intensity`, (frames, 3)."""
    radius: NDArray[np.float64]
    """Angular radius in radians, (frames,)."""


class LightTracks(NamedTuple):
    """All lights and the ambient term over the frames."""

    frames: tuple[int, ...]
    """Indices of the frames."""
    fps: float
    """Frames per second."""
    lights: tuple[LightTrack, ...]
    ambient: NDArray[np.float64]
    """Ambient radiance, (frames, 3)."""
    statement: str
    """Sentence about the units."""

    @property
    def seconds(self) -> NDArray[np.float64]:
        """Time of each frame since the first one."""
        return (np.array(self.frames) - self.frames[0]) / self.fps


def tracks_of(rigs: Iterable[FrameRig], target: str, fps: float | None) -> LightTracks:
    """Curves of the lights in the units of an export target.

    Raises
    ------
    EnvLightsError
        If `rigs` are no rigs of frames, or their ambient term is one of harmonics, which is not
        animated.
    """
    rigs, fps = checked_rigs(rigs), frame_rate(fps) or DEFAULT_FPS
    if any(rig.ambient.ndim == 2 for rig in rigs):
        raise EnvLightsError(
            f"a sequence for {target} must have a constant ambient term or none; got harmonics."
            " Follow the frames with ambient='constant', or save .jsonl"
        )
    units = target_named(target).units
    factor = units.factor_of(rigs[0].units)
    lights = _tracks(rigs, factor)
    statement = units.statement(rigs[0].units)
    ambient = factor * np.array([rig.ambient for rig in rigs])
    return LightTracks(tuple(rig.frame for rig in rigs), fps, lights, ambient, statement)


def checked_rigs(rigs: Iterable[FrameRig]) -> list[FrameRig]:
    """Rigs of the frames as a list; raises an error for other values."""
    found: Any = [*rigs] if isinstance(rigs, Iterable) else rigs
    if not isinstance(found, list) or not found or not all(isinstance(r, FrameRig) for r in found):
        raise EnvLightsError(
            f"rigs must be FrameRigs, as el.follow yields them, one or more; got {describe(rigs)}"
        )
    numbers = [rig.frame for rig in found]
    if any(last >= this for last, this in pairwise(numbers)):
        raise EnvLightsError("rigs must be in rising order of their frames, each frame once")
    return found


def _tracks(rigs: list[FrameRig], factor: float) -> tuple[LightTrack, ...]:
    """Curve of each light, from the frames that contain it."""
    present: dict[int, list[int]] = {}
    rows: dict[int, list[NDArray[np.float64]]] = {}
    for frame, rig in enumerate(rigs):
        lights = rig.lights
        table = np.column_stack([lights.direction, lights.irradiance, lights.angular_radius])
        for identity, row in zip(rig.ids, table, strict=True):
            present.setdefault(identity, []).append(frame)
            rows.setdefault(identity, []).append(row)
    return tuple(
        _track(each, np.array(present[each]), np.array(rows[each]), factor, len(rigs))
        for each in sorted(present)
    )


def _track(
    identity: int,
    present: NDArray[np.intp],
    rows: NDArray[np.float64],
    factor: float,
    frames: int,
) -> LightTrack:
    """Curve of a light; frames without it are black, with values of the nearest frame."""
    irradiance = rows[:, 3:6]
    most = irradiance.max(axis=1)
    intensity = np.zeros(frames)
    intensity[present] = factor * most
    colour = irradiance / np.where(most > 0, most, 1)[:, None]
    nearest = _nearest(present, frames)
    return LightTrack(identity, rows[nearest, :3], intensity, colour[nearest], rows[nearest, 6])


def _nearest(present: NDArray[np.intp], count: int) -> NDArray[np.intp]:
    """Index of the nearest frame in `present` for each frame; the earlier one if equal."""
    frames = np.arange(count)
    after = np.minimum(np.searchsorted(present, frames), len(present) - 1)
    before = np.maximum(after - 1, 0)
    is_before = np.abs(frames - present[before]) <= np.abs(frames - present[after])
    nearest: NDArray[np.intp] = np.where(is_before, before, after)
    return nearest
