"""Damage to a PNG file is told by us, in one sentence, and not by libpng on stderr."""

import struct
import zlib

import pytest

import envlights as el

SIGNATURE = b"\x89PNG\r\n\x1a\n"


def chunk(kind, body=b""):
    check = struct.pack(">I", zlib.crc32(kind + body))
    return struct.pack(">I", len(body)) + kind + body + check


def header(width=4, height=2, depth=8, colours=2, packing=0, filtering=0, interlace=0):
    fields = (width, height, depth, colours, packing, filtering, interlace)
    return chunk(b"IHDR", struct.pack(">2I5B", *fields))


PIXELS = chunk(b"IDAT", zlib.compress(bytes(2 * 13)))
END = chunk(b"IEND")
DAMAGED = {
    "no header": (PIXELS + END, "its header is damaged"),
    "a short header": (chunk(b"IHDR", bytes(12)) + PIXELS + END, "its header is damaged"),
    "a long header": (chunk(b"IHDR", bytes(14)) + PIXELS + END, "its header is damaged"),
    "no columns": (header(width=0) + PIXELS + END, "its header is damaged"),
    "too many rows": (header(height=10**6 + 1) + PIXELS + END, "its header is damaged"),
    "an impossible depth": (header(depth=4) + PIXELS + END, "its header is damaged"),
    "unknown colours": (header(colours=5) + PIXELS + END, "its header is damaged"),
    "unknown packing": (header(packing=1) + PIXELS + END, "its header is damaged"),
    "an unknown filter": (header(filtering=1) + PIXELS + END, "its header is damaged"),
    "an unknown order": (header(interlace=2) + PIXELS + END, "its header is damaged"),
    "two headers": (header() + header() + PIXELS + END, "it has two headers"),
    "an unknown chunk": (header() + chunk(b"ABCD") + PIXELS + END, "a chunk of an unknown kind"),
    "a reserved chunk": (header() + chunk(b"abcd") + PIXELS + END, "a chunk of an unknown kind"),
    "no name": (header() + chunk(b"a1Cd") + PIXELS + END, "a chunk of an unknown kind"),
    "no pixels": (header() + END, "it has no pixels"),
    "no end": (header() + PIXELS, "the file is cut off"),
    "nothing": (b"", "the file is cut off"),
}


@pytest.mark.parametrize("damage", DAMAGED)
def test_damage_is_told_in_our_words(tmp_path, capfd, damage):
    chunks, sentence = DAMAGED[damage]
    (tmp_path / "map.png").write_bytes(SIGNATURE + chunks)
    with pytest.raises(el.EnvLightsError, match=sentence):
        el.EnvMap.open(tmp_path / "map.png")
    assert capfd.readouterr().err == ""


def test_whole_files_are_read(tmp_path):
    text = chunk(b"tEXt", b"Comment\0none") + chunk(b"prIv", b"anything")
    (tmp_path / "map.png").write_bytes(SIGNATURE + header() + text + PIXELS + END + b"after")
    assert el.EnvMap.open(tmp_path / "map.png").width == 4
