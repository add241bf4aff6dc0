"""The door for image files: each step of reading, in its order; one picture, or six of a cube."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import count, describe
from envlights._common.errors import FileError
from envlights._common.printable import printable
from envlights._common.units import OWN_SCALE, PHOTOMETRIC
from envlights._native import EnvLightsError
from envlights.environment.clip_level import CodeHistogram, white_of
from envlights.environment.colour.alpha import seen_of_alpha, straight_codes, visible
from envlights.environment.colour.choice import ColourArgument, ColourConversion, conversion
from envlights.environment.colour.linear import Linear
from envlights.environment.decoders.native import open_png, open_radiance
from envlights.environment.decoders.openimageio import check_size, open_with_openimageio
from envlights.environment.decoders.raw_image import ImageFile, RawImage
from envlights.environment.decoders.source import (
    AnySource,
    Source,
    is_source,
    kind_of,
    name_of,
    named_source,
)
from envlights.environment.files.channels import Choice, choose
from envlights.environment.files.hints import NO_HINTS, Hints
from envlights.environment.files.placement import Placement, placement
from envlights.environment.layouts.cubes import check_square, order_of_names

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

    clip_level: float | None = None
    """Clip level of the samples; None for floating point."""

    coverage: NDArray[np.float32] | None = None
    """Share of each pixel that the file shows, (height, width); None if all is seen."""

    hints: Hints = NO_HINTS
    """Statements of the file about its projection."""

    units: str = OWN_SCALE
    """Unit of the pixels; see `EnvMap.units`."""

    ev100: float | None = None
    """Exposure value at ISO 100 of a single exposure; None if unknown."""


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
        # Names of channels and colour spaces may hold any characters.
        return tuple(map(printable, (*notes, *self.place.notes)))

    @property
    def hints(self) -> Hints:
        """Statements of the file about its projection."""
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
        """First row, colours and alpha of some rows at a time, in the type of the file."""
        height, step = self.raw.header.height, self.raw.rows_at_once
        count = len(self.choice.colours)
        for top in range(0, height, step):
            samples = self.raw.rows(top, min(top + step, height))
            yield top, samples[..., :count], samples[..., count:]

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
        linear = Linear(header, self.colour)
        histogram = CodeHistogram(header.height) if header.dtype.kind == "u" else None
        size = (header.height, header.width)
        pixels, shares = _Rows((*size, 3)), _Rows(size, 1.0)
        for top, colours, alpha in self.samples():
            if histogram:
                histogram.add(visible(colours, alpha), top)
            block, fraction = self._block(linear, colours, alpha)
            pixels.add(top, block)
            shares.add(top, fraction)
        clip_level, notes = self._clip_level(histogram, pixels.whole)
        coverage = shares.whole
        if coverage is not None and not coverage.any():
            self._check_alpha()
            coverage = None
        if coverage is None and self.place.crop:
            coverage = np.ones(size, np.float32)
        return Image(
            self.place.apply(pixels.whole),
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
        """Clip level, and a note on one that only the histogram shows."""
        if self.raw.header.has_gain_map:
            return float(pixels.max(initial=0)) or None, []
        if histogram is None:
            return self.colour.clip_level, []
        return white_of(histogram, self.colour.table(8 * self.raw.header.dtype.itemsize))

    def _check_alpha(self) -> None:
        """Refuse a file whose alpha is 0 everywhere; straight alpha would hide all pixels."""
        if self.raw.header.alpha == "straight":
            raise FileError(
                f"cannot read {self.name}: alpha is 0 in all pixels, so that nothing is seen;"
                f" leave it out with channels={','.join(self.choice.colours)!r}"
            )


class _Rows:
    """Array that is filled block by block; one block of all rows is taken as it is."""

    def __init__(self, shape: tuple[int, ...], default: float | None = None) -> None:
        self._shape, self._default = shape, default
        self.whole: Any = None

    def add(self, top: int, block: NDArray[np.float32] | None) -> None:
        """Set the rows from `top` on; rows without a block keep the default, if there is one."""
        if block is None:
            return
        if block.shape == self._shape:
            self.whole = block
            return
        if self.whole is None:
            self.whole = np.empty(self._shape, np.float32)
            if self._default is not None:
                self.whole.fill(self._default)
        self.whole[top : top + len(block)] = block


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
    """Open file as `read_image` reads it, for callers who take its rows one by one."""
    count("max_pixels", max_pixels, least=1)
    named = named_source(source)
    kind = kind_of(named, any_format=any_format)
    with _reader(named, kind, max_pixels) as file:
        choice = choose(named.name, file.parts, part, channels)
        names = (*choice.colours, choice.alpha) if choice.alpha else choice.colours
        raw = file.image(choice.part, names)
        place = placement(raw.header)
        check_size(named.name, *place.size, max_pixels)
        opened = OpenImage(named.name, raw, choice, conversion(raw.header, colour), place)
        if not any_projection:
            _check_projection(opened.hints)
        yield opened


def _check_projection(hints: Hints) -> None:
    """Refuse a picture whose metadata name a projection other than equirectangular."""
    if other := hints.names_other_projection:
        raise FileError(
            f"cannot read {hints.name}: its metadata name the projection {other}; give an"
            " equirectangular map"
        )


@contextlib.contextmanager
def _reader(named: Source, kind: str, max_pixels: int) -> Iterator[ImageFile]:
    """Open file by the reader of its kind."""
    if kind == "radiance":
        yield open_radiance(named, max_pixels)
    elif kind == "png":
        yield open_png(named, max_pixels)
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


def whole_image(file: OpenImage) -> Image:
    """All pixels of an open file, or a refusal of too many."""
    try:
        return file.image()
    except MemoryError:
        raise FileError(
            f"cannot read {file.name}: its pixels do not fit into memory; give a smaller map"
        ) from None


#: Suffixes of the files of a folder that are faces.
_SUFFIXES = {".hdr", ".exr", ".png", ".jpg", ".jpeg", ".tif", ".tiff", ".pic", ".rgbe"}
#: Parts of a pattern that stand for the name of a face; "%" is of exrenvmap.
_WILDCARDS = ("{face}", "%", "*")

#: One file, or six: a sequence, a mapping from names to files, a folder, or a name with "{face}",
#: "*" or "%".
PictureSource: TypeAlias = AnySource | Sequence[AnySource] | Mapping[str, AnySource]


class _Files(NamedTuple):
    """Six files, their names without suffixes, and a common name."""

    name: str
    stems: list[str]
    files: list[AnySource]


def is_picture_source(value: Any) -> bool:
    """True for anything that is read as a file, or as six files of a cube."""
    if isinstance(value, Mapping):
        return bool(value) and all(map(is_source, value.values()))
    if isinstance(value, list | tuple):
        return bool(value) and all(map(is_source, value))
    return is_source(value)


def read_picture(source: Any, **options: Any) -> Image:
    """Read one picture in any projection, or six as the stack of the faces of a cube.

    Parameters
    ----------
    source : path-like, bytes, file object, sequence, or mapping
        One file, as in `read_image`; a sequence or a mapping of six; a folder with six pictures; or
        a name with ``{face}``, ``*`` or ``%``, which matches six files.
    **options
        Options of `read_image`.

    Returns
    -------
    Image
        Of six files, the pixels are (6 n, n, 3) in the order that ``hints.order`` names. It is
        empty if the names do not determine one, and then the order is that of the source.

    Raises
    ------
    EnvLightsError
        If a file cannot be read, or there are not six squares of one size.
    """
    files = _six_files(source)
    if files is None:
        return read_image(source, any_projection=True, **options)
    order, positions = _order(files)
    most = count("max_pixels", options.get("max_pixels", MOST_PIXELS), least=1)
    options["max_pixels"] = max(most // 6, 1)
    images = [read_image(files.files[place], **options) for place in positions]
    names = [name_of(files.files[place]) for place in positions]
    check_square(dict(zip(names, (image.pixels.shape[:2] for image in images), strict=True)))
    return _stack_of(files.name.split(": ")[0], order, images)


def faces_of_mapping(faces: Mapping[str, Any]) -> tuple[NDArray[Any], str]:
    """Six arrays by the names of their faces as one array, (6, n, n, ...), and its order.

    Parameters
    ----------
    faces : mapping
        Arrays by names like "px", "posx", "front" or "F", as py360convert gives them.

    Raises
    ------
    EnvLightsError
        If the names are of no convention, or the arrays are no squares of one size.
    """
    stems, arrays = [str(key) for key in faces], [np.asarray(face) for face in faces.values()]
    named = order_of_names(stems) if len(stems) == 6 else None
    if named is None:
        raise EnvLightsError(_no_order("a mapping", stems))
    each = zip(stems, arrays, strict=True)
    check_square({stem: (*array.shape, 0, 0)[:2] for stem, array in each})
    return np.stack([arrays[place] for place in named.positions]), named.order


def _six_files(source: Any) -> _Files | None:
    """Six files of a source; None for one file."""
    if isinstance(source, Mapping):
        return _six_of("the mapping", [str(key) for key in source], list(source.values()))
    if isinstance(source, str | os.PathLike):
        return _files_of_path(os.fspath(source))
    if isinstance(source, bytes | bytearray | memoryview) or hasattr(source, "read"):
        return None
    if isinstance(source, Sequence):
        return _six_of("the list", [_stem(file) for file in source], list(source))
    return None


def _files_of_path(text: str | bytes) -> _Files | None:
    """Six files of a folder or of a pattern; None for the path of one file."""
    text = os.fsdecode(text)
    if not text or "\0" in text:
        return None
    try:
        path = Path(text)
        if path.is_dir():
            each = sorted(file for file in path.iterdir() if file.suffix.lower() in _SUFFIXES)
        elif any(mark in path.name for mark in _WILDCARDS) and not path.exists():
            each = sorted(path.parent.glob(_pattern(path.name)))
        else:
            return None
    except (OSError, ValueError):  # a name that is too long, or a folder that is not readable
        return None
    if not each and not path.is_dir() and "{face}" not in text:
        return None  # a missing file whose name holds % or *
    name = f"{text}: it is a folder, which" if path.is_dir() else f"{text}: the pattern"
    return _six_of(name, [file.stem for file in each], list(each))


def _pattern(name: str) -> str:
    """Pattern of `Path.glob`, whose other special characters are those of the name."""
    marked = name
    for mark in _WILDCARDS:
        marked = marked.replace(mark, "\0")
    return marked.replace("[", "[[]").replace("?", "[?]").replace("\0", "*")


def _six_of(name: str, stems: list[str], files: list[AnySource]) -> _Files:
    if len(files) != 6:
        some = f" ({', '.join(stems[:6])}{', ...' if len(stems) > 6 else ''})" if any(stems) else ""
        raise FileError(
            f"cannot read {name} holds {len(files)} pictures{some}, and a cube map has six faces;"
            " give one file, or six as a list, a mapping, a folder, or a name such as"
            " 'sky_{face}.hdr'"
        )
    return _Files(name, stems, files)


def _stem(file: Any) -> str:
    """Name of a file without folder and suffix; empty for bytes."""
    return Path(os.fsdecode(file)).stem if isinstance(file, str | os.PathLike) else ""


def _order(files: _Files) -> tuple[str, tuple[int, ...]]:
    """Convention that the names determine, and the position of each of its faces."""
    named = order_of_names(files.stems)
    if named:
        return named.order, named.positions
    return "", tuple(range(6))


def _no_order(name: str, stems: list[str]) -> str:
    return (
        f"{name} of the faces of a cube has names such as px nx py ny pz nz, or front right back"
        f" left up down; got {describe(', '.join(stems[:8]))}"
    )


def _stack_of(name: str, order: str, images: list[Image]) -> Image:
    """Stack of six images, (6 n, n, 3)."""
    first = images[0]
    notes = dict.fromkeys(note for image in images for note in image.notes)
    coverage = None
    if any(image.coverage is not None for image in images):
        coverage = np.concatenate([_share(image) for image in images])
    return replace(
        first,
        pixels=np.concatenate([image.pixels for image in images]),
        border_sampled=False,
        notes=tuple(notes),
        clip_level=_clip_level(images),
        coverage=coverage,
        ev100=first.ev100 if len({image.ev100 for image in images}) == 1 else None,
        units=_units(images),
        hints=first.hints._replace(name=name, order=order, border_sampled=False, layout=""),
    )


def _units(images: list[Image]) -> str:
    """Unit of all images, or a refusal of several units."""
    units = {image.units for image in images}
    if len(units) > 1:
        raise EnvLightsError(
            "the faces of a cube must have one scale; some files have luminance in cd/m2"
            " (whiteLuminance), others do not; give files of one origin"
        )
    return units.pop()


def _share(image: Image) -> NDArray[np.float32]:
    return np.ones(image.pixels.shape[:2], np.float32) if image.coverage is None else image.coverage


def _clip_level(images: list[Image]) -> float | None:
    """Lowest clip level; None if one of the faces has none."""
    known = [image.clip_level for image in images if image.clip_level is not None]
    return min(known) if len(known) == len(images) else None
