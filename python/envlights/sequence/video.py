"""Frames of a video file, decoded by PyAV (extra `video`)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from envlights._common.errors import DamagedFileError, MissingFileError
from envlights._native import EnvLightsError

#: 8-bit codes of a frame, (height, width, 3).
Codes: TypeAlias = NDArray[np.uint8]
#: Suffixes of videos.
VIDEOS = (".mp4", ".mov", ".mkv", ".webm", ".avi")
#: HDR transfer curves of ITU-T H.273, which need linear image files instead.
_CURVES = {16: "PQ", 18: "HLG"}
#: Note of each frame.
NOTE = "a frame of a video: 8-bit codes read as sRGB, so bright lights are clipped"


def video_frames(path: str) -> tuple[Iterable[Codes], int | None, float | None]:
    """Codes of the frames, read one at a time; frame count and rate if the file states them.

    Raises
    ------
    EnvLightsError
        If the file is missing or damaged, has no picture or one of high dynamic range, or PyAV is
        not installed.
    """
    try:
        av = import_module("av")
    except ImportError as error:
        raise EnvLightsError(
            f"videos need PyAV, which cannot be imported: {error}; install it with"
            " pip install 'envlights[video]', or write the frames as files"
        ) from None
    if not Path(path).is_file():
        raise MissingFileError(f"cannot read {path}: there is no such file")
    with _open(av, path) as file:
        if not file.streams.video:
            raise EnvLightsError(f"{path} holds no pictures; give a video of equirectangular maps")
        stream = file.streams.video[0]
        curve = _CURVES.get(int(stream.codec_context.color_trc or 0))
        if curve:
            raise EnvLightsError(
                f"{path} is a {curve} video, whose codes are not decoded; write its frames as"
                " linear .exr files"
            )
        rate = stream.average_rate
        return _frames(av, path), stream.frames or None, float(rate) if rate else None


def _frames(av: Any, path: str) -> Iterator[Codes]:
    with _open(av, path) as file:
        try:
            for frame in file.decode(video=0):
                yield frame.to_ndarray(format="rgb24")
        except av.error.FFmpegError as error:
            raise DamagedFileError(f"{path} cannot be decoded: {error}") from None


def _open(av: Any, path: str) -> Any:
    try:
        return av.open(path)
    except (av.error.FFmpegError, OSError) as error:
        raise DamagedFileError(f"{path} is not a video that PyAV reads: {error}") from None
