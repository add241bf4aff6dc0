"""Reader of images by OpenImageIO: linear radiance, and notes on assumptions."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._check import count
from envlights._native import EnvLightsError
from envlights._srgb import decode_codes
from envlights.io import png
from envlights.io.openimageio import oiio

#: Largest number of pixels, 32768 x 16384, unless a caller allows more, because a damaged header
#: may claim any number.
MOST_PIXELS = 2**29

#: Rows of one read, or more if tiles are taller.
_ROWS_AT_ONCE = 128

#: End of every refusal of a file.
_WANTED = "give a Radiance .hdr, OpenEXR, PNG, JPEG or TIFF image"

#: Sample formats: sRGB codes, and linear radiance.
_CODED = {"uint8", "uint16"}
_LINEAR = {"half", "float", "double"}

#: Primaries and white of Rec.709, as OpenEXR stores them: x and y of red, green, blue, white.
REC709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)


@dataclass(frozen=True, eq=False)
class Image:
    """Content of a file."""

    pixels: NDArray[np.float32]
    """Linear RGB, (height, width, 3)."""

    border_sampled: bool
    """True if the metadata puts the outer pixels on the seam and the poles."""

    notes: tuple[str, ...]
    """Remarks on assumptions and on ignored content."""

    white: float | None = None
    """Clip level of the samples; None for floating point."""


def read_image(path: str | os.PathLike[str], *, max_pixels: int = MOST_PIXELS) -> Image:
    """Read the first image of a file at full size.

    Parameters
    ----------
    path : path-like
        Radiance .hdr, OpenEXR, PNG, JPEG, TIFF, or any other format of OpenImageIO.
    max_pixels : int
        Files with more pixels are refused before memory is allocated.

    Returns
    -------
    Image
        Linear RGB. Files of 8 or 16 bit integers are decoded from sRGB.

    Raises
    ------
    EnvLightsError
        If the file is missing, damaged, too large, or holds no RGB or grey image.
    """
    count("max_pixels", max_pixels, least=1)
    path, name = _checked_path(path)
    # By default OpenImageIO multiplies the colour of PNG files by alpha.
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    file = oiio.ImageInput.open(path, config)
    if file is None:
        reason = failure(oiio)
        raise EnvLightsError(f"cannot read {name} as an image: {reason}; {_WANTED}")
    try:
        _check_spec(name, file.spec(), max_pixels)
        if obstacle := png.damage_of_pixels(path):
            raise EnvLightsError(f"cannot read {name}: {obstacle}; {_WANTED}")
        return _read(name, file)
    except MemoryError:
        raise EnvLightsError(
            f"cannot read {name}: its pixels do not fit into memory; give a smaller map"
        ) from None
    finally:
        file.close()


def _checked_path(path: str | os.PathLike[str]) -> tuple[str, str]:
    """Path as text, and its printable form, after a check that an image may be there."""
    try:
        text = os.fsdecode(path)
    except TypeError:
        raise EnvLightsError(f"a path must be text; got {type(path).__name__}; {_WANTED}") from None
    name = _printable(text)
    try:
        obstacle = _obstacle(text)
    except (OSError, ValueError) as error:  # a name that is too long, or no Unicode
        obstacle = _printable(getattr(error, "strerror", None) or str(error))
    if obstacle:
        raise EnvLightsError(f"cannot read {name or 'an empty path'}: {obstacle}; {_WANTED}")
    return text, name


def _obstacle(path: str) -> str:
    """Reason why no image can be read from `path`; empty if there is none."""
    path.encode()
    if not path or not Path(path).exists():
        return "there is no such file"
    if Path(path).is_dir():
        return "it is a folder"
    if not Path(path).is_file():
        return "it is not a regular file"
    if Path(path).stat().st_size == 0:
        return "the file is empty"
    return png.damage(path)


def _read(name: str, file: oiio.ImageInput) -> Image:
    spec = file.spec()
    channels, notes = _colour_channels(name, spec)
    is_coded = _is_coded(name, spec, channels)
    pixels = _pixels(name, file, channels)
    if is_coded:
        notes.append("integer samples were decoded from sRGB")
    pixels = _upright(_in_display_window(pixels, spec, notes), spec, notes)
    _note_primaries(spec, notes)
    if spec.get_int_attribute("oiio:subimages", 1) > 1:
        notes.append("only the first of several images in the file was read")
    border_sampled = bool(spec.getattribute("oiio:sampleborder"))
    white = 1.0 if is_coded else None
    return Image(pixels, border_sampled, tuple(notes), white)


def _pixels(name: str, file: oiio.ImageInput, channels: list[int]) -> NDArray[np.float32]:
    """Linear `channels` of the data window, read in blocks of rows.

    Blocks keep the memory near that of the pixels.
    """
    spec = file.spec()
    pixels = np.empty((spec.height, spec.width, len(channels)), np.float32)
    # Read whole rows of tiles.
    rows = -(-_ROWS_AT_ONCE // max(spec.tile_height, 1)) * max(spec.tile_height, 1)
    for top in range(0, spec.height, rows):
        part = pixels[top : top + rows]
        block = _samples(file, top, len(part), (min(channels), max(channels) + 1))
        if block is None or file.has_error:
            raise EnvLightsError(
                f"cannot read all pixels of {name}: {failure(file)}; give an undamaged file"
            )
        places = [channel - min(channels) for channel in channels]
        samples = block.reshape(*part.shape[:2], -1)
        if places != list(range(samples.shape[2])):
            samples = samples[..., places]
        part[:] = samples if samples.dtype.kind == "f" else decode_codes(samples)
    return pixels


def _samples(
    file: oiio.ImageInput, top: int, height: int, channels: tuple[int, int]
) -> NDArray[Any] | None:
    """Samples of some rows and of a range of channels, or None on failure."""
    spec = file.spec()
    as_type = spec.format if str(spec.format) in _CODED else oiio.FLOAT
    rows = (spec.y + top, spec.y + top + height)
    if spec.tile_width:
        columns = (spec.x, spec.x + spec.width)
        return file.read_tiles(0, 0, *columns, *rows, 0, 1, *channels, as_type)
    return file.read_scanlines(0, 0, *rows, 0, *channels, as_type)


def _check_spec(name: str, spec: oiio.ImageSpec, max_pixels: int) -> None:
    windows = [(spec.width, spec.height), (spec.full_width, spec.full_height)]
    width, height = max(windows, key=lambda size: size[0] * size[1])
    refusals = [
        (
            width * height > max_pixels,
            f"it claims to hold {width}x{height} pixels, more than {max_pixels}; if it is not"
            " damaged, give a higher max_pixels",
        ),
        (
            # OpenImageIO 3.2.2 returns freed memory for these.
            spec.tile_width > 0 and spec.format == oiio.DOUBLE,
            "it holds tiles of float64, which OpenImageIO misreads; give float32, or no tiles",
        ),
        (spec.depth > 1, f"it is a volume of {spec.depth} slices; give a flat image"),
        (spec.deep, "it is a deep image; give a flattened one"),
        (
            "CubeFace" in (spec.getattribute("textureformat") or ""),
            "it is a cube map; give an equirectangular one",
        ),
        (
            spec.get_int_attribute("Orientation", 1) > 4,
            "its header says that the image is rotated by 90 degrees; rotate the pixels",
        ),
    ]
    for is_so, reason in refusals:
        if is_so:
            raise EnvLightsError(f"cannot read {name}: {reason}")


def _colour_channels(name: str, spec: oiio.ImageSpec) -> tuple[list[int], list[str]]:
    """Indices of red, green and blue, and notes on the other channels."""
    names = list(spec.channelnames)
    rgb_names = next(
        (rgb for rgb in (["R", "G", "B"], ["r", "g", "b"]) if set(rgb) <= set(names)), None
    )
    colours = [c for c in names if c not in {"A", "Z"} and c != "Alpha"]
    notes = []
    if rgb_names is None and len(colours) == 1:
        rgb_names = colours * 3
        notes.append(f"the only channel, {colours[0]}, was read as grey")
    elif rgb_names is None:
        raise EnvLightsError(
            f"{name} has the channels {', '.join(names)}; it needs R, G and B, or a single channel"
        )
    ignored = [channel for channel in names if channel not in rgb_names]
    if "A" in ignored:
        notes.append("alpha was ignored")
    if others := [channel for channel in ignored if channel != "A"]:
        notes.append(f"other channels were ignored: {', '.join(others)}")
    return [names.index(channel) for channel in rgb_names], notes


def _is_coded(name: str, spec: oiio.ImageSpec, channels: list[int]) -> bool:
    """True if the samples are sRGB codes: integers are codes, floating point is linear."""
    formats = {str(spec.channelformat(channel)) for channel in channels}
    if others := formats - _CODED - _LINEAR:
        kinds = ", ".join(sorted(others))
        raise EnvLightsError(
            f"cannot read {name}: its samples are {kinds}; give floating point, uint8 or uint16"
        )
    return bool(formats & _CODED)


def _in_display_window(
    pixels: NDArray[np.float32], spec: oiio.ImageSpec, notes: list[str]
) -> NDArray[np.float32]:
    """Pixels of the display window, black outside the data window."""
    data = (spec.x, spec.y, spec.width, spec.height)
    display = (spec.full_x, spec.full_y, spec.full_width, spec.full_height)
    if data == display:
        return pixels
    notes.append(
        f"the data window {data} was placed in the display window {display}; the border is black"
    )
    whole = np.zeros((spec.full_height, spec.full_width, 3), np.float32)
    left, top = spec.x - spec.full_x, spec.y - spec.full_y
    rows = slice(max(top, 0), min(top + spec.height, spec.full_height))
    columns = slice(max(left, 0), min(left + spec.width, spec.full_width))
    if rows.start < rows.stop and columns.start < columns.stop:
        inside = pixels[
            rows.start - top : rows.stop - top, columns.start - left : columns.stop - left
        ]
        whole[rows, columns] = inside
    return whole


def _upright(
    pixels: NDArray[np.float32], spec: oiio.ImageSpec, notes: list[str]
) -> NDArray[np.float32]:
    """Image with row 0 at the top and column 0 at the left, from the orientation of the header."""
    orientation = spec.get_int_attribute("Orientation", 1)
    if orientation not in (2, 3, 4):
        return pixels
    notes.append(
        f"the image was rotated or mirrored by the orientation {orientation} of its header"
    )
    rows = -1 if orientation in (3, 4) else 1
    columns = -1 if orientation in (2, 3) else 1
    return np.ascontiguousarray(pixels[::rows, ::columns])


def _note_primaries(spec: oiio.ImageSpec, notes: list[str]) -> None:
    """Add a note on primaries other than Rec.709; Radiance headers hold zeros for none."""
    primaries = spec.getattribute("chromaticities")
    if primaries and any(primaries) and not np.allclose(primaries, REC709, atol=1e-3):
        notes.append("the file has primaries other than Rec.709; its values were not converted")


def failure(source: Any) -> str:
    """Reason for the last failure of OpenImageIO or one of its files."""
    try:
        message = source.geterror()
    except UnicodeDecodeError:  # it repeats the bytes of a damaged header
        return "its header is damaged"
    lines = [_printable(line.strip()) for line in message.splitlines()]
    return "; ".join(filter(None, lines)).rstrip(".?") or "OpenImageIO gives no reason"


def _printable(text: str) -> str:
    """`text` on one line, with other characters escaped."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)
