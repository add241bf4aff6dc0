"""Reader of camera raw files by rawpy, as linear pictures."""

from __future__ import annotations

import os
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.errors import DamagedFileError, FileError, MissingFileError

#: Suffixes of raw files.
SUFFIXES = (".arw", ".cr2", ".cr3", ".dng", ".nef", ".orf", ".pef", ".raf", ".rw2", ".srw")

#: Note on a developed raw file.
NOTE = "raw files were developed by LibRaw: linear Rec.709, white balance of the camera"


def is_raw(path: str | os.PathLike[str]) -> bool:
    """True if the suffix belongs to a raw file."""
    return Path(os.fsdecode(path)).suffix.lower() in SUFFIXES


def read(path: str | os.PathLike[str]) -> NDArray[np.float32]:
    """Linear Rec.709 samples of a raw file, clipped at 1, (height, width, 3)."""
    rawpy = _library(path)
    with _open(rawpy, path) as file:
        try:
            samples = file.postprocess(
                gamma=(1, 1),
                no_auto_bright=True,
                output_bps=16,
                use_camera_wb=True,
                output_color=rawpy.ColorSpace.sRGB,
                highlight_mode=rawpy.HighlightMode.Clip,
            )
        except rawpy.LibRawError as error:
            raise DamagedFileError(f"{os.fsdecode(path)} cannot be decoded: {error}") from None
    return np.asarray(samples, dtype=np.float32) / np.float32(65535)


def exposure(path: str | os.PathLike[str]) -> dict[str, float]:
    """Exposure time, sensitivity and aperture of a raw file; missing values are absent."""
    with _open(_library(path), path) as file:
        shot = file.other
    found = {"time": shot.shutter_speed, "speed": shot.iso_speed, "aperture": shot.aperture}
    return {name: float(value) for name, value in found.items() if value and value > 0}


def _library(path: str | os.PathLike[str]) -> Any:
    try:
        return import_module("rawpy")
    except ImportError:
        raise FileError(
            f"cannot read {os.fspath(path)}: raw files need the library rawpy; install"
            " envlights[raw], or develop the file to a linear 16-bit TIFF"
        ) from None


def _open(rawpy: Any, path: str | os.PathLike[str]) -> Any:
    name = os.fsdecode(path)
    if not Path(name).is_file():
        raise MissingFileError(f"cannot read {name}: there is no such file; check its path")
    try:
        return rawpy.imread(name)
    except rawpy.LibRawError as error:
        raise FileError(f"cannot read {name} as a raw file: {error}") from None
