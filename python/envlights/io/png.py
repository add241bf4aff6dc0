"""Damage to a PNG file that libpng would print to stderr: found before it reads the file."""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
#: Bytes around the content of a chunk: length, kind, checksum.
_FRAME = 12
#: Chunks that no reader may skip; others have a small first letter.
_CRITICAL = {b"IHDR", b"PLTE", b"IDAT", b"IEND"}
#: Columns, and rows, that libpng reads at most.
_LONGEST = 1_000_000
#: Bits of a sample, for each colour type.
_DEPTHS = {0: (1, 2, 4, 8, 16), 2: (8, 16), 3: (1, 2, 4, 8), 4: (8, 16), 6: (8, 16)}


def damage(path: str) -> str:
    """What is wrong with the header and the chunks of a file; empty where nothing is.

    Files without the signature of PNG are left to others. Pixels are not unpacked: of those that
    were packed wrongly, under a right checksum, libpng still prints a line before they are refused.
    """
    with Path(path).open("rb") as file:
        if file.read(len(_SIGNATURE)) != _SIGNATURE:
            return ""
        try:
            _check(_chunks(file))
        except ValueError as error:
            return str(error)
    return ""


def _chunks(file: BinaryIO) -> Iterator[tuple[bytes, bytes]]:
    """Kind and content of each chunk."""
    left = os.fstat(file.fileno()).st_size - len(_SIGNATURE)
    while left >= _FRAME:
        length, kind = struct.unpack(">I4s", file.read(8))
        left -= length + _FRAME
        if left < 0:  # before that much memory is asked for
            break
        body, check = file.read(length), file.read(4)
        if zlib.crc32(body, zlib.crc32(kind)).to_bytes(4, "big") != check:
            message = f"a chunk of {length} bytes has a wrong checksum; the file is damaged"
            raise ValueError(message)
        yield kind, body
    raise ValueError("the file is cut off")


def _check(chunks: Iterator[tuple[bytes, bytes]]) -> None:
    """Look for what a PNG file needs, in its order: header, pixels, end."""
    kind, body = next(chunks)
    if kind != b"IHDR" or not _is_header(body):
        raise ValueError("its header is damaged")
    has_pixels = False
    for kind, body in chunks:
        is_known = kind in _CRITICAL or kind[:1].islower()
        if not (kind.isalpha() and kind[2:3].isupper() and is_known):
            raise ValueError("it has a chunk of an unknown kind; the file is damaged")
        if kind == b"IHDR":
            raise ValueError("it has two headers; the file is damaged")
        has_pixels |= kind == b"IDAT" and len(body) > 0
        if kind == b"IEND":
            if not has_pixels:
                raise ValueError("it has no pixels; the file is damaged")
            return


def _is_header(body: bytes) -> bool:
    """Whether a header can be one."""
    if len(body) != 13:
        return False
    width, height, depth, colours, packing, filtering, interlace = struct.unpack(">2I5B", body)
    is_sized = 0 < width <= _LONGEST and 0 < height <= _LONGEST
    is_known = packing == filtering == 0 and interlace in (0, 1)
    return is_sized and is_known and depth in _DEPTHS.get(colours, ())
