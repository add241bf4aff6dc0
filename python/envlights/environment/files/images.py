"""Entry point for image files: the steps of reading, in order."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import count
from envlights._common.errors import FileError
from envlights._common.printable import printable
from envlights._common.units import OWN_SCALE, PHOTOMETRIC
from envlights._native import EnvLightsError
from envlights.environment.clip_level import CodeHistogram, white_of
from envlights.environment.colour.alpha import seen_of_alpha, straight_codes, visible
from envlights.environment.colour.choice import ColourArgument, ColourConversion, conversion
from envlights.environment.colour.linear import Linear
from envlights.environment.decoders.native import KINDS, open_native
from envlights.environment.decoders.openimageio import open_with_openimageio
from envlights.environment.decoders.raw_image import Header, ImageFile, RawImage, check_size
from envlights.environment.decoders.source import AnySource, Source, kind_of, named_source
from envlights.environment.files.channels import Choice, choose
from envlights.environment.files.hints import NO_HINTS, Hints
from envlights.environment.files.placement import Placement, placement
from envlights.environment.files.whole_numbers import WholeNumbers

#: Default limit on the number of pixels, 32768 x 16384, because a damaged header may claim any
#: size.
MOST_PIXELS = 2**29


@dataclass(frozen=True, eq=False)
class Image:
    """Content of a file."""

    pixels: NDArray[np.float32]
    """Linear Rec.709, (height, width, 3), black where not visible."""

    border_sampled: bool
    """True if the metadata puts the outer pixels on the seam and the poles."""

    notes: tuple[str, ...]
    """Notes on assumptions and on ignored content."""

    clip_level: float | None = None
    """Clip level of the samples; None for floating-point samples."""

    coverage: NDArray[np.float32] | None = None
    """Coverage of each pixel, 0 to 1, (height, width); None if complete."""

    hints: Hints = NO_HINTS
    """Metadata on the projection."""

    units: str = OWN_SCALE
    """Unit of the pixels; see `EnvMap.units`."""

    ev100: float | None = None
    """Exposure value at ISO 100 of a single exposure; None if unknown."""


@dataclass(frozen=True)
class OpenImage:
    """Open file with channels, colour and placement chosen; read by rows or as a whole."""

    name: str
    """Printable name of the file."""

    raw: RawImage
    """Header and samples of the chosen channels."""

    choice: Choice
    """Part and channels."""

    colour: ColourConversion
    """Conversion to linear Rec.709."""

    place: Placement
    """Placement on the whole sphere."""

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes of all steps."""
        notes = (*self.choice.notes, *self.raw.header.notes, *self.colour.notes)
        # Names of channels and colour spaces may contain any characters.
        return tuple(map(printable, (*notes, *self.place.notes)))

    @property
    def hints(self) -> Hints:
        """Metadata of the file on its projection."""
        header, view = self.raw.header, self.place.view
        return Hints(
            self.name,
            header.kind,
            header.environment,
            header.cube_sides,
            header.border_sampled,
            *view,
            layout=header.layout,
        )

    @property
    def units(self) -> str:
        """Unit of the linear samples."""
        return PHOTOMETRIC if self.raw.header.has_luminance else OWN_SCALE

    def samples(self) -> Iterator[tuple[int, NDArray[Any], NDArray[Any]]]:
        """Blocks of rows in the sample type of the file: index of the first row, colours, alpha."""
        height, step = self.raw.header.height, self.raw.rows_at_once
        count = len(self.choice.colours)
        for top in range(0, height, step):
            samples = self.raw.rows(top, min(top + step, height))
            yield top, samples[..., :count], samples[..., count:]

    def _pixels(
        self, linear: Linear, histogram: CodeHistogram | None
    ) -> tuple[NDArray[np.float32], NDArray[np.float32] | None]:
        """Linear samples of all rows, and the coverage from alpha, or None if complete."""
        header, coverage = self.raw.header, None
        size = (header.height, header.width)
        if header.dtype == np.float32 and header.alpha == "none":  # decoded in place
            return linear(self.raw.samples), None
        pixels = np.empty((*size, 3), np.float32)
        for top, colours, alpha in self.samples():
            rows = slice(top, top + len(colours))
            if histogram:
                histogram.add(visible(colours, alpha), top)
            fraction = self._block(linear, top, (colours, alpha), pixels[rows])
            if fraction is not None:
                coverage = np.ones(size, np.float32) if coverage is None else coverage
                coverage[rows] = fraction
        return pixels, coverage

    def _block(
        self,
        linear: Linear,
        top: int,
        samples: tuple[NDArray[Any], NDArray[Any]],
        out: NDArray[np.float32],
    ) -> NDArray[np.float32] | None:
        """Write linear samples of some rows into `out`; return their coverage from alpha."""
        header, (colours, alpha) = self.raw.header, samples
        if not alpha.shape[2] or header.alpha == "none":
            linear(colours, out, top)
            return None
        linear(straight_codes(colours, alpha[..., 0], header), out, top)
        return seen_of_alpha(out, alpha[..., 0], header)

    def image(self, *, is_face: bool = False) -> Image:
        """All pixels of the sphere; alpha of 0 everywhere hides a face, and is of no use else."""
        header = self.raw.header
        linear = Linear(header, self.colour, self.raw.apply_gain_map)
        histogram = CodeHistogram(header.height) if header.dtype.kind == "u" else None
        pixels, coverage = self._pixels(linear, histogram)
        clip_level, notes = self._clip_level(histogram, pixels)
        if header.dtype.kind == "f":
            notes += WholeNumbers().add(pixels).notes()
        if coverage is not None and not coverage.any() and not is_face:
            self._check_alpha()
            coverage = None
        if coverage is None and self.place.crop:
            coverage = np.ones((header.height, header.width), np.float32)
        return Image(
            self.place.apply(pixels),
            header.border_sampled,
            (*self.notes, *linear.notes, *notes),
            clip_level,
            None if coverage is None else self.place.apply(coverage, border=1),
            self.hints,
            self.units,
            header.ev100,
        )

    def _clip_level(
        self, histogram: CodeHistogram | None, pixels: NDArray[np.float32]
    ) -> tuple[float | None, list[str]]:
        """Clip level, and a note if it was found only in the histogram."""
        if self.raw.header.has_gain_map:
            return float(pixels.max(initial=0)) or None, []
        if histogram is None:
            return self.colour.clip_level, []
        return white_of(histogram, self.colour.table(8 * self.raw.header.dtype.itemsize))

    def _check_alpha(self) -> None:
        """Raise an error if straight alpha is 0 everywhere, because it would hide all pixels."""
        if self.raw.header.alpha == "straight":
            raise FileError(
                f"cannot read {self.name}: alpha is 0 in all pixels, so that nothing is seen;"
                f" leave it out with channels={','.join(self.choice.colours)!r}"
            )


@contextlib.contextmanager
def open_image(
    source: AnySource | Source,
    *,
    colour: ColourArgument | None = None,
    part: str | int | None = None,
    channels: str | Sequence[str] | None = None,
    max_pixels: int = MOST_PIXELS,
    any_format: bool = False,
    any_projection: bool = False,
) -> Iterator[OpenImage]:
    """Open file, prepared as for `read_image`, for callers who read it row by row."""
    count("max_pixels", max_pixels, least=1)
    named = named_source(source)
    kind = kind_of(named, any_format=any_format)
    with _reader(named, kind, max_pixels) as file:
        choice = choose(named.name, file.parts, part, channels)
        names = (*choice.colours, choice.alpha) if choice.alpha else choice.colours
        raw = file.image(choice.part, names)
        place = _placement(named.name, raw.header)
        check_size(named.name, *place.size, max_pixels)
        opened = OpenImage(named.name, raw, choice, conversion(raw.header, colour), place)
        if not any_projection:
            _check_projection(opened.hints)
        yield opened


def _placement(name: str, header: Header) -> Placement:
    """Placement of the samples; error messages get the name of the file."""
    try:
        return placement(header)
    except EnvLightsError as refusal:
        raise FileError(f"cannot read {name}: {refusal}") from None


def _check_projection(hints: Hints) -> None:
    """Raise an error if the metadata names a projection other than equirectangular."""
    if other := hints.names_other_projection:
        raise FileError(
            f"cannot read {hints.name}: its metadata name the projection {other}; give an"
            " equirectangular map"
        )


@contextlib.contextmanager
def _reader(named: Source, kind: str, max_pixels: int) -> Iterator[ImageFile]:
    """File opened by the reader of its kind."""
    if kind in KINDS:
        yield open_native(named, kind, max_pixels)
    else:
        with open_with_openimageio(named, kind, max_pixels) as file:
            yield file


def read_image(
    source: AnySource | Source,
    *,
    colour: ColourArgument | None = None,
    part: str | int | None = None,
    channels: str | Sequence[str] | None = None,
    max_pixels: int = MOST_PIXELS,
    any_format: bool = False,
    any_projection: bool = False,
) -> Image:
    """Read an image at full size, as linear Rec.709.

    Parameters
    ----------
    source : path-like, bytes or file object
        Radiance .hdr, OpenEXR, PNG, JPEG or TIFF; the first bytes decide. "-" is the standard
        input; addresses like ``s3://`` are read by fsspec, if it is installed.
    colour : str, bytes or path-like, optional
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
    any_projection : bool
        Read a cube, a cylinder and other projections as they are stored; `layouts.recognise`
        arranges them. False: refuse files whose metadata name one.

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
    options["any_projection"] = any_projection
    with open_image(source, **options) as file:
        return whole_image(file)


def whole_image(file: OpenImage, *, is_face: bool = False) -> Image:
    """All pixels of an open file; raises an error if they do not fit into memory."""
    try:
        return file.image(is_face=is_face)
    except MemoryError:
        raise FileError(
            f"cannot read {file.name}: its pixels do not fit into memory; give a smaller map"
        ) from None
