"""Writers of linear RGB: OpenEXR, TIFF and PNG files by OpenImageIO, and Radiance files."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._common.check import check_choice, flag
from envlights._common.errors import FileError
from envlights._common.files import as_path, write_atomically
from envlights._common.srgb import encode_srgb
from envlights._common.units import OWN_SCALE, PHOTOMETRIC
from envlights._native import EnvLightsError
from envlights.environment.decoders.openimageio import WHITE_LUMINANCE, failure, oiio
from envlights.environment.files.images import REC709, read_image

#: Lossless compressions of OpenEXR.
COMPRESSIONS = ("zip", "piz", "rle", "none")
#: Width and height of tiles: OpenImageIO writes the attribute `envmap` into tiled files only.
_TILE = 64
#: A multiple of that, and of the rows that OpenEXR compresses together.
_ROWS_AT_ONCE = 128
#: Names of OpenImageIO for the values of the attribute `envmap`.
_TEXTURE_FORMATS = {"latlong": "LatLong Environment", "cube": "CubeFace Environment"}
_LARGEST_HALF = float(np.finfo(np.float16).max)
#: Radiance files hold mantissas up to 255 with the exponent 127; this would be rounded to 256.
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
    check_choice("environment", environment, ("", *_TEXTURE_FORMATS))
    if flag("half", half) and radiance.max(initial=0) > _LARGEST_HALF:
        raise FileError(
            f"cannot write {path} with half floats: its largest sample is {radiance.max():g},"
            f" above their {_LARGEST_HALF:g}; write it with half=False"
        )
    spec = _spec(radiance, oiio.HALF if half else oiio.FLOAT, comments)
    spec.attribute("compression", compression)
    spec.attribute("chromaticities", oiio.TypeDesc("float[8]"), REC709)
    if units == PHOTOMETRIC:
        spec.attribute(WHITE_LUMINANCE, 1.0)
    if environment:
        spec.attribute("textureformat", _TEXTURE_FORMATS[environment])
        spec.attribute("openexr:levelmode", 0)  # one level, no pyramid
        spec.tile_width = spec.tile_height = _TILE
    _write(path, spec, radiance)


def write_codes(path: str | os.PathLike[str], codes: NDArray[np.uint8]) -> None:
    """Write sRGB codes, (height, width, 3 or 4), as a PNG file; alpha is not in the colour."""
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
            " scale the map, use its `limited(1)`, or write an .exr, .hdr or .tif file"
        )
    codes = np.round(encode_srgb(radiance) * 65535).astype(np.uint16)
    _write(path, _native.png_file(codes, _description(comments)))


def _lines(comments: Iterable[str]) -> list[str]:
    """Comments without line breaks and other control characters, one line each."""
    return ["".join(c if c.isprintable() else " " for c in comment) for comment in comments]


def _description(comments: Iterable[str]) -> str:
    """Lines of a description; empty if there are none."""
    return "\n".join(_lines(comments))


def _write(path: str | os.PathLike[str], data: bytes) -> None:
    write_atomically(path, lambda beside: beside.write_bytes(data))


#: Suffixes of maps.
MAP_SUFFIXES = (".exr", ".hdr")
#: Suffixes of pictures in any projection.
PICTURE_SUFFIXES = (*MAP_SUFFIXES, ".tif", ".tiff", ".png")


def map_suffix(
    path: str | os.PathLike[str], suffixes: tuple[str, ...] = MAP_SUFFIXES, what: str = "a map"
) -> str:
    """Suffix of the file of a map or of a picture, or a refusal."""
    suffix = as_path(path).suffix.lower()
    if suffix not in suffixes:
        raise EnvLightsError(
            f"cannot save {what} as {path}; the suffix must be one of {', '.join(suffixes)}"
        )
    return suffix


def _spec(
    radiance: NDArray[Any], sample: oiio.BASETYPE, comments: Iterable[str] = ()
) -> oiio.ImageSpec:
    height, width, channels = radiance.shape
    spec = oiio.ImageSpec(width, height, channels, sample)
    # Leave out the time of writing, so that equal maps give equal files.
    spec.attribute("DateTime", "")
    if lines := _lines(comments):
        # OpenImageIO writes this as `comments` of OpenEXR and as `Description` of PNG.
        spec.attribute("ImageDescription", "\n".join(lines))
    return spec


def _write(path: str | os.PathLike[str], spec: oiio.ImageSpec, radiance: NDArray[Any]) -> None:
    """Write an image beside `path`, read it back, and move it into place."""

    def write(beside: Path) -> None:
        file = oiio.ImageOutput.create(str(beside))
        done = file and file.open(str(beside), spec) and _fill(file, radiance) and file.close()
        if not done:
            reason = failure(file or oiio)
            raise OSError(reason.replace(str(beside), str(path)))
        _check_whole(beside)

    write_atomically(path, write)


def _fill(file: oiio.ImageOutput, radiance: NDArray[Any]) -> bool:
    """Write the pixels in blocks of rows, so that Ctrl-C works; True on success."""
    spec = file.spec()
    for top in range(0, spec.height, _ROWS_AT_ONCE):
        rows = radiance[top : top + _ROWS_AT_ONCE]
        if spec.tile_width:
            written = file.write_tiles(0, spec.width, top, top + len(rows), 0, 1, rows)
        else:
            written = file.write_scanlines(top, top + len(rows), 0, rows)
        if not written:
            return False
    return True


def _check_whole(path: Path) -> None:
    """Read the file back, because OpenImageIO does not report a full disk for the last bytes."""
    try:
        read_image(path, any_projection=True)
    except EnvLightsError:
        raise OSError("not all of it could be written; is the disk full?") from None
