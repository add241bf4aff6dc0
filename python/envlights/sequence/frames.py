"""Frames of a sequence: files by pattern or folder, a video, an array, or maps."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from envlights._common.check import describe
from envlights._common.errors import MissingFileError
from envlights._common.files import MAPS, matches
from envlights._native import EnvLightsError
from envlights.environment.fill import Fill
from envlights.environment.reading import AnyMap, Reading, as_envmap, check_reading
from envlights.sequence.video import NOTE, VIDEOS, video_frames

#: Pattern or folder of files, path of a video, array of shape (n, height, 2 * height, 3), or an
#: iterable of maps.
AnyFrames = str | os.PathLike[str] | Iterable[AnyMap] | ArrayLike


class Frames(NamedTuple):
    """Maps of a sequence, read one at a time."""

    maps: Iterable[AnyMap]
    number: int | None
    """Number of frames, if known."""

    fps: float | None = None
    """Frames per second, if the source states them."""


def read_frames(frames: Any, reading: Reading | None, fill: Fill) -> Frames:
    """Frames of `frames_of`, each read with these options when needed."""
    check_reading(reading)
    found = frames_of(frames)
    options = {} if reading is None else {"fill": fill, **reading}
    if isinstance(frames, str | os.PathLike) and Path(frames).suffix.lower() in VIDEOS:
        options["notes"] = (NOTE,)
    if not options:
        return found
    return found._replace(maps=(as_envmap(each, options) for each in found.maps))


def frames_of(frames: Any) -> Frames:
    """Frames from any argument that `follow` accepts.

    Raises
    ------
    EnvLightsError
        If there are no frames, or `frames` is nothing that holds any.
    """
    if isinstance(frames, str | os.PathLike):
        return _of_path(os.fspath(frames))
    if isinstance(frames, np.ndarray) and frames.ndim != 4:
        raise EnvLightsError(
            "frames as one array must have the shape (frames, height, 2 * height, 3); got the shape"
            f" {frames.shape}. Put a single map into a list, or use fit"
        )
    if isinstance(frames, bytes) or not isinstance(frames, Iterable):
        raise EnvLightsError(
            "frames must be a pattern such as 'frames/*.exr', a folder, a video, an array or maps"
            f" one after another; got {describe(frames)}"
        )
    if isinstance(frames, Sequence | np.ndarray):
        if not len(frames):
            raise EnvLightsError("frames must hold at least one map; got none")
        return Frames(frames, len(frames))
    return Frames(frames, None)


def natural_key(path: str) -> tuple[tuple[int, int, str], ...]:
    """Sort key that puts frame 9 before frame 10.

    Examples
    --------
    >>> sorted(["f10.exr", "f9.exr", "f1.exr"], key=natural_key)
    ['f1.exr', 'f9.exr', 'f10.exr']
    """
    parts = re.split(r"(\d+)", path)
    return tuple((1, int(part), "") if part.isdecimal() else (0, 0, part) for part in parts)


def _of_path(path: str) -> Frames:
    """Files of a pattern or folder in natural order, or the frames of a video."""
    if Path(path).suffix.lower() in VIDEOS:
        return Frames(*video_frames(path))
    if Path(path).is_dir():
        every = [str(each) for each in Path(path).iterdir()]
        found = [each for each in every if Path(each).suffix.lower() in MAPS]
    else:
        every = [path] if Path(path).is_file() else matches(path)
        found = [each for each in every if Path(each).is_file()]
    if not found:
        raise MissingFileError(
            f"no map matches {path}; give a pattern such as 'frames/*.exr', a folder of maps"
            f" ({', '.join(MAPS)}), or a video ({', '.join(VIDEOS)})"
        )
    found.sort(key=natural_key)
    return Frames(found, len(found))


def enumerate_maps(maps: Iterable[AnyMap]) -> Iterator[tuple[int, AnyMap]]:
    """Maps with their indices from 0; raises an error if there are none."""
    number = -1
    for number, env in enumerate(maps):
        yield number, env
    if number < 0:
        raise EnvLightsError("frames must hold at least one map; got none")
