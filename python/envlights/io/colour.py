"""Conversion of samples to linear Rec.709: choice among the statements of a file, and its use.

| file              | statement that counts                                             |
|-------------------|-------------------------------------------------------------------|
| OpenEXR, Radiance | linear, with the primaries that the header names                  |
| PNG               | cICP, else the ICC profile, else sRGB, else gAMA and cHRM (PNG 3) |
| others            | the ICC profile, else EXIF, else a name of OpenImageIO            |
| none of these     | integers are sRGB, floating point is linear Rec.709               |

EXIF and names describe integers: programs copy them from a camera's picture to linear floats.
"""

from __future__ import annotations

import os
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._check import describe
from envlights._native import EnvLightsError
from envlights.io import colour_spaces, icc, primaries
from envlights.io.colour_spaces import Space
from envlights.io.raw_image import Header
from envlights.io.transfer_curves import Curve

#: Colour space by hand: a name of `colour_spaces.NAMES`, or an ICC profile as path or bytes.
ColourArgument = str | bytes | os.PathLike[str]

#: Formats of linear samples, whatever other statements are in the file.
_LINEAR_KINDS = {"openexr", "radiance"}

#: Exponents of gAMA beyond which the chunk is wrong.
_EXPONENTS = (0.1, 10.0)

#: Rows of a block of floating point samples, whose curve needs memory for double precision.
_ROWS_AT_ONCE = 64

#: Way out of a refusal.
_BY_HAND = 'name the colour space, such as colour="srgb" or colour="linear"'

#: Spaces of integers and of floating point without a statement.
_SRGB, _LINEAR = colour_spaces.SRGB, colour_spaces.LINEAR


class ColourConversion(NamedTuple):
    """Steps from samples to linear Rec.709."""

    curve: Curve | None
    """Linear values of codes from 0 to 1, (..., 3); None for samples that are linear."""

    matrix: NDArray[np.float64] | None
    """Linear RGB of the file to linear Rec.709, (3, 3); None for Rec.709."""

    white: float | None
    """Linear value of the largest code; None for floating point."""

    notes: tuple[str, ...]
    """Remarks on what is converted."""

    def table(self, bits: int) -> NDArray[np.float32]:
        """Linear value of each code, (n,), or (3, n) if the channels have different curves."""
        codes = np.arange(1 << bits) / ((1 << bits) - 1)
        return self._values(codes)

    def _values(self, codes: NDArray[np.float64]) -> NDArray[np.float32]:
        """Linear values of (n,) codes: (n,), or (3, n) if the channels have different curves."""
        if self.curve is None:
            return codes.astype(np.float32)
        with np.errstate(all="ignore"):
            values = self.curve(np.repeat(codes[:, None], 3, axis=1)).astype(np.float32).T
        values = np.ascontiguousarray(values)
        is_one = np.array_equal(values[[0, 0]], values[1:], equal_nan=True)
        return values[0] if is_one else values


def conversion(header: Header, colour: ColourArgument | None) -> ColourConversion:
    """Conversion that a file asks for, or that of `colour`.

    Raises
    ------
    EnvLightsError
        If `colour` is unknown, the file names a space that cannot be converted, or an ICC profile
        is damaged.
    """
    is_integer = header.dtype.kind != "f"
    space = _space_of(header) if colour is None else _space_by_hand(colour)
    notes = [*_notes(space, is_integer), *space.notes]
    unchecked = ColourConversion(space.curve, space.matrix, None, tuple(notes))
    if not is_integer:
        return unchecked
    return unchecked._replace(white=float(unchecked.table(8)[..., -1].max()))


def _notes(space: Space, is_integer: bool) -> list[str]:
    """Remarks on the curve and the primaries; the conversion of sRGB codes is one, too."""
    samples = "integer" if is_integer else "floating point"
    notes = []
    if space.curve_name:
        notes.append(f"{samples} samples were decoded from {space.curve_name}")
    elif is_integer:
        notes.append("integer samples were read as linear")
    if space.primaries_name:
        notes.append(f"colours were converted from {space.primaries_name} to Rec.709")
    return notes


def _space_by_hand(colour: ColourArgument) -> Space:
    if isinstance(colour, str) and (space := colour_spaces.by_name(colour)):
        return space
    try:
        return _space_of_profile(_profile_bytes(colour))
    except icc.UnusedProfileError as reason:
        raise EnvLightsError(f"colour cannot be used: {reason}; {_BY_HAND}") from None


def _profile_bytes(colour: object) -> bytes:
    """Bytes of a profile by hand."""
    if isinstance(colour, bytes):
        return colour
    if isinstance(colour, str | os.PathLike):
        try:
            path = Path(colour)
            if path.is_file():
                with path.open("rb") as file:
                    return file.read(icc.MOST_BYTES + 1)
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise EnvLightsError(f"cannot read the profile {colour!r}: {reason}") from None
    names = ", ".join(f'"{name}"' for name in colour_spaces.NAMES)
    raise EnvLightsError(
        f"colour must be {names}, or an ICC profile (a path or bytes); got {describe(colour)}"
    )


def _space_of(header: Header) -> Space:
    """Space of a file, by the first of its statements that counts."""
    said = header.colour
    is_integer = header.dtype.kind != "f"
    default = _SRGB if is_integer else _LINEAR
    if header.kind in _LINEAR_KINDS:
        return _with_primaries(_LINEAR, header)
    if said.cicp and said.cicp[1] != colour_spaces.UNSPECIFIED:
        return _space_of_cicp(said.cicp, header)
    if said.icc:
        return _space_of_embedded(said.icc, default)
    if said.is_srgb and is_integer:
        return _SRGB
    if said.gamma is not None or said.chromaticities:
        return _with_primaries(_with_gamma(default, said.gamma), header)
    return _space_of_name(said.name, default, is_integer) if said.name else default


def _space_of_cicp(cicp: tuple[int, int, int, int], header: Header) -> Space:
    # Other formats than PNG widen the range of video themselves.
    is_full = cicp[3] if header.kind == "png" else 1
    space = colour_spaces.by_cicp((*cicp[:3], is_full), 8 * header.dtype.itemsize)
    if space is None:
        raise EnvLightsError(
            f"the colour space has the codes {cicp} of ITU-T H.273 (cICP), which are not"
            f" supported; {_BY_HAND}"
        )
    return space


def _space_of_embedded(data: bytes, default: Space) -> Space:
    """Space of the profile in a file, or the default if the profile is of a kind without use."""
    try:
        return _space_of_profile(data)
    except icc.UnusedProfileError as reason:
        assumed = default.curve_name or "linear Rec.709"
        return default._replace(notes=(f"{reason}; {assumed} was assumed",))


def _space_of_profile(data: bytes) -> Space:
    """Space of a profile, or a refusal of damaged bytes."""
    try:
        profile = icc.parse(data)
    except icc.UnusedProfileError:
        raise
    except ValueError as reason:
        raise EnvLightsError(f"the ICC profile is damaged: {reason}; {_BY_HAND}") from None
    name = f"the ICC profile '{profile.name}'" if profile.name else "the ICC profile"
    if profile.cicp:
        space = colour_spaces.by_cicp((*profile.cicp[:3], 1), 8)
        if space is None:
            raise EnvLightsError(
                f"{name} has the codes {profile.cicp} of ITU-T H.273, which are not supported;"
                f" {_BY_HAND}"
            )
        return space
    curve_name = "" if profile.curve is None else f"the curve of {name}"
    curve_name = _SRGB.curve_name if profile.curve is _SRGB.curve else curve_name
    return Space(profile.curve, profile.matrix, curve_name, "" if profile.matrix is None else name)


def _with_gamma(space: Space, gamma: float | None) -> Space:
    """`space` with the curve of a PNG gAMA chunk."""
    if gamma is None:
        return space
    if not _EXPONENTS[0] <= gamma <= _EXPONENTS[1]:
        return space._replace(notes=(f"the exponent {gamma:.3g} of the gAMA chunk was ignored",))
    curve, words = colour_spaces.power(1 / gamma)
    return space._replace(curve=curve, curve_name=words)


def _with_primaries(space: Space, header: Header) -> Space:
    """`space` with the primaries that the header names."""
    said = header.colour.chromaticities
    if header.colour.is_xyz:
        return space._replace(matrix=primaries.xyz_to_rec709(), primaries_name="CIE XYZ")
    if said is None or primaries.are_unsaid(said):
        return space
    try:
        other = colour_spaces.linear(said, "the primaries of the file")
    except ValueError as reason:
        note = f"the primaries of the file were ignored: {reason}"
        return space._replace(notes=(*space.notes, note))
    return space._replace(matrix=other.matrix, primaries_name=other.primaries_name)


def _space_of_name(name: str, default: Space, is_integer: bool) -> Space:
    """Space with a name of OpenImageIO; of floating point, only one that is linear counts."""
    space = colour_spaces.by_openimageio_name(name)
    if space is None:
        assumed = default.curve_name or "linear Rec.709"
        return default._replace(
            notes=(f"the colour space '{name}' is unknown; {assumed} was assumed",)
        )
    return space if is_integer or space.curve is None else default


class ColourConverter:
    """Conversion of blocks of rows, which counts the pixels outside Rec.709."""

    def __init__(self, steps: ColourConversion) -> None:
        self._steps = steps
        self._matrix = None if steps.matrix is None else steps.matrix.tolist()
        self._pixels = 0
        self._outside = 0

    def __call__(self, samples: NDArray[Any]) -> NDArray[np.float32]:
        """Linear Rec.709 of (rows, width, 3) samples; floats without a conversion are not copied.

        Negative results of the matrix become 0.
        """
        linear = self._linear(samples)
        if self._matrix is None:
            return linear
        converted, outside = _native.apply_matrix(linear, self._matrix)
        self._outside += outside
        self._pixels += linear.shape[0] * linear.shape[1]
        return converted

    @property
    def notes(self) -> tuple[str, ...]:
        """Remarks on the conversion, and the share of the converted pixels outside Rec.709."""
        if not self._outside:
            return self._steps.notes
        share = f"{100 * self._outside / self._pixels:.2g} %"
        note = f"{share} of the pixels lay outside Rec.709; their negative channels became 0"
        return (*self._steps.notes, note)

    def _linear(self, samples: NDArray[Any]) -> NDArray[np.float32]:
        """Linear values of samples with the primaries of the file."""
        kind, size = samples.dtype.kind, samples.dtype.itemsize
        if kind == "u":
            table = self._table_8 if size == 1 else self._table_16
            return _decode(samples, table)
        if self._steps.curve is None:
            return np.ascontiguousarray(samples, np.float32)
        if size == 2:
            return _decode(np.ascontiguousarray(samples).view(np.uint16), self._table_half)
        return self._through_curve(samples)

    def _through_curve(self, samples: NDArray[Any]) -> NDArray[np.float32]:
        """Values of the curve for floating point samples, in blocks of rows."""
        curve = self._steps.curve
        assert curve is not None
        linear = np.empty(samples.shape, np.float32)
        for top in range(0, len(samples), _ROWS_AT_ONCE):
            rows = slice(top, top + _ROWS_AT_ONCE)
            with np.errstate(all="ignore"):
                linear[rows] = curve(samples[rows].astype(np.float64))
        return linear

    @cached_property
    def _table_8(self) -> NDArray[np.float32]:
        return self._steps.table(8)

    @cached_property
    def _table_16(self) -> NDArray[np.float32]:
        return self._steps.table(16)

    @cached_property
    def _table_half(self) -> NDArray[np.float32]:
        """Linear value of each bit pattern of half precision."""
        halves = np.arange(1 << 16, dtype=np.uint16).view(np.float16)
        return self._steps._values(halves.astype(np.float64))


def _decode(codes: NDArray[Any], table: NDArray[np.float32]) -> NDArray[np.float32]:
    """Values of (rows, width, 3) codes of 8 or 16 bits in a table, (n,) or (3, n)."""
    if codes.dtype.itemsize == 1:
        codes = np.ascontiguousarray(codes, np.uint8)
        if table.ndim == 1:
            return _native.decode_8(codes, table)
        return _native.decode_channels_8(codes, (table[0], table[1], table[2]))
    codes = np.ascontiguousarray(codes, np.uint16)
    if table.ndim == 1:
        return _native.decode_16(codes, table)
    return _native.decode_channels_16(codes, (table[0], table[1], table[2]))
