"""Tags of the first page of a TIFF file: size, colour model, XMP packet (TIFF 6.0, section 2)."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import IO, Any

from envlights._common.errors import DamagedFileError, FileError
from envlights.environment.decoders.source import Source

#: Tags that are read.
_WIDTH, _HEIGHT, _PHOTOMETRIC, _XMP = 256, 257, 262, 700
#: Letter of `struct` for each type of a value; others are passed over.
_LETTERS = {1: "B", 3: "H", 4: "I", 7: "B", 16: "Q"}
#: Greatest number of tags and longest XMP packet.
_MOST_TAGS, _LONGEST = 4096, 2**22

#: Colour models whose samples are not RGB or grey, and which no reader here converts.
_REFUSED = {
    8: "L*a*b* colour",
    9: "ICC L*a*b* colour",
    10: "ITU L*a*b* colour",
    32803: "a raw colour filter array",
    32844: "LogL luminance, which the image library cuts off at white",
    32845: "LogLuv colour, which the image library cuts off at white",
    34892: "linear raw samples",
}


@dataclass(frozen=True)
class Tags:
    """Values of the first page."""

    width: int
    """Columns."""

    height: int
    """Rows."""

    photometric: int
    """Colour model: 0 and 1 grey, 2 RGB, 3 palette, 5 CMYK, 6 YCbCr, 8 L*a*b*."""

    xmp: bytes
    """XMP packet; empty if there is none."""


def tags(source: Source) -> Tags:
    """Tags of the first page of a file, or a refusal of a colour model that is not converted."""
    with source.open() as file:
        try:
            values = _values(file)
        except (struct.error, OSError, OverflowError, ValueError):
            raise DamagedFileError(
                f"cannot read {source.name}: its TIFF tags are damaged"
            ) from None
    numbers = {tag: int(value) for tag, value in values.items() if not isinstance(value, bytes)}
    photometric = numbers.get(_PHOTOMETRIC, 2)
    if photometric in _REFUSED:
        raise FileError(
            f"cannot read {source.name}: its samples are {_REFUSED[photometric]}"
            f" (photometric {photometric}); give RGB, as floating point for high dynamic range"
        )
    packet = values.get(_XMP, b"")
    size = numbers.get(_WIDTH, 0), numbers.get(_HEIGHT, 0)
    return Tags(*size, photometric, packet if isinstance(packet, bytes) else b"")


def _values(file: IO[bytes]) -> dict[int, int | bytes]:
    """Numbers of the tags of the first page, and the bytes of its XMP packet."""
    head = file.read(16)
    order = "<" if head[:2] == b"II" else ">"
    is_big = head[2:4] in (b"+\0", b"\0+")
    offset, entry = ("Q", "HHQ8s") if is_big else ("I", "HHI4s")
    start = struct.unpack_from(order + offset, head, 8 if is_big else 4)[0]
    file.seek(start)
    count = _unpack(file, order + ("Q" if is_big else "H"))[0]
    table: list[tuple[Any, ...]] = [
        _unpack(file, order + entry) for _ in range(min(count, _MOST_TAGS))
    ]
    values: dict[int, int | bytes] = {}
    for tag, kind, length, raw in table:
        letter = _LETTERS.get(kind)
        if tag == _XMP and kind in (1, 2, 7) and length <= _LONGEST:
            file.seek(struct.unpack(order + offset, raw)[0])
            values[tag] = file.read(length)
        elif letter and struct.calcsize(letter) <= len(raw):
            values[tag] = struct.unpack_from(order + letter, raw)[0]
    return values


def _unpack(file: IO[bytes], form: str) -> tuple[Any, ...]:
    return struct.unpack(form, file.read(struct.calcsize(form)))
