"""Damage to a PNG file is reported in one sentence, not by libpng on stderr."""

import struct
import zlib

import pytest

import envlights as el
from envlights.io import png

SIGNATURE = b"\x89PNG\r\n\x1a\n"


def chunk(kind, body=b""):
    check = struct.pack(">I", zlib.crc32(kind + body))
    return struct.pack(">I", len(body)) + kind + body + check


def header(width=4, height=2, depth=8, colours=2, packing=0, filtering=0, interlace=0):
    fields = (width, height, depth, colours, packing, filtering, interlace)
    return chunk(b"IHDR", struct.pack(">2I5B", *fields))


ROWS = zlib.compress(bytes(2 * 13))
PIXELS = chunk(b"IDAT", ROWS)
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
    "no end": (header() + PIXELS, "the file is incomplete"),
    "nothing": (b"", "the file is incomplete"),
}
#: Pixels under a right checksum, wherever libpng finds them wrong.
NOT_PACKED, NO_END = (
    "its pixels cannot be decompressed",
    "the number of its pixels contradicts its header",
)
WRONG_PIXELS = {
    "no stream": (bytes(20), NOT_PACKED),
    "a wrong checksum": (ROWS[:-1] + b"x", NOT_PACKED),
    "a dictionary": (b"\x78\xbb" + ROWS[2:], NOT_PACKED),
    "a stream cut off": (ROWS[:-6], NO_END),
    "a checksum cut off": (ROWS[:-2], NO_END),
    "a row too few": (zlib.compress(bytes(13)), NO_END),
    "a byte too few": (zlib.compress(bytes(2 * 13 - 1)), NO_END),
    "an unknown filter of a row": (zlib.compress(bytes(13) + b"\5" + bytes(12)), "unknown filter"),
}
DAMAGED |= {
    name: (header() + chunk(b"IDAT", data) + END, sentence)
    for name, (data, sentence) in WRONG_PIXELS.items()
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


@pytest.mark.parametrize("interlace", [0, 1])
@pytest.mark.parametrize(("width", "height"), [(1, 1), (3, 2), (5, 9), (33, 17)])
@pytest.mark.parametrize(("colours", "depth"), [(0, 1), (0, 16), (2, 8), (2, 16), (4, 8), (6, 16)])
def test_whole_pixels_of_each_kind_are_no_damage(
    tmp_path, capfd, interlace, width, height, colours, depth
):
    """They are read, and one byte less is found too few, as libpng finds it."""
    if interlace:
        # As the specification draws them: each pass has the pixels that bear its number.
        pattern = ["16462646", "77777777", "56565656", "77777777"]
        pattern += ["36463646", "77777777", "56565656", "77777777"]
        numbers = [[pattern[y % 8][x % 8] for x in range(width)] for y in range(height)]
    else:
        numbers = [["1"] * width for _ in range(height)]
    bits = depth * {0: 1, 2: 3, 4: 2, 6: 4}[colours]
    rows = b""
    for number in "1234567":
        for row in numbers:
            if number in row:
                rows += b"\4" + bytes((row.count(number) * bits + 7) // 8)
    start = SIGNATURE + header(width, height, depth, colours, interlace=interlace)
    path = tmp_path / "map.png"
    # In several chunks, one of them empty, with bytes after the last row.
    data = zlib.compress(rows + b"after")
    pieces = [chunk(b"IDAT", piece) for piece in (data[:3], b"", data[3:])]
    path.write_bytes(start + b"".join(pieces) + END)
    assert png.damage_of_pixels(str(path)) == ""
    assert el.io.read_image(path).pixels.shape[:2] == (height, width)
    path.write_bytes(start + chunk(b"IDAT", zlib.compress(rows[:-1])) + END)
    assert NO_END in png.damage_of_pixels(str(path))
    assert capfd.readouterr().err == ""


def test_long_streams_are_unpacked_piece_by_piece(tmp_path):
    """Several blocks, the last one ending with the stream, and a wrong filter far behind."""
    height, width = 1024, 1024
    rows = (b"\1" + bytes(3 * width)) * height
    rows += bytes(-len(rows) % 2**20)
    path = tmp_path / "map.png"
    for data, sentence in [(rows, ""), (rows[: 3072 * 900] + b"\7" * 3073, "unknown filter")]:
        content = header(width, height) + chunk(b"IDAT", zlib.compress(data)) + END
        path.write_bytes(SIGNATURE + content)
        assert sentence in png.damage_of_pixels(str(path))
        assert bool(png.damage_of_pixels(str(path))) == bool(sentence)
