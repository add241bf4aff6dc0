"""Image files of all kinds: read, cleaned or refused."""

import os
import struct
import zlib

import numpy as np
import OpenImageIO as oiio  # noqa: N813, its own name for itself
import pytest

import envlights as el
from envlights import io
from envlights._common.srgb import decode_srgb
from tests.conftest import real_maps
from tests.helpers import EQUIRECTANGULAR
from tests.reference import srgb

RADIANCE = np.random.default_rng(1).gamma(0.5, 2.0, size=(16, 32, 3)).astype(np.float32)


def write(path, pixels, file_format=oiio.FLOAT, **attributes):
    height, width, channels = pixels.shape
    spec = oiio.ImageSpec(width, height, channels, file_format)
    for name, value in attributes.items():
        if name == "channelnames":
            spec.channelnames = value
        elif name == "tile":
            spec.tile_width = spec.tile_height = value
        else:
            spec.attribute(name.replace("__", ":"), value)
    file = oiio.ImageOutput.create(str(path))
    assert file.open(str(path), spec), file.geterror()
    assert file.write_image(np.ascontiguousarray(pixels)), file.geterror()
    file.close()
    return path


@pytest.mark.parametrize(
    ("name", "file_format", "attributes", "rtol"),
    [
        ("map.exr", oiio.FLOAT, {}, 0),
        ("map.exr", oiio.HALF, {}, 1e-3),
        ("map.exr", oiio.FLOAT, {"tile": 16}, 0),
        ("map.tif", oiio.FLOAT, {}, 0),
    ],
)
def test_linear_files_are_read_as_they_are(tmp_path, name, file_format, attributes, rtol):
    env = el.EnvMap.open(write(tmp_path / name, RADIANCE, file_format, **attributes))
    np.testing.assert_allclose(env.radiance, RADIANCE, rtol=rtol, atol=1e-7 if rtol else 0)
    assert env.notes == ()
    assert env.registration == "cell-centred"


@pytest.mark.parametrize("rle", [0, 1])
def test_radiance_files_keep_their_shared_exponent(tmp_path, rle):
    path = write(tmp_path / "map.hdr", RADIANCE, rgbe__rle=rle)
    brightest = RADIANCE.max(axis=2, keepdims=True)
    difference = np.abs(el.EnvMap.open(path).radiance - RADIANCE)
    assert (difference <= brightest / 128).all()


@pytest.mark.parametrize(
    ("name", "file_format", "steps"),
    [
        ("map.png", oiio.UINT8, 255),
        ("map.png", oiio.UINT16, 65535),
        ("map.tif", oiio.UINT16, 65535),
    ],
)
def test_integer_files_are_linearised_from_srgb(tmp_path, name, file_format, steps):
    linear = np.linspace(0, 1, 16 * 32 * 3).reshape(16, 32, 3)
    env = el.EnvMap.open(
        write(tmp_path / name, srgb.encode(linear).astype(np.float32), file_format)
    )
    # Half a code, times the steepest slope of the curve.
    np.testing.assert_allclose(env.radiance, linear, atol=0.5 * 2.3 / steps)
    assert "sRGB" in env.notes[0]


def test_jpeg_is_read(tmp_path):
    grey = np.full((16, 32, 3), srgb.encode(0.25), np.float32)
    env = el.EnvMap.open(write(tmp_path / "map.jpg", grey, oiio.UINT8))
    np.testing.assert_allclose(env.radiance, 0.25, atol=0.01)


@pytest.mark.parametrize(("name", "file_format"), [("a.exr", oiio.FLOAT), ("a.png", oiio.UINT8)])
def test_straight_alpha_is_the_share_that_is_seen_and_premultiplied_keeps_light(
    tmp_path, name, file_format
):
    pixels = np.full((16, 32, 4), 0.5, np.float32)
    env = el.EnvMap.open(write(tmp_path / name, pixels, file_format, oiio__UnassociatedAlpha=1))
    is_straight = file_format == oiio.UINT8
    expected = decode_srgb(np.array(128 / 255)) * 128 / 255 if is_straight else 0.5
    np.testing.assert_allclose(env.radiance, expected, rtol=1e-3)
    assert env.coverage_fraction == pytest.approx(128 / 255 if is_straight else 1.0)


def test_extra_channels_are_ignored_and_noted(tmp_path):
    pixels = np.concatenate([RADIANCE, np.full((16, 32, 1), 9, np.float32)], axis=2)
    path = write(tmp_path / "z.exr", pixels, channelnames=("R", "G", "B", "Z"))
    env = el.EnvMap.open(path)
    np.testing.assert_array_equal(env.radiance, RADIANCE)
    assert "other channels were ignored: Z" in env.notes


def test_a_single_channel_is_grey(tmp_path):
    path = write(tmp_path / "y.exr", RADIANCE[..., :1], channelnames=("Y",))
    env = el.EnvMap.open(path)
    np.testing.assert_array_equal(env.radiance, np.repeat(RADIANCE[..., :1], 3, axis=2))
    assert "the only channel, Y, was read as grey" in env.notes


def test_only_the_first_of_several_images_is_read_and_noted(tmp_path):
    spec = oiio.ImageSpec(32, 16, 3, oiio.FLOAT)
    file = oiio.ImageOutput.create(str(tmp_path / "parts.exr"))
    assert file.open(str(tmp_path / "parts.exr"), (spec, spec))
    assert file.write_image(RADIANCE)
    assert file.open(str(tmp_path / "parts.exr"), spec, "AppendSubimage")
    assert file.write_image(2 * RADIANCE)
    file.close()
    env = el.EnvMap.open(tmp_path / "parts.exr")
    np.testing.assert_array_equal(env.radiance, RADIANCE)
    assert env.notes == ("only the first of several images in the file was read",)


def test_a_small_data_window_is_set_into_black(tmp_path):
    spec = oiio.ImageSpec(16, 8, 3, oiio.FLOAT)
    spec.x, spec.y, spec.full_width, spec.full_height = 4, 2, 32, 16
    file = oiio.ImageOutput.create(str(tmp_path / "window.exr"))
    assert file.open(str(tmp_path / "window.exr"), spec)
    assert file.write_image(np.ascontiguousarray(RADIANCE[2:10, 4:20]))
    file.close()
    env = el.EnvMap.open(tmp_path / "window.exr")
    expected = np.zeros_like(RADIANCE)
    expected[2:10, 4:20] = RADIANCE[2:10, 4:20]
    np.testing.assert_array_equal(env.radiance, expected)
    assert "(4, 2, 16, 8) was placed in the display window (0, 0, 32, 16)" in env.notes[0]


def radiance_bytes(codes, resolution, *variables):
    """A Radiance file without run lengths; every pixel is codes / 256."""
    header = "\n".join(["#?RADIANCE", "FORMAT=32-bit_rle_rgbe", *variables, "", resolution, ""])
    return header.encode() + np.insert(codes, 3, 128, axis=2).tobytes()


@pytest.mark.parametrize(
    ("resolution", "rows", "columns"),
    [
        ("-Y 16 +X 32", 1, 1),
        ("-Y 16 -X 32", 1, -1),
        ("+Y 16 +X 32", -1, 1),
        ("+Y 16 -X 32", -1, -1),
    ],
)
def test_maps_stored_upside_down_or_mirrored_are_turned_upright(
    tmp_path, resolution, rows, columns
):
    codes = np.random.default_rng(2).integers(1, 256, (16, 32, 3), dtype=np.uint8)
    (tmp_path / "map.hdr").write_bytes(radiance_bytes(codes[::rows, ::columns], resolution))
    env = el.EnvMap.open(tmp_path / "map.hdr")
    np.testing.assert_array_equal(env.radiance, codes / np.float32(256))
    assert any("rotated or mirrored by the orientation" in note for note in env.notes) == (
        rows + columns < 2
    )


@pytest.mark.parametrize("variables", [("PRIMARIES=0 0 0 0 0 0 0 0", "GAMMA=1"), ("GAMMA=2.2",)])
def test_primaries_and_gamma_of_radiance_headers_are_not_applied(tmp_path, variables):
    codes = np.full((16, 32, 3), 64, np.uint8)
    (tmp_path / "map.hdr").write_bytes(radiance_bytes(codes, "-Y 16 +X 32", *variables))
    env = el.EnvMap.open(tmp_path / "map.hdr")
    assert (env.radiance == 0.25).all()
    assert env.notes == ()


def test_the_envmap_attribute_says_where_pixels_lie_and_can_be_overruled(tmp_path):
    path = write(tmp_path / "env.exr", RADIANCE, textureformat="LatLong Environment")
    assert el.EnvMap.open(path).registration == "border-sampled"
    assert (
        el.EnvMap.open(path, layout=el.io.Layout(registration="cell-centred")).registration
        == "cell-centred"
    )


def test_exr_round_trip_is_exact(tmp_path):
    io.write_exr(tmp_path / "map.exr", RADIANCE)
    np.testing.assert_array_equal(el.EnvMap.open(tmp_path / "map.exr").radiance, RADIANCE)
    assert [path.name for path in tmp_path.iterdir()] == ["map.exr"]


def write_deep(path):
    spec = oiio.ImageSpec(32, 16, 3, oiio.FLOAT)
    spec.deep = True
    samples = oiio.DeepData()
    samples.init(spec)
    file = oiio.ImageOutput.create(str(path))
    assert file.open(str(path), spec), file.geterror()
    assert file.write_deep_image(samples), file.geterror()
    file.close()


def write_window(path, width, height):
    """A file of few pixels whose display window is large."""
    spec = oiio.ImageSpec(32, 16, 3, oiio.FLOAT)
    spec.full_width, spec.full_height = width, height
    file = oiio.ImageOutput.create(str(path))
    assert file.open(str(path), spec), file.geterror()
    assert file.write_image(RADIANCE), file.geterror()
    file.close()


def broken_files(folder):
    """Path and words of the refusal."""
    whole = write(folder / "whole.exr", RADIANCE.repeat(8, 0).repeat(8, 1)).read_bytes()
    (folder / "empty.exr").write_bytes(b"")
    (folder / "text.hdr").write_text("this is no picture\n")
    header = bytearray(write(folder / "header.exr", RADIANCE).read_bytes())
    header[header.index(b"chlist")] = 0xFF
    (folder / "header.exr").write_bytes(header)
    (folder / "truncated.exr").write_bytes(whole[: len(whole) // 2])
    write(folder / "square.exr", RADIANCE[:, :16])
    write(folder / "two.exr", RADIANCE[..., :2], channelnames=("R", "B"))
    write(folder / "cube.exr", RADIANCE, textureformat="CubeFace Environment")
    write(folder / "luminance.exr", RADIANCE, channelnames=("Y", "RY", "BY"))
    write(folder / "counts.tif", RADIANCE / RADIANCE.max(), oiio.UINT32)
    write(folder / "side.jpg", np.ones((16, 32, 3), np.float32), oiio.UINT8, Orientation=6)
    write_deep(folder / "deep.exr")
    write_window(folder / "vast.exr", 100_000, 50_000)
    picture = write(folder / "whole.png", RADIANCE.clip(0, 1), oiio.UINT8).read_bytes()
    (folder / "truncated.png").write_bytes(picture[: len(picture) // 2])
    (folder / "flipped.png").write_bytes(picture[:-40] + bytes([picture[-40] ^ 1]) + picture[-39:])
    return {
        "missing.exr": "no such file",
        "x" * 300 + ".exr": "name too long",
        "": "it is a folder",
        "empty.exr": "the file is empty",
        "text.hdr": "cannot read",
        "header.exr": "its header is damaged",
        "truncated.exr": "cannot read all pixels",
        "square.exr": "twice as wide as high; got 16x16",
        "two.exr": "it needs R, G and B, or a single channel",
        "cube.exr": "cube map",
        "luminance.exr": r"luminance and chroma \(Y, RY, BY\), which are not converted",
        "counts.tif": "its samples are uint; give floating point, uint8 or uint16",
        "side.jpg": "twice as wide as high; got 16x32 pixels",
        "deep.exr": "it is a deep image",
        "vast.exr": "up to 536870912 pixels; got 50000 rows of 100000",
        "truncated.png": "the PNG file is incomplete",
        "flipped.png": "the PNG file is damaged",
    }


def test_broken_files_are_refused_in_one_sentence_that_names_them(tmp_path, capfd):
    for name, message in broken_files(tmp_path).items():
        with pytest.raises(el.EnvLightsError, match=message) as refusal:
            el.EnvMap.open(tmp_path / name)
        assert str(tmp_path / name) in str(refusal.value)
        assert "\n" not in str(refusal.value)
    assert capfd.readouterr() == ("", ""), "an image library wrote to the terminal"


@pytest.mark.parametrize(
    ("path", "message"),
    [
        (3, "a path must be text, or the bytes of a file; got int"),
        (None, "a path must be text, or the bytes of a file; got NoneType"),
        ("", "cannot read an empty path"),
        ("two\nlines.exr", r"cannot read two\\nlines.exr: there is no such file"),
        ("nul\0.exr", r"cannot read nul\\x00.exr"),
        (os.devnull, "it is not a regular file"),
    ],
)
def test_paths_that_name_no_file_are_refused(path, message):
    with pytest.raises(el.EnvLightsError, match=message) as refusal:
        el.EnvMap.open(path)
    assert "\n" not in str(refusal.value)


def test_a_header_that_claims_too_much_is_refused_before_memory_is_taken(tmp_path):
    header = b"IHDR" + struct.pack(">IIBBBBB", 100_000, 50_000, 8, 2, 0, 0, 0)
    chunks = [header, b"IDAT" + zlib.compress(b"\0"), b"IEND"]
    body = b"".join(
        struct.pack(">I", len(chunk) - 4) + chunk + struct.pack(">I", zlib.crc32(chunk))
        for chunk in chunks
    )
    (tmp_path / "claim.png").write_bytes(b"\x89PNG\r\n\x1a\n" + body)
    with pytest.raises(el.EnvLightsError, match="cannot read"):
        el.EnvMap.open(tmp_path / "claim.png")


@real_maps(*EQUIRECTANGULAR, all_quick=True)
def test_real_maps_open_clean(path):
    env = el.EnvMap.open(path)
    assert np.isfinite(env.radiance).all()
    assert (env.radiance >= 0).all()
    expected = "border-sampled" if "LatLong" in path.name else "cell-centred"
    assert env.registration == expected


@real_maps(
    "loader_tests/damaged/*",
    "loader_tests/*YC.exr",
    "loader_tests/*Trunks.exr",  # a deep image
    all_quick=True,
)
def test_damaged_and_other_files_are_refused(path):
    with pytest.raises(el.EnvLightsError, match=r"cannot read|it needs R, G and B") as refusal:
        el.EnvMap.open(path)
    assert "\n" not in str(refusal.value)


@real_maps(
    "loader_tests/[!Cv]*.exr", "loader_tests/*709.exr", "loader_tests/*XYZ.exr", all_quick=True
)
def test_odd_files_are_read_whole(path):
    image = io.read_image(path)
    assert image.pixels.ndim == 3
    assert image.pixels.shape[2] == 3
    assert image.pixels.dtype == np.float32


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("VIEW= -vtv -vp 0 0 0 -vd 0 1 0 -vh 90 -vv 45", "a perspective (VIEW -vtv)"),
        ("VIEW= -vp 0 0 0 -vth -vh 180", "a hemispherical fisheye (VIEW -vth)"),
        ("VIEW=-vta -vh 180 -vv 180", "an angular fisheye (VIEW -vta)"),
        ("\tVIEW= -vtv -vh 90", ""),
        ("VIEW= -vh 90 -vv 45", "a perspective (VIEW -vtv)"),
        ("VIEW= -vtv -vh 90\nVIEW= -vh 90 -vtl", "a parallel projection (VIEW -vtl)"),
        ("VIEW= -vp 0 0 0", ""),
    ],
)
def test_the_view_of_a_radiance_header_is_noted(tmp_path, line, said):
    path = tmp_path / "view.hdr"
    head = f"#?RADIANCE\n{line}\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n"
    path.write_bytes(head.encode() + bytes([9, 9, 9, 129]) * 32)
    notes = " ".join(el.EnvMap.open(path).notes)
    assert said in notes if said else "VIEW" not in notes
