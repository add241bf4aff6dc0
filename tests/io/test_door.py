"""Statements of files on colour, placement, alpha, layers and white, from file to map."""

import io as standard_io
import struct
import sys
import zlib

import numpy as np
import OpenImageIO as oiio  # noqa: N813, its own name for itself
import pytest

import envlights as el
from envlights._common.errors import DamagedFileError, MissingFileError
from envlights._common.srgb import encode_srgb
from envlights.environment.colour.primaries import DISPLAY_P3
from tests.io import profiles
from tests.reference import srgb

HEIGHT, WIDTH = 32, 64
SKY, SUN = 0.1, 0.8
#: Rows and columns of a square sun.
PLACE = (slice(8, 12), slice(20, 24))


def world(sun=SUN):
    radiance = np.full((HEIGHT, WIDTH, 3), SKY)
    radiance[PLACE] = sun
    return radiance


def codes(linear, bits=8):
    return np.rint(encode_srgb(np.asarray(linear)) * (2**bits - 1)).astype(f"u{bits // 8}")


def png(path, samples, *chunks):
    """PNG file with more chunks, (kind, body), before its pixels."""

    def chunk(kind, body):
        check = struct.pack(">I", zlib.crc32(kind + body))
        return struct.pack(">I", len(body)) + kind + body + check

    height, width, channels = samples.shape
    depth = 8 * samples.dtype.itemsize
    colours = {1: 0, 2: 4, 3: 2, 4: 6}[channels]
    big_endian = samples.astype(samples.dtype.newbyteorder(">"))
    rows = zlib.compress(b"".join(b"\0" + row.tobytes() for row in big_endian))
    body = chunk(b"IHDR", struct.pack(">2I5B", width, height, depth, colours, 0, 0, 0))
    body += b"".join(chunk(*one) for one in chunks) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + body)
    return path


def write_file(path, samples, channels=("R", "G", "B"), **attributes):
    """File by OpenImageIO."""
    height, width, count = samples.shape
    spec = oiio.ImageSpec(width, height, count, str(samples.dtype).replace("float32", "float"))
    spec.channelnames = channels
    for name, value in attributes.items():
        spec.attribute(name.replace("__", ":"), value)
    file = oiio.ImageOutput.create(str(path))
    assert file.open(str(path), spec), file.geterror()
    assert file.write_image(np.ascontiguousarray(samples))
    file.close()
    return path


def jpeg(path, linear, xmp=None, **attributes):
    write_file(path, codes(linear), Compression="jpeg:100", **attributes)
    if xmp:
        said = " ".join(f'GPano:{key}="{value}"' for key, value in xmp.items())
        packet = (
            b"http://ns.adobe.com/xap/1.0/\0"
            b'<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF'
            b' xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#"><rdf:Description'
            b' xmlns:GPano="http://ns.google.com/photos/1.0/panorama/" '
            + said.encode()
            + b"/></rdf:RDF></x:xmpmeta>"
        )
        data = path.read_bytes()
        segment = b"\xff\xe1" + struct.pack(">H", len(packet) + 2) + packet
        path.write_bytes(data[:2] + segment + data[2:])
    return path


def radiance_file(path, linear, *lines, form="32-bit_rle_rgbe", order="-Y {0} +X {1}"):
    """Radiance picture with flat pixels."""
    exponent = np.floor(np.log2(linear.max(axis=2))) + 1
    pixels = np.rint(linear * 2 ** (8 - exponent[..., None])).clip(0, 255)
    rgbe = np.dstack([pixels, exponent + 128]).astype(np.uint8)
    height, width, _ = linear.shape
    head = ["#?RADIANCE", *lines, f"FORMAT={form}", "", order.format(height, width), ""]
    path.write_bytes("\n".join(head).encode() + rgbe.tobytes())
    return path


def sun_of(env):
    return np.unravel_index(env.radiance.sum(axis=2).argmax(), env.radiance.shape[:2])


# Colour


def test_png_chunks_decide_on_the_curve(tmp_path):
    linear = np.rint(world() * 65535).astype(np.uint16)
    gamma = struct.pack(">I", 100000)
    for chunk in [(b"gAMA", gamma), (b"cICP", bytes([1, 8, 0, 1]))]:
        env = el.EnvMap.open(png(tmp_path / "a.png", linear, chunk))
        np.testing.assert_allclose(env.radiance[20, 5], SKY, rtol=1e-3)
    power = np.rint(world() ** (1 / 1.8) * 65535).astype(np.uint16)
    env = el.EnvMap.open(png(tmp_path / "b.png", power, (b"gAMA", struct.pack(">I", 55556))))
    np.testing.assert_allclose(env.radiance[20, 5], SKY, rtol=1e-3)
    env = el.EnvMap.open(png(tmp_path / "c.png", codes(world(), 16)))
    np.testing.assert_allclose(env.radiance[20, 5], SKY, rtol=1e-3)


@pytest.mark.parametrize("suffix", [".jpg", ".tif", ".png"])
def test_icc_profiles_of_every_format_are_applied(tmp_path, suffix):
    icc = np.frombuffer(profiles.rgb(profiles.SRGB, DISPLAY_P3), np.uint8)
    spec = oiio.ImageSpec(WIDTH, HEIGHT, 3, "uint8")
    spec.attribute("ICCProfile", oiio.TypeDesc(f"uint8[{len(icc)}]"), icc)
    spec.attribute("Compression", "jpeg:100" if suffix == ".jpg" else "zip")
    path = tmp_path / f"p3{suffix}"
    file = oiio.ImageOutput.create(str(path))
    file.open(str(path), spec)
    file.write_image(codes(world((0.9, 0.1, 0.1))))
    file.close()
    sun = el.EnvMap.open(path).radiance[9, 21]
    np.testing.assert_allclose(sun, (1.080, 0.066, 0.084), atol=0.03)


def test_a_colour_space_by_hand_replaces_that_of_the_file(tmp_path):
    path = png(tmp_path / "a.png", np.rint(world() * 65535).astype(np.uint16))
    env = el.EnvMap.open(path, colour="linear")
    np.testing.assert_allclose(env.radiance[20, 5], SKY, rtol=1e-3)
    with pytest.raises(el.EnvLightsError, match="colour"):
        el.EnvMap.open(path, colour="no such space")


# Radiance headers


def test_exposure_and_colour_correction_are_divided_out(tmp_path):
    lines = ["EXPOSURE=0.5", "pfilt -e 0.2", "EXPOSURE=0.2", "COLORCORR=1 2 4", "EXPOSURE=0"]
    env = el.EnvMap.open(radiance_file(tmp_path / "a.hdr", world(), *lines))
    np.testing.assert_allclose(env.radiance[20, 5], SKY / np.array([0.1, 0.2, 0.4]), rtol=0.01)


def test_xyz_pixels_are_converted(tmp_path):
    # XYZ of the white of Rec.709.
    white = np.array([0.9505, 1.0, 1.0891])
    xyz = world()[..., :1] * white
    env = el.EnvMap.open(radiance_file(tmp_path / "a.hdr", xyz, form="32-bit_rle_xyze"))
    np.testing.assert_allclose(env.radiance[20, 5], SKY, rtol=0.02)


@pytest.mark.parametrize(
    ("order", "place"),
    [
        ("-Y {0} +X {1}", (8, 20)),
        ("+Y {0} +X {1}", (HEIGHT - 12, 20)),
        ("-Y {0} -X {1}", (8, WIDTH - 24)),
        ("+Y {0} -X {1}", (HEIGHT - 12, WIDTH - 24)),
    ],
)
def test_the_order_of_pixels_turns_the_map(tmp_path, order, place):
    env = el.EnvMap.open(radiance_file(tmp_path / "a.hdr", world(), order=order))
    assert sun_of(env) == place


def test_a_picture_without_a_format_or_with_another_is_refused(tmp_path):
    path = radiance_file(tmp_path / "a.hdr", world(), form="16-bit")
    with pytest.raises(DamagedFileError, match="16-bit"):
        el.EnvMap.open(path)
    path.write_bytes(path.read_bytes().replace(b"FORMAT=16-bit\n", b""))
    with pytest.raises(DamagedFileError, match="FORMAT"):
        el.EnvMap.open(path)


# Placement


def test_a_page_offset_moves_nothing(tmp_path):
    offset = (b"oFFs", struct.pack(">2iB", 20, 5, 0))
    assert sun_of(el.EnvMap.open(png(tmp_path / "a.png", codes(world()), offset))) == (8, 20)
    path = write_file(tmp_path / "a.tif", codes(world()), XPosition=7.0, YPosition=3.0)
    assert sun_of(el.EnvMap.open(path)) == (8, 20)


CROP = {
    "ProjectionType": "equirectangular",
    "FullPanoWidthPixels": 2 * WIDTH,
    "FullPanoHeightPixels": 2 * HEIGHT,
    "CroppedAreaImageWidthPixels": WIDTH,
    "CroppedAreaImageHeightPixels": HEIGHT,
    "CroppedAreaLeftPixels": WIDTH // 2,
    "CroppedAreaTopPixels": HEIGHT // 2,
}


@pytest.mark.parametrize("scale", [1, 2])
def test_a_crop_lies_where_its_numbers_say(tmp_path, scale):
    """Numbers of a picture that was later made smaller are scaled with it."""
    numbers = {k: v if isinstance(v, str) else scale * v for k, v in CROP.items()}
    env = el.EnvMap.open(jpeg(tmp_path / "a.jpg", world(), numbers))
    assert (env.width, env.height) == (2 * WIDTH, 2 * HEIGHT)
    row, column = sun_of(env)
    assert (row - HEIGHT // 2) in range(8, 12)
    assert (column - WIDTH // 2) in range(20, 24)
    # Half of the columns, and the rows from 45 degrees to -45.
    assert env.coverage_fraction == pytest.approx(0.5 * np.sin(np.pi / 4), rel=1e-6)
    assert env.radiance[0].max() == 0


@pytest.mark.parametrize(
    "changes",
    [
        {"CroppedAreaImageWidthPixels": 2 * WIDTH, "CroppedAreaImageHeightPixels": 2 * HEIGHT},
        {"CroppedAreaImageHeightPixels": HEIGHT // 2},
        {"CroppedAreaLeftPixels": 10 * WIDTH},
        {"FullPanoHeightPixels": "unknown"},
    ],
)
def test_stale_numbers_of_a_crop_change_nothing(tmp_path, changes):
    env = el.EnvMap.open(jpeg(tmp_path / "a.jpg", world(), CROP | changes))
    assert (env.width, env.coverage_fraction) == (WIDTH, 1.0)


@pytest.mark.parametrize("projection", ["cylindrical", "fisheye", "mercator", "cubemap"])
def test_other_projections_are_named(tmp_path, projection):
    path = jpeg(tmp_path / "a.jpg", world(), {"ProjectionType": projection})
    with pytest.raises(el.EnvLightsError, match=projection):
        el.EnvMap.open(path)


@pytest.mark.parametrize("orientation", range(1, 9))
def test_all_orientations_of_exif_give_the_same_map(tmp_path, orientation):
    upright = world()
    stored = {
        1: upright,
        2: upright[:, ::-1],
        3: upright[::-1, ::-1],
        4: upright[::-1],
        5: upright.transpose(1, 0, 2),
        6: np.rot90(upright, 1),
        7: np.rot90(upright, 2).transpose(1, 0, 2),
        8: np.rot90(upright, -1),
    }
    path = write_file(tmp_path / "a.tif", codes(stored[orientation]), Orientation=orientation)
    assert sun_of(el.EnvMap.open(path)) == (8, 20)


# Alpha


def hole(bits=8):
    samples = np.dstack([codes(world(), bits), np.full((HEIGHT, WIDTH), 2**bits - 1)])
    samples[24:, :, :3] = 2**bits - 1
    samples[24:, :, 3] = 0
    return samples.astype(f"u{bits // 8}")


@pytest.mark.parametrize("bits", [8, 16])
def test_light_under_a_transparent_pixel_is_not_light(tmp_path, bits):
    env = el.EnvMap.open(png(tmp_path / "a.png", hole(bits)))
    assert env.radiance[24:].max() == 0
    np.testing.assert_allclose(env.radiance[20, 5], SKY, rtol=0.02)
    assert env.coverage_fraction == pytest.approx((1 + np.sqrt(0.5)) / 2, rel=1e-6)
    # An array of the same samples is the same map.
    assert el.EnvMap(hole(bits)) == env


def test_a_transparent_colour_of_png_is_not_light(tmp_path):
    samples = codes(world())
    samples[24:] = 255
    white = (b"tRNS", struct.pack(">3H", 255, 255, 255))
    env = el.EnvMap.open(png(tmp_path / "a.png", samples, white))
    assert env.radiance[24:].max() == 0
    assert env.coverage_fraction < 1


def test_openexr_keeps_light_at_alpha_0(tmp_path):
    samples = np.dstack([world(), np.zeros((HEIGHT, WIDTH))]).astype(np.float32)
    env = el.EnvMap.open(write_file(tmp_path / "a.exr", samples, ("R", "G", "B", "A")))
    np.testing.assert_allclose(env.radiance, world(), rtol=1e-6)
    assert env.coverage_fraction == 1


# Layers


@pytest.mark.parametrize(
    "prefix", ["ViewLayer.Combined.", "rgba.", "beauty.", "C.", "Composite.Combined."]
)
def test_the_picture_is_found_among_layers_by_its_name(tmp_path, prefix):
    names = [f"{layer}{c}" for layer in ("N.", prefix, "albedo.") for c in "RGB"]
    samples = np.concatenate([0 * world(), world(), 0 * world() + 0.5], axis=2)
    path = write_file(tmp_path / "a.exr", samples.astype(np.float32), names)
    env = el.EnvMap.open(path)
    np.testing.assert_allclose(env.radiance, world(), rtol=1e-6)
    by_hand = el.EnvMap.open(path, part="albedo").radiance
    np.testing.assert_allclose(by_hand, 0.5, rtol=1e-6)


@pytest.mark.parametrize("names", ["red green blue", "r g b", "Red Green Blue"])
def test_spelt_out_channels_are_colours(tmp_path, names):
    names = names.split()
    path = write_file(tmp_path / "a.exr", world((3, 2, 1)).astype(np.float32), names)
    np.testing.assert_allclose(el.EnvMap.open(path).radiance[9, 21], (3, 2, 1))


def test_layers_without_a_picture_are_listed(tmp_path):
    names = [f"{layer}.{c}" for layer in ("normal", "albedo") for c in "RGB"]
    samples = np.concatenate([world(), world()], axis=2).astype(np.float32)
    path = write_file(tmp_path / "a.exr", samples, names)
    with pytest.raises(el.EnvLightsError, match=r"albedo, normal; choose one with part="):
        el.EnvMap.open(path)


# Sources and kinds


def test_bytes_file_objects_and_standard_input_are_read(tmp_path, monkeypatch):
    path = radiance_file(tmp_path / "a.hdr", world())
    env = el.EnvMap.open(path)
    assert el.EnvMap.open(path.read_bytes()) == env
    with path.open("rb") as file:
        assert el.EnvMap.open(file) == env
    standard_input = standard_io.TextIOWrapper(standard_io.BytesIO(path.read_bytes()))
    monkeypatch.setattr(sys, "stdin", standard_input)
    assert el.EnvMap.open("-") == env


def test_the_first_bytes_decide_and_not_the_suffix(tmp_path):
    env = el.EnvMap.open(radiance_file(tmp_path / "a.png", world()))
    np.testing.assert_allclose(env.radiance, world(), rtol=0.01)
    write_file(tmp_path / "b.bmp", codes(world())).rename(tmp_path / "b.hdr")
    with pytest.raises(el.EnvLightsError, match="BMP image, which is read only with any_format"):
        el.EnvMap.open(tmp_path / "b.hdr")


def test_missing_files_are_missing_files(tmp_path):
    with pytest.raises(FileNotFoundError, match="no such file"):
        el.EnvMap.open(tmp_path / "none.hdr")
    assert issubclass(MissingFileError, el.EnvLightsError)


# White


@pytest.mark.parametrize("white", [235, 250])
def test_a_picture_that_ends_below_255_is_clipped_there(tmp_path, white):
    """A sun with a glow, so that the largest code is a plateau."""
    y, x = np.mgrid[0:128, 0:256]
    away = np.hypot(y - 40, x - 90)
    linear = (0.2 + 40 * np.exp(-away / 4))[..., None] * np.ones(3)
    path = png(tmp_path / "a.png", np.minimum(codes(linear), white))
    env = el.EnvMap.open(path)
    assert env.clip_level == pytest.approx(srgb.decode(white / 255), rel=1e-3)
    assert any(f"clipped at code {white}" in note for note in env.notes)
    rig = el.fit(path)
    assert rig.notes == el.fit(env).notes
