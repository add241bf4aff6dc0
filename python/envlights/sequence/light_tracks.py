"""Lights of a sequence as curves over its frames, for files that hold keyframes."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import describe
from envlights._native import EnvLightsError
from envlights.export.targets import target_named
from envlights.sequence.frame_rig import FrameRig
from envlights.sequence.steadiness import frame_rate

#: Frames in a second of a file if the sequence does not say it: the rate of film.
DEFAULT_FPS = 24.0


class LightTrack(NamedTuple):
    """One light over all frames; before and after its life it is black and rests."""

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
    """Numbers of the frames."""
    fps: float
    """Frames in a second."""
    lights: tuple[LightTrack, ...]
    ambient: NDArray[np.float64]
    """Ambient radiance, (frames, 3)."""
    statement: str
    """Sentence on the units."""

    @property
    def seconds(self) -> NDArray[np.float64]:
        """Time of each frame from the first one."""
        return (np.array(self.frames) - self.frames[0]) / self.fps


def tracks_of(rigs: Iterable[FrameRig], target: str, fps: float | None) -> LightTracks:
    """Curves of the lights in the units of a target of `el.export`.

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
    ids = sorted({identity for rig in rigs for identity in rig.ids})
    lights = tuple(_track(rigs, identity, factor) for identity in ids)
    statement = units.statement(rigs[0].units)
    ambient = factor * np.array([rig.ambient for rig in rigs])
    return LightTracks(tuple(rig.frame for rig in rigs), fps, lights, ambient, statement)


def checked_rigs(rigs: Iterable[FrameRig]) -> list[FrameRig]:
    """Rigs of the frames as a list, or a refusal."""
    found: Any = [*rigs] if isinstance(rigs, Iterable) else rigs
    if not isinstance(found, list) or not found or not all(isinstance(r, FrameRig) for r in found):
        raise EnvLightsError(
            f"rigs must be FrameRigs, as el.follow yields them, one or more; got {describe(rigs)}"
        )
    numbers = [rig.frame for rig in found]
    if any(last >= this for last, this in pairwise(numbers)):
        raise EnvLightsError("rigs must be in rising order of their frames, each frame once")
    return found


def _track(rigs: list[FrameRig], identity: int, factor: float) -> LightTrack:
    present = [frame for frame, rig in enumerate(rigs) if identity in rig.ids]
    lights = [rigs[frame].light(identity) for frame in present]
    irradiance = np.zeros((len(rigs), 3))
    irradiance[present] = factor * np.concatenate([each.irradiance for each in lights])
    intensity = irradiance.max(axis=1)
    nearest = _nearest(present, len(rigs))

    def hold(values: Callable[[Any], Any]) -> NDArray[np.float64]:
        """Values of the light, and those of the nearest frame where it is absent."""
        return np.concatenate([values(each) for each in lights])[nearest]

    colour = hold(lambda light: light.irradiance / (light.irradiance.max() or 1.0))
    direction = hold(lambda light: light.direction)
    return LightTrack(identity, direction, intensity, colour, hold(lambda x: x.angular_radius))


def _nearest(present: list[int], count: int) -> NDArray[np.intp]:
    distances = np.abs(np.arange(count)[:, None] - np.array(present))
    nearest: NDArray[np.intp] = distances.argmin(axis=1)
    return nearest
