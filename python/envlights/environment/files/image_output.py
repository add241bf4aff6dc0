"""Writers of linear RGB: OpenEXR, Radiance, TIFF and PNG files."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._common.check import check_choice, flag
from envlights._common.errors import FileError
from envlights._common.files import as_path, write_atomically
from envlights._common.srgb import encode_srgb
from envlights._common.units import OWN_SCALE, PHOTOMETRIC
from envlights._native import EnvLightsError
from envlights.environment.colour.primaries import REC709

#: Lossless compression methods of OpenEXR.
COMPRESSIONS: tuple[str, ...] = ("zip", "piz", "rle", "none")
#: Number of rows that are encoded at once.
_ROWS_AT_ONCE = 128
_LARGEST_HALF = float(np.finfo(np.float16).max)
#: Largest value of a Radiance file: mantissa 255 with exponent 127; above it, the mantissa would be
#: rounded to 256.
_END_OF_RGBE = 255.5 * 2.0**119


def write_exr(
    path: str | os.PathLike[str],
    radiance: NDArray[np.float32],
    *,
    half: bool = False,
    compression: str = COMPRESSIONS[0],
    environment: str = "",
    comments: Iterable[str] = (),
    units: str = OWN_SCALE,
) -> None:
    """Write linear Rec.709 RGB, (height, width, 3), as an OpenEXR file.

    Parameters
    ----------
    path : path-like
    radiance : ndarray, shape (height, width, 3) or (height, width, 4)
        The fourth channel is alpha, by which the colour is multiplied.
    half : bool
        16 instead of 32 bits for each sample: 11 digits in binary, up to 65504.
    compression : {"zip", "piz", "rle", "none"}
        All keep every bit.
    environment : {"", "latlong", "cube"}
        Attribute ``envmap``, for maps whose outer pixels lie on the seam and the poles, or on the
        edges of six faces in the order of OpenEXR: readers take the pixels so.
    comments : iterable of str
        Lines of the attribute ``comments``.
    units : str
        "cd/m2" becomes the attribute ``whiteLuminance``: the luminance of RGB (1, 1, 1).
    """
    check_choice("compression", compression, COMPRESSIONS)
    check_choice("environment", environment, ("", "latlong", "cube"))
    if flag("half", half) and radiance.max(initial=0) > _LARGEST_HALF:
        raise FileError(
            f"cannot write {path} with half floats: its largest sample is {radiance.max():g},"
            f" above their {_LARGEST_HALF:g}; write it with half=False"
        )
    statements = (
        REC709,
        1.0 if units == PHOTOMETRIC else None,
        environment,
        _description(comments),
    )
    samples = np.asarray(radiance, np.float32)
    _write(path, _native.exr_file(samples, half, compression, statements))


def with_alpha(
    radiance: NDArray[np.float32], coverage: NDArray[np.float32] | None
) -> NDArray[np.float32]:
    """Samples for `write_exr`, with the coverage as alpha unless it is complete."""
    if coverage is None:
        return radiance
    return np.concatenate([radiance, coverage[..., None]], axis=-1)


def write_codes(path: str | os.PathLike[str], codes: NDArray[np.uint8]) -> None:
    """Write sRGB codes, (height, width, 3 or 4), as a PNG file with straight alpha."""
    _write(path, _native.png_file(codes, ""))


def write_hdr(
    path: str | os.PathLike[str],
    radiance: NDArray[np.float32],
    *,
    comments: Iterable[str] = (),
    rounds: bool = True,
) -> None:
    """Write linear Rec.709 RGB as a Radiance file: 8 bits and a shared exponent.

    Parameters
    ----------
    path : path-like
    radiance : ndarray, shape (height, width, 3)
        Samples from 0 to 1.7e38; a larger one is refused.
    comments : iterable of str
        Comment lines of the header.
    rounds : bool
        True: mantissas are rounded to nearest, as image libraries read them. False: they are
        rounded down, for the programs of Radiance, which add half a step.
    """
    largest = float(radiance.max(initial=0))
    if not largest < _END_OF_RGBE:
        raise FileError(
            f"cannot write {path}: its largest sample is {largest:g}, above the"
            f" {_END_OF_RGBE:.3g} of Radiance files; scale the map, or write an .exr file"
        )
    height, width, _ = radiance.shape
    header = [
        "#?RADIANCE",
        *(f"# {line}" for line in _lines(comments)),
        "SOFTWARE=envlights",
        "EXPOSURE=1",
        f"PRIMARIES={' '.join(f'{value:g}' for value in REC709)}",
        "FORMAT=32-bit_rle_rgbe",
        "",
        f"-Y {height} +X {width}",
        "",
    ]

    def write(beside: Path) -> None:
        with beside.open("wb") as file:
            file.write("\n".join(header).encode())
            for top in range(0, height, _ROWS_AT_ONCE):
                rows = np.ascontiguousarray(radiance[top : top + _ROWS_AT_ONCE], np.float32)
                file.write(_native.radiance_rows(rows, rounds))

    write_atomically(path, write)


def write_tiff(
    path: str | os.PathLike[str],
    radiance: NDArray[np.float32],
    *,
    comments: Iterable[str] = (),
) -> None:
    """Write linear Rec.709 RGB, (height, width, 3), as a TIFF file of 32-bit floats.

    Parameters
    ----------
    path : path-like
    radiance : ndarray, shape (height, width, 3)
    comments : iterable of str
        Lines of the tag ``ImageDescription``.
    """
    _write(path, _native.tiff_file(np.asarray(radiance, np.float32), _description(comments)))


def write_png(
    path: str | os.PathLike[str],
    radiance: NDArray[np.float32],
    *,
    comments: Iterable[str] = (),
) -> None:
    """Write linear Rec.709 RGB, (height, width, 3), as a PNG file of 16-bit sRGB codes.

    Parameters
    ----------
    path : path-like
    radiance : ndarray, shape (height, width, 3)
        Samples from 0 to 1; a larger one is refused.
    comments : iterable of str
        Lines of the text ``Description``.
    """
    largest = float(radiance.max(initial=0))
    if not largest <= 1:
        raise FileError(
            f"cannot write {path}: its largest sample is {largest:g}, above the 1 of PNG files;"
            " scale the map, limit it (`limited(1)`, or `envlights convert --limit 1`), or write"
            " an .exr, .hdr or .tif file"
        )
    codes = np.round(encode_srgb(radiance) * 65535).astype(np.uint16)
    _write(path, _native.png_file(codes, _description(comments)))


def _lines(comments: Iterable[str]) -> list[str]:
    """Comments as lines without line breaks and control characters."""
    return ["".join(c if c.isprintable() else " " for c in comment) for comment in comments]


def _description(comments: Iterable[str]) -> str:
    """Comments as the lines of a description; empty without comments."""
    return "\n".join(_lines(comments))


def _write(path: str | os.PathLike[str], data: bytes) -> None:
    write_atomically(path, lambda beside: beside.write_bytes(data))


#: Suffixes of map files.
MAP_SUFFIXES = (".exr", ".hdr")
#: Suffixes of pictures in any projection.
PICTURE_SUFFIXES = (*MAP_SUFFIXES, ".tif", ".tiff", ".png")


def map_suffix(
    path: str | os.PathLike[str], suffixes: tuple[str, ...] = MAP_SUFFIXES, what: str = "a map"
) -> str:
    """Suffix of a map or picture file; raises an error for other suffixes."""
    suffix = as_path(path).suffix.lower()
    if suffix not in suffixes:
        raise EnvLightsError(
            f"cannot save {what} as {path}; the suffix must be one of {', '.join(suffixes)}"
        )
    return suffix
