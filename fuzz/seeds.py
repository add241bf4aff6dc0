"""Write small files of each kind as seeds of the fuzz targets, into `fuzz/seeds`."""

import itertools
import struct
import tempfile
import zlib
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813, its own name for itself

FOLDER = Path(__file__).with_name("seeds")

#: Bits of a sample that each colour type of PNG allows, and samples of a pixel.
DEPTHS = {0: (1, 2, 4, 8, 16), 2: (8, 16), 3: (1, 2, 4, 8), 4: (8, 16), 6: (8, 16)}
SAMPLES = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
#: Columns and rows of a pass of an interlaced picture: first one, and step.
PASSES = [
    (0, 8, 0, 8),
    (4, 8, 0, 8),
    (0, 4, 4, 8),
    (2, 4, 0, 4),
    (0, 2, 2, 4),
    (1, 2, 0, 2),
    (0, 1, 1, 2),
]
#: Columns, source share, flags, blocks of a step and width of a raw rectangle: see `rows.rs`.
OPTIONS = [(4, 1, 0x00, 0, 8), (3, 40, 0x41, 1, 5), (7, 2, 0x82, 2, 16), (16, 200, 0x83, 7, 9)]


def chunk(kind: bytes, body: bytes = b"") -> bytes:
    """One chunk of a PNG file."""
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def scanlines(width: int, height: int, bits: int, *, interlaced: bool) -> bytes:
    """Rows of numbers, each behind the number of its filter."""
    passes = PASSES if interlaced else [(0, 1, 0, 1)]
    rows = []
    for left, across, top, down in passes:
        columns = len(range(left, width, across))
        for y in range(top, height, down) if columns else ():
            size = -(-columns * bits // 8)
            rows.append(bytes([y % 5]) + bytes((y * y * 7 + 31 * x) % 256 for x in range(size)))
    return b"".join(rows)


def png(colours: int, depth: int, *, interlaced: bool) -> bytes:
    """A picture of 16 x 8 pixels with statements about its colour."""
    width, height = 16, 8
    header = struct.pack(">2I5B", width, height, depth, colours, 0, 0, interlaced)
    chunks = [chunk(b"IHDR", header), chunk(b"gAMA", struct.pack(">I", 45455))]
    if colours == 3:
        palette = bytes(range(48))[: 3 << depth] if depth < 8 else bytes(768)
        chunks += [chunk(b"PLTE", palette), chunk(b"tRNS", b"\0\x80")]
    elif depth == 8:
        chunks += [chunk(b"sRGB", b"\0"), chunk(b"cICP", bytes([1, 13, 0, 1]))]
        chunks += [chunk(b"iCCP", b"name\0\0" + zlib.compress(bytes(128)))]
        chunks += [chunk(b"eXIf", b"II*\0\x08\0\0\0\1\0\x12\1\3\0\1\0\0\0\6\0\0\0\0\0\0\0")]
        chunks += [chunk(b"iTXt", b"XML:com.adobe.xmp\0\0\0\0\0<x/>")]
        chunks += [chunk(b"cHRM", struct.pack(">8I", *[30000] * 8))]
    data = scanlines(width, height, depth * SAMPLES[colours], interlaced=interlaced)
    # Bytes that are not compressed can be changed one by one.
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        [*chunks, chunk(b"IDAT", zlib.compress(data, 0)), chunk(b"IEND")]
    )


def radiance(width: int, kind: str) -> bytes:
    """A picture of 8 rows: with packets of planes, with old runs, or without runs."""
    lines = b"#?RADIANCE\nEXPOSURE=2\nPRIMARIES=.64 .33 .3 .6 .15 .06 .3127 .329\n"
    header = lines + b"FORMAT=32-bit_rle_rgbe\n\n-Y 8 +X %d\n" % width
    return header + b"".join(_line(y, width, kind) for y in range(8))


def _line(y: int, width: int, kind: str) -> bytes:
    exponent = 120 + 3 * y
    if kind == "packets":
        literal = bytes([width - 4]) + bytes((y * 37 + x) % 256 for x in range(width - 4))
        planes = (literal + bytes([132, 9 * y])) * 3 + bytes([128 + width, exponent])
        return bytes([2, 2]) + struct.pack(">H", width) + planes
    if kind == "runs":
        return bytes([9 * y + 4, 7, 200, exponent, 1, 1, 1, width - 1])
    return b"".join(bytes([4 + x, 9 * y, 77, exponent]) for x in range(width))


def written() -> dict[str, bytes]:
    """Pictures of 16 x 8 pixels that OpenImageIO writes, by their names."""
    kinds = [
        *(
            ("exr", kind, way)
            for kind in ("half", "float")
            for way in ("zip", "piz", "rle", "dwaa")
        ),
        *(("exr", "half", way) for way in ("none", "pxr24", "b44a")),
        *(("tif", kind, way) for kind in ("uint8", "uint16", "float") for way in ("none", "zip")),
        *(("tif", kind, way) for kind in ("uint8", "float") for way in ("lzw", "packbits")),
        ("jpg", "uint8", "jpeg:90"),
    ]
    found = {}
    for (suffix, kind, way), tile in itertools.product(kinds, (0, 16)):
        spec = oiio.ImageSpec(16, 8, 3, kind)
        spec.attribute("compression", way)
        spec.tile_width = spec.tile_height = 0 if suffix == "jpg" else tile
        pixels = np.random.default_rng(0).random((8, 16, 3), dtype=np.float32)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"map.{suffix}"
            file = oiio.ImageOutput.create(str(path))
            if file.open(str(path), spec) and file.write_image(pixels) and file.close():
                found[f"{suffix}_{kind}_{way.partition(':')[0]}_{tile}"] = path.read_bytes()
    return found


def files() -> dict[str, bytes]:
    """Bytes of each seed file by its name."""
    found = {
        f"png_{colours}_{depth}_{interlaced}": png(colours, depth, interlaced=bool(interlaced))
        for colours, depths in DEPTHS.items()
        for depth, interlaced in itertools.product(depths, range(2))
    }
    for width, kind in itertools.product((8, 16, 100), ("packets", "runs", "flat")):
        found[f"hdr_{width}_{kind}"] = radiance(width, kind)
    return found | written()


def main() -> None:
    """Write the seeds of both targets."""
    for target in ("decode", "rows"):
        (FOLDER / target).mkdir(parents=True, exist_ok=True)
    for (name, data), options in zip(files().items(), itertools.cycle(OPTIONS), strict=False):
        (FOLDER / "decode" / name).write_bytes(data)
        (FOLDER / "rows" / name).write_bytes(bytes(options) + data)


if __name__ == "__main__":
    main()
