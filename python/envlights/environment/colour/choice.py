"""Conversion of samples to linear Rec.709, chosen by the metadata of a file.

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
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import describe
from envlights._common.errors import FileError
from envlights._native import EnvLightsError
from envlights.environment.colour import colour_spaces, icc, primaries
from envlights.environment.colour.colour_spaces import Space
from envlights.environment.colour.transfer_curves import Curve
from envlights.environment.decoders.raw_image import Header

#: Colour space from the caller: a name of `colour_spaces.NAMES`, or an ICC profile as path or
#: bytes.
ColourArgument = str | bytes | os.PathLike[str]

#: Formats whose samples are always linear, whatever the metadata.
_LINEAR_KINDS = {"openexr", "radiance"}

#: Range of plausible exponents in a PNG gAMA chunk.
_EXPONENTS = (0.1, 10.0)

#: Advice at the end of an error message.
_BY_HAND = 'name the colour space, such as colour="srgb" or colour="linear"'

#: Default spaces of integer and floating-point samples.
_SRGB, _LINEAR = colour_spaces.SRGB, colour_spaces.LINEAR


class ColourConversion(NamedTuple):
    """Conversion of samples to linear Rec.709."""

    curve: Curve | None
    """Function from codes in 0 to 1, (..., 3), to linear values; None for linear samples."""

    matrix: NDArray[np.float64] | None
    """Matrix from linear RGB of the file to linear Rec.709, (3, 3); None for Rec.709."""

    clip_level: float | None
    """Linear value of the largest code; None for floating-point samples."""

    notes: tuple[str, ...]
    """Notes on the conversion."""

    def table(self, bits: int) -> NDArray[np.float32]:
        """Linear value of each code, (n,), or (3, n) if the channels have different curves."""
        codes = np.arange(1 << bits) / ((1 << bits) - 1)
        return self.values(codes)

    def values(self, codes: NDArray[np.float64]) -> NDArray[np.float32]:
        """Linear values of (n,) codes: (n,), or (3, n) if the channels have different curves."""
        if self.curve is None:
            return codes.astype(np.float32)
        with np.errstate(all="ignore"):
            values = self.curve(np.repeat(codes[:, None], 3, axis=1)).astype(np.float32).T
        values = np.ascontiguousarray(values)
        is_one = np.array_equal(values[[0, 0]], values[1:], equal_nan=True)
        return values[0] if is_one else values


def conversion(header: Header, colour: ColourArgument | None) -> ColourConversion:
    """Conversion by the metadata of a file, or by `colour`.

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
    return unchecked._replace(clip_level=float(unchecked.table(8)[..., -1].max()))


def _notes(space: Space, is_integer: bool) -> list[str]:
    """Notes on the curve and the primaries, also for plain sRGB codes."""
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
    """Bytes of an ICC profile that the caller gave."""
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
            raise FileError(f"cannot read the profile {colour!r}: {reason}") from None
    names = ", ".join(f'"{name}"' for name in colour_spaces.NAMES)
    raise EnvLightsError(
        f"colour must be {names}, or an ICC profile (a path or bytes); got {describe(colour)}"
    )


def _space_of(header: Header) -> Space:
    """Colour space of a file, from the first of its metadata that is valid."""
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
    # Decoders of formats other than PNG expand the video range themselves.
    is_full = cicp[3] if header.kind == "png" else 1
    space = colour_spaces.by_cicp((*cicp[:3], is_full), 8 * header.dtype.itemsize)
    if space is None:
        raise EnvLightsError(
            f"the colour space has the codes {cicp} of ITU-T H.273 (cICP), which are not"
            f" supported; {_BY_HAND}"
        )
    return space


def _space_of_embedded(data: bytes, default: Space) -> Space:
    """Colour space of the embedded profile, or the default for an unusable kind of profile."""
    try:
        return _space_of_profile(data)
    except icc.UnusedProfileError as reason:
        assumed = default.curve_name or "linear Rec.709"
        return default._replace(notes=(f"{reason}; {assumed} was assumed",))


def _space_of_profile(data: bytes) -> Space:
    """Colour space of a profile; raises an error for damaged bytes."""
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
    """Colour space with an OpenImageIO name; for floating point only a linear space is accepted."""
    space = colour_spaces.by_openimageio_name(name)
    if space is None:
        assumed = default.curve_name or "linear Rec.709"
        return default._replace(
            notes=(f"the colour space '{name}' is unknown; {assumed} was assumed",)
        )
    return space if is_integer or space.curve is None else default
