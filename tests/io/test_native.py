"""The readers in Rust give the samples that OpenImageIO gives, or a sentence."""

import os
import struct
import zlib
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813, its own name for itself
import pytest

import envlights as el
from envlights._native import EnvLightsError, PictureFile
from tests import mutations

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
    "no header": PIXELS + END,
    "a short header": chunk(b"IHDR", bytes(12)) + PIXELS + END,
    "a long header": chunk(b"IHDR", bytes(14)) + PIXELS + END,
    "no columns": header(width=0) + PIXELS + END,
    "too many rows": header(height=10**6 + 1) + PIXELS + END,
    "an impossible depth": header(depth=4) + PIXELS + END,
    "unknown colours": header(colours=5) + PIXELS + END,
    "unknown packing": header(packing=1) + PIXELS + END,
    "an unknown filter": header(filtering=1) + PIXELS + END,
    "an unknown order": header(interlace=2) + PIXELS + END,
    "two headers": header() + header() + PIXELS + END,
    "an unknown chunk": header() + chunk(b"ABCD") + PIXELS + END,
    "a reserved chunk": header() + chunk(b"abcd") + PIXELS + END,
    "no name": header() + chunk(b"a1Cd") + PIXELS + END,
    "no pixels": header() + END,
    "no end": header() + PIXELS,
    "nothing": b"",
}

MOST = 2**26
#: Damage that the crate png passes over; all pixels are there.
PASSED_OVER = {"a reserved chunk", "no name"}
ADAM7 = [
    (0, 0, 8, 8),
    (4, 0, 8, 8),
    (0, 4, 4, 8),
    (2, 0, 4, 4),
    (0, 2, 2, 4),
    (1, 0, 2, 2),
    (0, 1, 1, 2),
]
MAPS = sorted((Path(os.environ.get("ENVLIGHTS_MAPS", "none")) / "hdr").glob("*.hdr"))


def reference(path, kind):
    """Samples of OpenImageIO, with alpha apart from colour."""
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    file = oiio.ImageInput.open(str(path), config)
    return file.read_image(0, 0, 0, file.spec().nchannels, kind)


def png(data, limit=MOST):
    return PictureFile(data, "png", limit)


def samples_of(file):
    (header,) = file.parts
    return file.rows(0, list(range(len(header["channels"]))), 0, header["height"])


def radiance(tmp_path, pixels):
    path = tmp_path / "map.hdr"
    oiio.ImageBuf(np.ascontiguousarray(pixels, np.float32)).write(str(path))
    return path


@pytest.mark.parametrize("path", MAPS, ids=lambda path: path.stem)
def test_real_maps_are_those_of_openimageio(path):
    picture = PictureFile(path.read_bytes(), "radiance", MOST)
    wanted = reference(path, "float")
    assert np.array_equal(samples_of(picture), wanted)
    assert np.array_equal(picture.rows(0, [2, 0], 5, 9), wanted[5:9, :, [2, 0]])


def test_rows_outside_are_refused(tmp_path):
    data = radiance(tmp_path, np.ones((4, 8, 3))).read_bytes()
    picture = PictureFile(data, "radiance", MOST)
    for top, bottom in [(0, 5), (3, 2)]:
        with pytest.raises(EnvLightsError, match="rows must be from 0 to 4"):
            picture.rows(0, [0], top, bottom)
    with pytest.raises(EnvLightsError, match="channels must be below 3; got 3"):
        picture.rows(0, [3], 0, 1)
    with pytest.raises(EnvLightsError, match="part must be below 1; got 1"):
        picture.rows(1, [0], 0, 1)


@pytest.mark.parametrize("subsampling", ["4:4:4", "4:2:0"])
def test_progressive_jpeg_files_are_those_of_openimageio(tmp_path, subsampling):
    """Later scans of OpenImageIO refine coefficients, the first and the others, by a bit each."""
    path = tmp_path / "map.jpg"
    spec = oiio.ImageSpec(45, 21, 3, oiio.UINT8)
    spec.attribute("Compression", "jpeg:95")
    spec.attribute("jpeg:subsampling", subsampling)
    spec.attribute("jpeg:progressive", 1)
    file = oiio.ImageOutput.create(str(path))
    assert file.open(str(path), spec)
    assert file.write_image(np.random.default_rng(3).integers(0, 256, (21, 45, 3), np.uint8))
    file.close()
    samples = samples_of(PictureFile(path.read_bytes(), "jpeg", MOST))
    assert np.array_equal(samples, reference(path, "uint8"))


@pytest.mark.parametrize("interlace", [0, 1])
@pytest.mark.parametrize(("width", "height"), [(1, 1), (5, 9), (33, 17)])
@pytest.mark.parametrize(
    ("colours", "depth"),
    [(0, 1), (0, 2), (0, 4), (0, 8), (0, 16), (2, 8), (2, 16), (4, 8), (4, 16), (6, 8), (6, 16)],
)
def test_each_kind_of_png_is_that_of_openimageio(
    tmp_path, colours, depth, width, height, interlace
):
    rng = np.random.default_rng(depth)
    bits = depth * {0: 1, 2: 3, 4: 2, 6: 4}[colours]
    rows = b""
    for x, y, right, down in ADAM7 if interlace else [(0, 0, 1, 1)]:
        columns = len(range(x, width, right))
        for _ in range(y, height, down) if columns else ():
            rows += b"\0" + rng.bytes((columns * bits + 7) // 8)
    body = chunk(b"IDAT", zlib.compress(rows))
    start = SIGNATURE + header(width, height, depth, colours, interlace=interlace)
    path = tmp_path / "map.png"
    path.write_bytes(start + body + END)
    samples = samples_of(png(path.read_bytes()))
    assert samples.dtype == (np.uint16 if depth == 16 else np.uint8)
    assert np.array_equal(samples, reference(path, str(samples.dtype)))


def test_palettes_and_transparent_colours_are_expanded():
    palette = chunk(b"PLTE", bytes([1, 2, 3, 9, 8, 7])) + chunk(b"tRNS", b"\x40")
    body = chunk(b"IDAT", zlib.compress(b"\0\x40"))
    file = SIGNATURE + header(2, 1, 1, 3) + palette + body + END
    assert samples_of(png(file)).tolist() == [[[1, 2, 3, 64], [9, 8, 7, 255]]]
    grey = chunk(b"tRNS", struct.pack(">H", 5)) + chunk(b"IDAT", zlib.compress(b"\0\5\6"))
    file = SIGNATURE + header(2, 1, 8, 0) + grey + END
    assert samples_of(png(file)).tolist() == [[[5, 0], [6, 255]]]


def test_statements_of_a_png_are_read():
    profile = b"a profile of forty bytes, not a true one"
    numbers = [31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000]
    exif = b"MM\0*" + struct.pack(">IHHHIHHI", 8, 1, 0x112, 3, 1, 6, 0, 0)
    chunks = [
        chunk(b"gAMA", struct.pack(">I", 100000)),
        chunk(b"cHRM", struct.pack(">8I", *numbers)),
        chunk(b"cICP", bytes([9, 16, 0, 1])),
        chunk(b"iCCP", b"name\0\0" + zlib.compress(profile)),
        chunk(b"eXIf", exif),
        chunk(b"oFFs", struct.pack(">2iB", 3, 4, 0)),
        chunk(b"iTXt", b"XML:com.adobe.xmp\0\0\0\0\0<x/>"),
    ]
    (said,) = png(SIGNATURE + header() + b"".join(chunks) + PIXELS + END).parts
    assert (said["orientation"], said["xmp"], said["notes"]) == (6, (b"<x/>",), [])
    assert said["colour"] == {
        "cicp": (9, 16, 0, 1),
        "icc": profile,
        "is_srgb": False,
        "gamma": 1.0,
        "chromaticities": (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329),
        "is_xyz": False,
        "name": "",
    }
    (plain,) = png(SIGNATURE + header() + chunk(b"sRGB", b"\0") + PIXELS + END).parts
    assert (plain["colour"]["is_srgb"], plain["orientation"]) == (True, 1)
    assert (plain["colour"]["gamma"], plain["colour"]["chromaticities"]) == (None, None)


@pytest.mark.parametrize("damage", [name for name in DAMAGED if name not in PASSED_OVER])
def test_damaged_png_files_are_refused(damage):
    chunks = DAMAGED[damage]
    with pytest.raises(EnvLightsError):
        samples_of(png(SIGNATURE + chunks))


@pytest.mark.parametrize("length", [0, 1, 4, 8, 767, 769, 771, 774])
def test_palettes_of_parts_of_a_colour_are_refused(length):
    head = header(depth=8, colours=3) + chunk(b"PLTE", bytes(length))
    body = chunk(b"IDAT", zlib.compress(bytes(2 * 5)))
    with pytest.raises(EnvLightsError, match=f"palette has {length} bytes|damaged: .*PLTE"):
        samples_of(png(SIGNATURE + head + body + END))


def test_sizes_are_limited():
    with pytest.raises(EnvLightsError, match="up to 7 pixels; got 2 rows of 4"):
        png(SIGNATURE + header() + PIXELS + END, 7)


KINDS = {"hdr": "radiance", "png": "png", "exr": "openexr", "jpg": "jpeg", "tif": "tiff"}


@pytest.mark.parametrize("kind", KINDS)
def test_500_damaged_files_give_samples_or_a_sentence(tmp_path, kind):
    rng = np.random.default_rng(40)
    pixels = np.repeat(rng.uniform(0, 1, (12, 8, 3)), 3, axis=1)
    path = tmp_path / f"map.{kind}"
    oiio.ImageBuf(np.float32(pixels)).write(str(path))
    data = path.read_bytes()
    name = KINDS[kind]
    refused = read = 0
    for turn in range(500):
        make = mutations.mutated_png if kind == "png" and turn % 2 else mutations.mutate
        try:
            file = PictureFile(make(data, rng), name, 10**6)
            (said,) = file.parts
            assert samples_of(file).shape[:2] == (said["height"], said["width"])
        except EnvLightsError as error:
            refused += "internal error" not in str(error)
        else:
            read += 1
    assert refused > 100
    assert refused + read == 500


def test_samples_that_are_not_converted_are_no_damage(tmp_path):
    path = tmp_path / "counts.exr"
    spec = oiio.ImageSpec(8, 4, 3, oiio.UINT32)
    file = oiio.ImageOutput.create(str(path))
    assert file.open(str(path), spec)
    assert file.write_image(np.ones((4, 8, 3), np.uint32))
    file.close()
    with pytest.raises(el.FileError, match=r"counts\.exr: its samples are uint; give") as refusal:
        el.EnvMap.open(path)
    assert not isinstance(refusal.value, el.io.DamagedFileError)
