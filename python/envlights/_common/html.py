"""HTML for results: no scripts, page colours, embedded pictures."""

from __future__ import annotations

import base64
import struct
import zlib
from html import escape

import numpy as np
from numpy.typing import NDArray


def block(title: str, in_short: str, *parts: str) -> str:
    """HTML block of a result: class name and one line, followed by the parts."""
    head = f"<div><strong>{escape(title)}</strong> {escape(in_short)}</div>"
    return f"<div>{head}{''.join(parts)}</div>"


def lines(text: str) -> str:
    """HTML of a text with its line breaks."""
    return "".join(f"<div>{escape(line)}</div>" for line in text.splitlines())


def picture(codes: NDArray[np.uint8], what: str) -> str:
    """HTML image of RGB pixels, (height, width, 3), with `what` as the alternative text."""
    height, width, _ = codes.shape
    data = base64.b64encode(png(codes)).decode()
    size = f'width="{width}" height="{height}"'
    return f'<img {size} alt="{escape(what)}" src="data:image/png;base64,{data}">'


def png(codes: NDArray[np.uint8]) -> bytes:
    """PNG file of an 8-bit RGB image, (height, width, 3) (ISO/IEC 15948)."""
    height, width, _ = codes.shape
    # Encode each row as the difference from the row above, which compresses smooth pictures well.
    above = np.vstack([np.zeros((1, width, 3), np.uint8), codes[:-1]])
    rows = np.full((height, 1 + 3 * width), 2, np.uint8)
    rows[:, 1:] = (codes - above).reshape(height, -1)
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(rows.tobytes(), 9)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(kind, content) for kind, content in chunks)


def _chunk(kind: bytes, content: bytes) -> bytes:
    checksum = zlib.crc32(content, zlib.crc32(kind))
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", checksum)
