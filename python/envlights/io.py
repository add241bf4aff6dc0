"""Files in, by OpenImageIO: pixels as linear radiance, and what was assumed of them."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813, its own name for itself
from numpy.typing import NDArray

from envlights._native import EnvLightsError
from envlights.files import write_atomically

#: More pixels than this are a damaged header, not a map: 65536 x 32768.
_MOST_PIXELS = 2**31

#: Primaries and white of Rec.709, as OpenEXR stores them: x and y of red, green, blue, white.
_REC709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)


@dataclass(frozen=True, eq=False)
class Image:
    """What a file holds."""

    pixels: NDArray[np.float32]
    """Linear RGB, (height, width, 3)."""

    border_sampled: bool
    """Whether the file says that its outer pixels lie on the seam and the poles."""

    notes: tuple[str, ...]
    """What was assumed or left out."""


def read_image(path: str | os.PathLike[str]) -> Image:
    """Read the first image of a file at full size.

    Parameters
    ----------
    path : path-like
        Radiance .hdr, OpenEXR, PNG, JPEG, TIFF, or whatever else OpenImageIO reads.

    Returns
    -------
    Image
        Linear RGB. Files of 8 or 16 bit integers are taken as sRGB-coded.

    Raises
    ------
    EnvLightsError
        If the file is missing, damaged, or holds no RGB or grey image.
    """
    name = os.fspath(path)
    _check_file(name)
    # PNG alpha is stored beside the colour: left alone, OpenImageIO would multiply it in.
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    file = oiio.ImageInput.open(name, config)
    if file is None:
        raise EnvLightsError(f"cannot read {name} as an image: {_one_line(oiio.geterror())}")
    try:
        return _read(name, file)
    finally:
        file.close()


def _check_file(name: str) -> None:
    if not Path(name).exists():
        raise EnvLightsError(f"cannot read {name}: there is no such file")
    if Path(name).is_dir():
        raise EnvLightsError(f"cannot read {name}: it is a folder; give an image file")
    if Path(name).stat().st_size == 0:
        raise EnvLightsError(f"cannot read {name}: the file is empty")


def _read(name: str, file: oiio.ImageInput) -> Image:
    spec = file.spec()
    _check_spec(name, spec)
    channels, notes = _colour_channels(name, spec)
    pixels = file.read_image(0, 0, 0, spec.nchannels, oiio.FLOAT)
    if pixels is None or file.has_error:
        raise EnvLightsError(f"cannot read all pixels of {name}: {_one_line(file.geterror())}")
    pixels = np.ascontiguousarray(pixels[..., channels])
    if _is_coded(spec):
        pixels = decode_srgb(pixels)
        notes.append("integer samples were taken as sRGB-coded and linearised")
    pixels = _in_display_window(pixels, spec, notes)
    _note_primaries(spec, notes)
    return Image(pixels, bool(spec.getattribute("oiio:sampleborder")), tuple(notes))


def _check_spec(name: str, spec: oiio.ImageSpec) -> None:
    if spec.width * spec.height > _MOST_PIXELS:
        size = f"{spec.width}x{spec.height}"
        raise EnvLightsError(f"cannot read {name}: it claims to hold {size} pixels; is it damaged?")
    if spec.depth > 1:
        raise EnvLightsError(f"cannot read {name}: it is a volume of {spec.depth} slices")
    if "CubeFace" in (spec.getattribute("textureformat") or ""):
        raise EnvLightsError(f"cannot read {name}: it is a cube map; only equirectangular maps are")


def _colour_channels(name: str, spec: oiio.ImageSpec) -> tuple[list[int], list[str]]:
    """Numbers of the channels that are red, green and blue, and what is said about the others."""
    names = list(spec.channelnames)
    wanted = next(
        (rgb for rgb in (["R", "G", "B"], ["r", "g", "b"]) if set(rgb) <= set(names)), None
    )
    colours = [c for c in names if c not in {"A", "Z"} and c != "Alpha"]
    notes = []
    if wanted is None and len(colours) == 1:
        wanted = colours * 3
        notes.append(f"the only channel, {colours[0]}, was taken as grey")
    elif wanted is None:
        raise EnvLightsError(
            f"{name} has the channels {', '.join(names)}; R, G, B or one is needed"
        )
    ignored = [channel for channel in names if channel not in wanted]
    if "A" in ignored:
        notes.append("alpha was ignored")
    if others := [channel for channel in ignored if channel != "A"]:
        notes.append(f"other channels were ignored: {', '.join(others)}")
    return [names.index(channel) for channel in wanted], notes


def _is_coded(spec: oiio.ImageSpec) -> bool:
    return spec.format.basetype in (oiio.UINT8, oiio.UINT16)


def decode_srgb(coded: NDArray[np.floating]) -> NDArray[np.float32]:
    """Linear values of sRGB-coded ones in 0 .. 1 (IEC 61966-2-1)."""
    coded = np.asarray(coded, dtype=np.float64)
    linear = np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)
    return linear.astype(np.float32)


def _in_display_window(
    pixels: NDArray[np.float32], spec: oiio.ImageSpec, notes: list[str]
) -> NDArray[np.float32]:
    """Pixels of the display window: the data window in its place, black around it."""
    data = (spec.x, spec.y, spec.width, spec.height)
    display = (spec.full_x, spec.full_y, spec.full_width, spec.full_height)
    if data == display:
        return pixels
    if display[2] * display[3] > _MOST_PIXELS:
        raise EnvLightsError(f"the display window of {display[2]}x{display[3]} pixels is too large")
    notes.append(
        f"the data window {data} was set into the display window {display}, black around it"
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


def _note_primaries(spec: oiio.ImageSpec, notes: list[str]) -> None:
    """Say where the file names other primaries; the zeros of Radiance headers name none."""
    primaries = spec.getattribute("chromaticities")
    if primaries and any(primaries) and not np.allclose(primaries, _REC709, atol=1e-3):
        notes.append(
            "the file names primaries other than Rec.709; its values were kept as they are"
        )


def _one_line(message: str) -> str:
    return "; ".join(message.split("\n")) or "OpenImageIO gives no reason"


def write_exr(path: str | os.PathLike[str], radiance: NDArray[np.float32]) -> None:
    """Write linear RGB, (height, width, 3), as a 32-bit OpenEXR file, whole or not at all."""
    height, width, channels = radiance.shape
    spec = oiio.ImageSpec(width, height, channels, oiio.FLOAT)

    def write(beside: Path) -> None:
        file = oiio.ImageOutput.create(str(beside))
        done = file and file.open(str(beside), spec) and file.write_image(radiance) and file.close()
        if not done:
            raise OSError(_one_line(file.geterror() if file else oiio.geterror()))

    write_atomically(path, write)
