"""Files that fail: steps of the library, damaged or huge headers, memory, forked processes."""

import errno
import os
import struct
import subprocess
import sys
import tracemalloc
import zlib
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813, its own name for itself
import pytest

import envlights as el
from envlights import io
from envlights._common.srgb import decode_srgb
from envlights.environment.decoders.raw_image import RawImage
from tests.io.test_images import RADIANCE, write


@pytest.mark.parametrize("suffix", ["exr", "tif", "png"])
def test_a_full_disk_leaves_the_old_file(tmp_path, monkeypatch, suffix):
    target = tmp_path / f"map.{suffix}"
    target.write_bytes(b"old")
    write_bytes = Path.write_bytes

    def half(path, data):
        write_bytes(path, data[: len(data) // 2])
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", half)
    picture = el.EnvMap(RADIANCE.clip(0, 1)).to("equirectangular")
    with pytest.raises(el.EnvLightsError, match=rf"cannot write .*map\.{suffix}: No space left"):
        picture.save(target)
    assert [path.name for path in tmp_path.iterdir()] == [target.name]
    assert target.read_bytes() == b"old"


def test_a_map_beyond_memory_is_refused_and_its_file_closed(tmp_path, monkeypatch):
    path = write(tmp_path / "map.exr", RADIANCE)

    def no_memory(*_):
        raise MemoryError

    monkeypatch.setattr(RawImage, "rows", no_memory)
    with pytest.raises(el.EnvLightsError, match=r"map\.exr: its pixels do not fit into memory"):
        el.EnvMap.open(path)
    if sys.platform == "linux":
        handles = [os.path.realpath(handle) for handle in Path("/proc/self/fd").iterdir()]
        assert str(path) not in handles


FORKED = """
import os, signal, sys
import numpy as np
from envlights import io

image = np.random.default_rng(0).random((256, 512, 3), dtype=np.float32)
io.write_exr(sys.argv[1], image)
child = os.fork()
if child == 0:
    signal.alarm(20)
    io.write_exr(sys.argv[2], image)
    os._exit(0 if np.array_equal(io.read_image(sys.argv[2]).pixels, image) else 1)
sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_a_forked_process_writes_what_its_parent_wrote_before(tmp_path):
    paths = [str(tmp_path / name) for name in ("parent.exr", "child.exr")]
    assert subprocess.run([sys.executable, "-c", FORKED, *paths], check=False).returncode == 0


def png_chunk(kind, body, length=None):
    length = len(body) if length is None else length
    return struct.pack(">I", length) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def png_of(width, height, data=b"", **length):
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = (
        png_chunk(b"IHDR", header) + png_chunk(b"IDAT", data, **length) + png_chunk(b"IEND", b"")
    )
    return b"\x89PNG\r\n\x1a\n" + chunks


def test_a_header_that_claims_too_many_pixels_is_refused_before_memory_is_taken(tmp_path):
    path = tmp_path / "huge.png"
    path.write_bytes(png_of(60000, 30000, bytes(10**6)))
    with pytest.raises(
        el.EnvLightsError, match=r"up to 536870912 pixels; got 30000 rows of 60000; .*max_pixels"
    ):
        el.EnvMap.open(path)
    write(tmp_path / "small.exr", RADIANCE)
    with pytest.raises(el.EnvLightsError, match=r"up to 511 pixels; got 16 rows of 32; "):
        el.EnvMap.open(tmp_path / "small.exr", max_pixels=511)
    assert el.EnvMap.open(tmp_path / "small.exr", max_pixels=512).width == 32


def test_the_length_of_a_chunk_is_not_trusted(tmp_path):
    path = tmp_path / "chunk.png"
    path.write_bytes(png_of(4, 2, b"x", length=2**32 - 1))
    tracemalloc.start()
    try:
        with pytest.raises(el.EnvLightsError, match="the PNG file is damaged"):
            io.read_image(path)
        assert tracemalloc.get_traced_memory()[1] < 2**20
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("kind", [oiio.DOUBLE, oiio.FLOAT])
@pytest.mark.parametrize("tile", [0, 16])
def test_floats_and_doubles_in_strips_and_tiles_are_what_was_written(tmp_path, kind, tile):
    write(tmp_path / "map.tif", RADIANCE, kind, **({"tile": tile} if tile else {}))
    np.testing.assert_array_equal(io.read_image(tmp_path / "map.tif").pixels, RADIANCE)


PEAK = """
import re, sys
from pathlib import Path
import numpy as np
import envlights as el

def kilobytes(name):
    return int(re.search(name + r":\\s+(\\d+) kB", Path("/proc/self/status").read_text())[1])

el.EnvMap.open(sys.argv[2])  # loads the library
before = kilobytes("VmRSS")
env = el.EnvMap.open(sys.argv[1])
print((kilobytes("VmHWM") - before) * 1024 / env.radiance.nbytes)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="peak memory is read from Linux")
@pytest.mark.parametrize(
    ("name", "file_format", "most"),
    [
        ("map.png", oiio.UINT8, 1.5),
        ("map.png", oiio.UINT16, 1.7),  # all codes, half of the map, and the file
        ("map.jpg", oiio.UINT8, 1.5),
        ("map.exr", oiio.HALF, 1.3),
        ("map.hdr", oiio.FLOAT, 1.4),  # the file, a third of the map
    ],
)
def test_a_map_is_opened_in_hardly_more_memory_than_its_own(tmp_path, name, file_format, most):
    pixels = np.tile(RADIANCE, (128, 128, 1)).clip(0, 1)
    write(tmp_path / name, pixels, file_format)
    small = write(tmp_path / f"small_{name}", RADIANCE.clip(0, 1), file_format)
    run = [sys.executable, "-c", PEAK, str(tmp_path / name), str(small)]
    assert float(subprocess.check_output(run, text=True)) < most


@pytest.mark.parametrize("tile", [0, 16, 48])
@pytest.mark.parametrize("height", [127, 128, 300])
def test_rows_that_are_read_at_once_make_the_whole(tmp_path, height, tile):
    pixels = np.random.default_rng(height).random((height, 40, 3), dtype=np.float32)
    write(tmp_path / "map.exr", pixels, tile=tile)
    np.testing.assert_array_equal(io.read_image(tmp_path / "map.exr").pixels, pixels)
    codes = (255 * pixels).astype(np.uint8)
    write(tmp_path / "map.tif", codes, oiio.UINT8, tile=tile)
    expected = decode_srgb(codes / 255)
    np.testing.assert_array_equal(io.read_image(tmp_path / "map.tif").pixels, expected)


@pytest.mark.parametrize("at", [0, 1])
@pytest.mark.parametrize("value", [0x15, 0x51, 0x10, 0x01, 4])
def test_factors_and_tables_of_a_jpeg_beyond_its_standard_are_refused(value, at, tmp_path):
    # T.81, B.2.2: factors from 1 to 4, tables from 0 to 3.
    content = bytearray(write(tmp_path / "a.jpg", np.uint8(RADIANCE), oiio.UINT8).read_bytes())
    frame = content.index(b"\xff\xc0")
    component = frame + 10 + 3 * at
    assert content[frame + 9] == 3
    content[component + (2 if value == 4 else 1)] = value
    with pytest.raises(el.EnvLightsError, match="its frame has wrong factors"):
        el.EnvMap.open(bytes(content))


@pytest.mark.parametrize("tag", [256, 257])
def test_a_tiff_without_a_size_is_refused(tag, tmp_path):
    content = write(tmp_path / "a.tif", RADIANCE).read_bytes()
    order = "<" if content[:2] == b"II" else ">"
    (first,) = struct.unpack(order + "I", content[4:8])
    entry = content.index(struct.pack(order + "H", tag), first + 2)
    broken = content[:entry] + struct.pack(order + "H", 65000) + content[entry + 2 :]
    with pytest.raises(
        el.EnvLightsError, match=r"at least one pixel; got (16 rows of 0|0 rows of 32)"
    ):
        el.EnvMap.open(broken)
