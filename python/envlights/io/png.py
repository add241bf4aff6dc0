"""Check of PNG files before libpng reads them and prints their damage to stderr.

Chunks, packing and the filters of rows are those of the PNG specification (ISO/IEC 15948).
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
#: Bytes around the content of a chunk: length, kind, checksum.
_FRAME = 12
#: Chunks that every reader must know; names of others start with a lower-case letter.
_CRITICAL = {b"IHDR", b"PLTE", b"IDAT", b"IEND"}
#: Limit of libpng on columns and on rows.
_LONGEST = 1_000_000
#: Bits of a sample, and samples of a pixel, for each colour type.
_DEPTHS = {0: (1, 2, 4, 8, 16), 2: (8, 16), 3: (1, 2, 4, 8), 4: (8, 16), 6: (8, 16)}
_SAMPLES = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
#: First column and row of each pass over an interlaced image, and the steps to the next ones.
_ADAM7 = [
    (0, 0, 8, 8),
    (4, 0, 8, 8),
    (0, 4, 4, 8),
    (2, 0, 4, 4),
    (0, 2, 2, 4),
    (1, 0, 2, 2),
    (0, 1, 1, 2),
]
#: Filter types, the first byte of each row.
_FILTERS = bytes(range(5))
#: Bytes of one step of decompression.
_BLOCK = 2**20
#: Bytes of one input to zlib, which copies unused input.
_PIECE = 2**16


def damage(path: str) -> str:
    """Damage of the header and the chunks of a file; empty if there is none.

    Files without the signature of PNG are not checked. Pixels are not unpacked, because a header
    may claim any number of them.
    """
    return _damage(path, _check)


def damage_of_pixels(path: str) -> str:
    """Damage of the pixels of a file without other damage; empty if there is none."""
    return _damage(path, _check_pixels)


def _damage(path: str, check: Callable[[Iterator[tuple[bytes, bytes]]], None]) -> str:
    """Damage that `check` finds in the chunks of a file."""
    with Path(path).open("rb") as file:
        if file.read(len(_SIGNATURE)) != _SIGNATURE:
            return ""
        try:
            check(_chunks(file))
        except zlib.error:
            return "its pixels cannot be decompressed; the file is damaged"
        except ValueError as error:
            return str(error)
    return ""


def _chunks(file: BinaryIO) -> Iterator[tuple[bytes, bytes]]:
    """Kind and content of each chunk."""
    remaining = os.fstat(file.fileno()).st_size - len(_SIGNATURE)
    while remaining >= _FRAME:
        length, kind = struct.unpack(">I4s", file.read(8))
        remaining -= length + _FRAME
        if remaining < 0:  # before memory for `length` bytes is allocated
            break
        body, check = file.read(length), file.read(4)
        if zlib.crc32(body, zlib.crc32(kind)).to_bytes(4, "big") != check:
            message = f"a chunk of {length} bytes has a wrong checksum; the file is damaged"
            raise ValueError(message)
        yield kind, body
    raise ValueError("the file is incomplete")


def _check(chunks: Iterator[tuple[bytes, bytes]]) -> None:
    """Check for header, pixels and end, in this order."""
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


def _check_pixels(chunks: Iterator[tuple[bytes, bytes]]) -> None:
    """Unpack the pixels, and check their number and the end."""
    _, header = next(chunks)
    pixels = _Pixels(header)
    for kind, body in chunks:
        if kind == b"IDAT":
            for start in range(0, len(body), _PIECE):
                pixels.take(body[start : start + _PIECE])
        if kind == b"IEND":
            pixels.end()
            return


class _Pixels:
    """Count of the unpacked pixels, and a check of the filter of each row."""

    def __init__(self, header: bytes) -> None:
        self._stream = zlib.decompressobj()
        #: Bytes of a row and of all rows, for each remaining pass.
        self._passes = _passes(header)
        #: Unpacked bytes of the current pass.
        self._unpacked = 0

    def take(self, body: bytes) -> None:
        """Unpack the next piece; data after the last row is ignored."""
        while self._passes:
            block = self._stream.decompress(body, _BLOCK)
            self._check_filters(block)
            body = self._stream.unconsumed_tail
            if not body and len(block) < _BLOCK:
                return
        # Read the checksum at the end; zlib would store anything after it.
        if not self._stream.eof:
            self._stream.decompress(body, _BLOCK)

    def _check_filters(self, block: bytes) -> None:
        """Check the first byte of each row."""
        while block and self._passes:
            row, whole = self._passes[0]
            part, block = block[: whole - self._unpacked], block[whole - self._unpacked :]
            if part[-self._unpacked % row :: row].translate(None, _FILTERS):
                raise ValueError("a row has an unknown filter; the file is damaged")
            self._unpacked += len(part)
            if self._unpacked == whole:
                self._passes, self._unpacked = self._passes[1:], 0

    def end(self) -> None:
        """Refuse missing rows, or a stream without its end."""
        if self._passes or not self._stream.eof:
            raise ValueError("the number of its pixels contradicts its header; the file is damaged")


def _passes(header: bytes) -> list[tuple[int, int]]:
    """Bytes of a row with its filter, and of all rows, for each pass over the image."""
    width, height, depth, colours, _, _, is_interlaced = struct.unpack(">2I5B", header)
    passes = []
    for x, y, right, down in _ADAM7 if is_interlaced else [(0, 0, 1, 1)]:
        columns, rows = (width - x + right - 1) // right, (height - y + down - 1) // down
        row = 1 + (columns * _SAMPLES[colours] * depth + 7) // 8
        if columns and rows:
            passes.append((row, row * rows))
    return passes


def _is_header(body: bytes) -> bool:
    """True for a valid header."""
    if len(body) != 13:
        return False
    width, height, depth, colours, packing, filtering, interlace = struct.unpack(">2I5B", body)
    is_sized = 0 < width <= _LONGEST and 0 < height <= _LONGEST
    is_known = packing == filtering == 0 and interlace in (0, 1)
    return is_sized and is_known and depth in _DEPTHS.get(colours, ())
