"""Segments of a JPEG file before its pixels: size, XMP packet, gain map (ITU-T T.81, B.1)."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import IO

from envlights._common.errors import DamagedFileError
from envlights.environment.decoders import xmp
from envlights.environment.decoders.source import Source

_XMP = b"http://ns.adobe.com/xap/1.0/\0"
_GAIN_MAP = b"urn:iso:std:iso:ts:21496:-1\0"
#: Frames, which hold the size: SOF0 to SOF15 without the tables DHT, JPG and DAC.
_FRAMES = set(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
#: Markers without a length.
_BARE = {0x01, *range(0xD0, 0xD9)}
_SCAN, _END = 0xDA, 0xD9
#: Segments that may stand before the pixels.
_MOST_SEGMENTS = 10_000


@dataclass
class Segments:
    """Content of the segments before the pixels."""

    width: int = 0
    """Columns."""

    height: int = 0
    """Rows."""

    xmp: bytes = b""
    """XMP packet of the first APP1 segment that holds one."""

    has_gain_map: bool = False
    """True if a gain map for high dynamic range is named (ISO 21496-1, or Adobe's hdrgm)."""


def segments(source: Source) -> Segments:
    """Segments of a file, read up to its first scan.

    Raises
    ------
    DamagedFileError
        If there is no frame before the first scan.
    """
    found = Segments()
    with source.open() as file:
        file.seek(2)
        for _ in range(_MOST_SEGMENTS):
            marker = _marker(file)
            if marker in (_SCAN, _END):
                break
            if marker not in _BARE:
                _take(found, marker, _body(file))
    if not found.width * found.height:
        raise DamagedFileError(
            f"cannot read {source.name}: it has no size before its pixels; the file is damaged"
        )
    said = xmp.properties(found.xmp)
    found.has_gain_map |= any(key.startswith(("hdrgm:", "HDRGainMap:")) for key in said)
    return found


def _marker(file: IO[bytes]) -> int:
    """Code of the next marker, after fill bytes; that of the end if there is none."""
    byte = file.read(1)
    while byte and byte != b"\xff":
        byte = file.read(1)
    while byte == b"\xff":
        byte = file.read(1)
    return byte[0] if byte else _END


def _body(file: IO[bytes]) -> bytes:
    """Content of a segment."""
    length = file.read(2)
    return file.read(max(struct.unpack(">H", length)[0] - 2, 0)) if len(length) == 2 else b""


def _take(found: Segments, marker: int, body: bytes) -> None:
    if marker in _FRAMES and len(body) >= 5:
        found.height, found.width = struct.unpack(">HH", body[1:5])
    elif marker == 0xE1 and body.startswith(_XMP) and not found.xmp:
        found.xmp = body[len(_XMP) :]
    elif marker == 0xE2 and body.startswith(_GAIN_MAP):
        found.has_gain_map = True
