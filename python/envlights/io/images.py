"""The door for image files: each step of reading, in its order."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._check import count
from envlights._native import EnvLightsError
from envlights.io import png
from envlights.io.alpha import seen_of_alpha, straight_codes
from envlights.io.channels import Choice, choose
from envlights.io.colour import ColourConversion, conversion
from envlights.io.errors import DamagedFileError
from envlights.io.linear import Linear
from envlights.io.openimageio import check_size, open_with_openimageio
from envlights.io.placement import Placement, placement
from envlights.io.raw_image import ImageFile, RawImage
from envlights.io.signature import kind_of
from envlights.io.source import WANTED, AnySource, Source, named_source

#: Largest number of pixels, 32768 x 16384, unless a caller allows more, because a damaged header
#: may claim any number.
MOST_PIXELS = 2**29

#: Primaries and white of Rec.709, as OpenEXR stores them: x and y of red, green, blue, white.
REC709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)


@dataclass(frozen=True, eq=False)
class Image:
    """Content of a file."""

    pixels: NDArray[np.float32]
    """Linear Rec.709, (height, width, 3), black where nothing is seen."""

    border_sampled: bool
    """True if the metadata puts the outer pixels on the seam and the poles."""

    notes: tuple[str, ...]
    """Remarks on assumptions and on ignored content."""

    white: float | None = None
    """Clip level of the samples; None for floating point."""

    seen: NDArray[np.float32] | None = None
    """Share of each pixel that the file shows, (height, width); None if all is seen."""


@dataclass(frozen=True)
class OpenImage:
    """An open file, all decisions about it taken; its pixels are read by rows or as a whole."""

    name: str
    """Printable name of the file."""

    raw: RawImage
    """Header, and the samples of the chosen channels."""

    choice: Choice
    """Part and channels."""

    colour: ColourConversion
    """Steps to linear Rec.709."""

    place: Placement
    """Steps to the whole sphere."""

    @property
    def notes(self) -> tuple[str, ...]:
        """Remarks of all steps."""
        notes = (*self.choice.notes, *self.raw.header.notes, *self.colour.notes)
        return (*notes, *self.place.notes)

    def blocks(self) -> Iterator[tuple[int, NDArray[np.float32], NDArray[np.float32] | None]]:
        """First row, linear Rec.709 and seen share of some rows at a time, as the file has them."""
        linear, count = Linear(self.raw.header, self.colour), len(self.choice.colours)
        height, step = self.raw.header.height, self.raw.rows_at_once
        for top in range(0, height, step):
            samples = self.raw.rows(top, min(top + step, height))
            yield top, *self._block(linear, samples[..., :count], samples[..., count:])

    def _block(
        self, linear: Linear, colours: NDArray[Any], alpha: NDArray[Any]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32] | None]:
        header = self.raw.header
        if not alpha.shape[2] or header.alpha == "none":
            return linear(colours), None
        block = linear(straight_codes(colours, alpha[..., 0], header))
        return block, seen_of_alpha(block, alpha[..., 0], header)

    def image(self) -> Image:
        """All pixels of the sphere."""
        header = self.raw.header
        pixels = np.empty((header.height, header.width, 3), np.float32)
        seen = None
        for top, block, share in self.blocks():
            pixels[top : top + len(block)] = block
            if share is not None:
                seen = np.ones(pixels.shape[:2], np.float32) if seen is None else seen
                seen[top : top + len(block)] = share
        if seen is not None and not seen.any():
            pixels, seen = self._without_alpha(pixels)
        if seen is None and self.place.crop:
            seen = np.ones(pixels.shape[:2], np.float32)
        white = float(pixels.max(initial=0)) if header.has_gain_map else self.colour.white
        return Image(
            self.place.apply(pixels),
            header.border_sampled,
            self.notes,
            white or None,
            None if seen is None else self.place.apply(seen, border=1),
        )

    def _without_alpha(
        self, pixels: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32] | None]:
        """Pixels of a file whose alpha is 0 everywhere; straight alpha would hide all of them."""
        if self.raw.header.alpha == "straight":
            raise EnvLightsError(
                f"cannot read {self.name}: alpha is 0 in all pixels, so that nothing is seen;"
                f" leave it out with channels={','.join(self.choice.colours)!r}"
            )
        return pixels, None


@contextlib.contextmanager
def open_image(
    source: AnySource,
    *,
    colour: str | None = None,
    part: str | int | None = None,
    channels: str | Sequence[str] | None = None,
    max_pixels: int = MOST_PIXELS,
    any_format: bool = False,
) -> Iterator[OpenImage]:
    """Open file as `read_image` reads it, for callers who take its rows one by one."""
    count("max_pixels", max_pixels, least=1)
    named = named_source(source)
    kind = kind_of(named, any_format=any_format)
    with _reader(named, kind, max_pixels) as file:
        choice = choose(named.name, file.parts, part, channels)
        names = (*choice.colours, choice.alpha) if choice.alpha else choice.colours
        raw = file.image(choice.part, names)
        place = placement(named.name, raw.header)
        check_size(named.name, *place.size, max_pixels)
        yield OpenImage(named.name, raw, choice, conversion(raw.header, colour), place)


@contextlib.contextmanager
def _reader(named: Source, kind: str, max_pixels: int) -> Iterator[ImageFile]:
    """Open file by the reader of its kind."""
    if kind == "png":
        with named.path_with(".png") as path:
            if obstacle := png.damage(path):
                raise DamagedFileError(f"cannot read {named.name}: {obstacle}; {WANTED}")
    with open_with_openimageio(named, kind, max_pixels) as file:
        if kind == "png":
            with named.path_with(".png") as path:
                if obstacle := png.damage_of_pixels(path):
                    raise DamagedFileError(f"cannot read {named.name}: {obstacle}; {WANTED}")
        yield file


def read_image(
    source: AnySource,
    *,
    colour: str | None = None,
    part: str | int | None = None,
    channels: str | Sequence[str] | None = None,
    max_pixels: int = MOST_PIXELS,
    any_format: bool = False,
) -> Image:
    """Read an image at full size, as linear Rec.709.

    Parameters
    ----------
    source : path-like, bytes or file object
        Radiance .hdr, OpenEXR, PNG, JPEG or TIFF, told by the first bytes. "-" is the standard
        input; addresses like ``s3://`` are read by fsspec, if it is installed.
    colour : str, optional
        Colour space of the samples, instead of what the file says.
    part : str or int, optional
        Name of a part or layer, or number of a part from 0. When left out, the finished picture
        ("beauty") is found by its name.
    channels : str or sequence of str, optional
        Names of red, green and blue, or of one grey channel, then perhaps alpha.
    max_pixels : int
        Files with more pixels are refused before memory is allocated.
    any_format : bool
        Try all formats of OpenImageIO on other files. Do not set it for files of strangers.

    Returns
    -------
    Image
        Linear Rec.709, with notes on everything that was converted or ignored.

    Raises
    ------
    MissingFileError
        If there is no such file.
    DamagedFileError
        If the content contradicts the format.
    EnvLightsError
        If the file is too large, of another kind, or holds no RGB or grey image.
    """
    options: dict[str, Any] = {"colour": colour, "part": part, "channels": channels}
    options |= {"max_pixels": max_pixels, "any_format": any_format}
    with open_image(source, **options) as file:
        try:
            return file.image()
        except MemoryError:
            raise EnvLightsError(
                f"cannot read {file.name}: its pixels do not fit into memory; give a smaller map"
            ) from None
