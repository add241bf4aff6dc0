"""Curves and matrix of ICC profiles (ICC.1, versions 2 and 4).

Applied are RGB profiles with three curves and three primaries, grey profiles with one curve, and
the codes of ITU-R BT.2100 that a version 4.4 profile may hold. Lookup tables are not.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights.environment.colour.primaries import columns_to_rec709
from envlights.environment.colour.transfer_curves import (
    Curve,
    Interpolation,
    PerChannel,
    Power,
    Reals,
    is_linear,
    is_srgb,
    odd,
    srgb,
)

#: Bytes of the header, and of an entry of the table of tags.
_HEADER, _ENTRY = 128, 12
#: Largest number of tags; real profiles have up to 40.
_MOST_TAGS = 1000
#: Largest size; printer profiles with large tables have 4 MB.
MOST_BYTES = 2**26
#: Longest profile name in a note; longer ones are cut.
_LONGEST_NAME = 60

#: Number of parameters of each type of parametric curve.
_PARAMETERS = (1, 3, 4, 5, 7)

#: Classes of profiles that describe no pixels: device links, abstract effects and named colours.
_NOT_OF_PIXELS = {b"link", b"abst", b"nmcl"}


class Profile(NamedTuple):
    """Conversion described by a profile."""

    name: str
    """Description in the profile; empty if there is none."""

    curve: Curve | None
    """Function from codes to linear values; None if the codes are linear."""

    matrix: NDArray[np.float64] | None
    """Linear RGB to linear Rec.709; None for Rec.709 and for grey."""

    cicp: tuple[int, int, int, int] | None
    """Codes of primaries and transfer, which override the curve and the matrix."""


class UnusedProfileError(ValueError):
    """Error for a profile of a kind that is not applied."""


def parse(data: bytes) -> Profile:
    """Curve and matrix of a profile.

    Raises
    ------
    UnusedProfileError
        If the profile is for other pixels than RGB or grey, or holds lookup tables alone.
    ValueError
        If the profile is damaged.
    """
    tags = _tags(data)
    name = _name(tags)
    space = data[16:20]
    if data[12:16] in _NOT_OF_PIXELS or space not in (b"RGB ", b"GRAY"):
        raise UnusedProfileError(f"{_noun(name)} is not for RGB or grey pixels")
    if cicp := _cicp(tags):
        return Profile(name, None, None, cicp)
    if space == b"GRAY":
        return Profile(name, _curves(tags, [b"kTRC"], name), None, None)
    curve = _curves(tags, [b"rTRC", b"gTRC", b"bTRC"], name)
    columns = np.array([_xyz(_body(tags, tag, name)) for tag in (b"rXYZ", b"gXYZ", b"bXYZ")]).T
    return Profile(name, curve, columns_to_rec709(columns), None)


def _noun(name: str) -> str:
    """Phrase for the profile in a sentence."""
    return f"the ICC profile '{name}'" if name else "the ICC profile"


def _tags(data: bytes) -> dict[bytes, bytes]:
    """Content of each tag; a tag that extends beyond the data is truncated."""
    if len(data) < _HEADER + 4 or len(data) > MOST_BYTES:
        raise ValueError(f"it has {len(data)} bytes")
    if data[36:40] != b"acsp":
        raise ValueError("its header has no signature")
    (count,) = struct.unpack_from(">I", data, _HEADER)
    if count > _MOST_TAGS or len(data) < _HEADER + 4 + count * _ENTRY:
        raise ValueError(f"its table of {count} tags is incomplete")
    entries = struct.iter_unpack(">4sII", data[_HEADER + 4 : _HEADER + 4 + count * _ENTRY])
    return {tag: data[start : start + size] for tag, start, size in entries}


def _body(tags: dict[bytes, bytes], tag: bytes, name: str) -> bytes:
    if tag in tags:
        return tags[tag]
    if any(key.startswith((b"A2B", b"D2B")) for key in tags):
        raise UnusedProfileError(f"{_noun(name)} holds lookup tables, which are not applied")
    raise ValueError(f"it has no tag {tag.decode()}")


def _xyz(body: bytes) -> tuple[float, float, float]:
    if body[:4] != b"XYZ " or len(body) < 20:
        raise ValueError("a primary colour is damaged")
    x, y, z = struct.unpack_from(">3i", body, 8)
    return x / 65536, y / 65536, z / 65536


def _cicp(tags: dict[bytes, bytes]) -> tuple[int, int, int, int] | None:
    body = tags.get(b"cicp", b"")
    if body[:4] != b"cicp" or len(body) < 12:
        return None
    return body[8], body[9], body[10], body[11]


def _curves(tags: dict[bytes, bytes], names: list[bytes], name: str) -> Curve | None:
    """A single curve if all channels are equal, None if all are linear."""
    bodies = [_body(tags, tag, name) for tag in names]
    curves = [_curve(body) for body in bodies]
    if all(map(is_linear, curves)):
        return None
    if all(map(is_srgb, curves)):
        return srgb
    if len(set(bodies)) == 1:
        return curves[0]
    return PerChannel((curves[0], curves[1], curves[2]))


def _curve(body: bytes) -> Curve:
    """Curve of a tag, after a check of its values."""
    readers: dict[bytes, Callable[[bytes], Curve]] = {
        b"curv": _through_values,
        b"para": _parametric,
    }
    reader = readers.get(body[:4])
    if reader is None or len(body) < 12:
        raise ValueError("a curve is damaged")
    curve = reader(body)
    with np.errstate(all="ignore"):
        values = curve(np.linspace(0, 1, 1025))
    if not np.isfinite(values).all() or values[-1] <= 0:
        raise ValueError("a curve has impossible values")
    return curve


def _through_values(body: bytes) -> Curve:
    (count,) = struct.unpack_from(">I", body, 8)
    if len(body) < 12 + 2 * count:
        raise ValueError(f"a curve of {count} values is incomplete")
    if count == 0:
        return Power(1.0)
    values = np.frombuffer(body, ">u2", count, 12)
    return Power(float(values[0]) / 256) if count == 1 else Interpolation(values / 65535)


def _parametric(body: bytes) -> Curve:
    (kind,) = struct.unpack_from(">H", body, 8)
    if kind >= len(_PARAMETERS) or len(body) < 12 + 4 * _PARAMETERS[kind]:
        raise ValueError(f"a parametric curve of type {kind} is incomplete or unknown")
    values = [value / 65536 for value in struct.unpack_from(f">{_PARAMETERS[kind]}i", body, 12)]
    if values[0] <= 0:
        raise ValueError("a curve has an impossible exponent")
    if kind == 0:
        return Power(values[0])
    return _formula(kind, values)


def _formula(kind: int, values: list[float]) -> Curve:
    """Parametric curve of type 1 to 4: a power, or a line below a limit (ICC.1, table 70)."""
    exponent, a, b, c, limit, e, f = values + [0.0] * (7 - len(values))
    if kind <= 2:
        if a <= 0:
            raise ValueError("a curve has an impossible slope")
        # In type 2 the parameter c is added to both parts.
        limit, e, f, c = -b / a, c, c, 0.0

    @odd
    def curve(codes: Reals) -> Reals:
        power = np.maximum(a * codes + b, 0) ** exponent + e
        values = np.where(codes >= limit, power, c * codes + f)
        return np.asarray(np.maximum(values, 0))

    return curve


def _name(tags: dict[bytes, bytes]) -> str:
    """First description of the profile; empty if it is missing or damaged."""
    body = tags.get(b"desc", b"")
    text = ""
    if body[:4] == b"desc" and len(body) >= 12:
        (count,) = struct.unpack_from(">I", body, 8)
        text = body[12 : 12 + min(count, 4 * _LONGEST_NAME)].decode("latin-1")
    elif body[:4] == b"mluc" and len(body) >= 28:
        length, start = struct.unpack_from(">II", body, 20)
        text = body[start : start + min(length, 8 * _LONGEST_NAME)].decode("utf-16-be", "replace")
    text = text.split("\0")[0].strip()
    return "".join(c if c.isprintable() else "?" for c in text)[:_LONGEST_NAME]
