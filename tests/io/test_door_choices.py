"""Parts, channels, signatures and refusals of the door, each with what a caller reads."""

import json

import numpy as np
import OpenImageIO as oiio  # noqa: N813, its own name for itself
import pytest
from click.testing import CliRunner

import envlights as el
from envlights._common.errors import DamagedFileError
from envlights.cli import main
from tests.io.test_door import codes, jpeg, png, radiance_file, world, write_file

NORMALS = np.broadcast_to([0.0, 1.0, 0.0], world().shape)


def parts_file(path, *parts):
    """OpenEXR file of parts: name, samples, stereo view."""
    specs = []
    for name, samples, view in parts:
        spec = oiio.ImageSpec(*samples.shape[1::-1], samples.shape[2], "float")
        spec.channelnames = ("R", "G", "B") if samples.shape[2] == 3 else ("Z",)
        for key, value in (("oiio:subimagename", name), ("view", view)):
            if value:
                spec.attribute(key, value)
        specs.append(spec)
    file = oiio.ImageOutput.create(str(path))
    assert file.open(str(path), tuple(specs)), file.geterror()
    for number, (_, samples, _) in enumerate(parts):
        if number:
            assert file.open(str(path), specs[number], "AppendSubimage"), file.geterror()
        assert file.write_image(np.ascontiguousarray(samples, dtype=np.float32)), file.geterror()
    file.close()
    return path


def layers_file(path, **layers):
    names = [f"{name}.{c}" for name in layers for c in "RGB"]
    samples = np.concatenate(list(layers.values()), axis=2).astype(np.float32)
    return write_file(path, samples, names)


@pytest.mark.parametrize(
    ("parts", "note"),
    [
        ([("N", NORMALS, ""), ("albedo", NORMALS, ""), ("C", world(), "")], "the layer C was read"),
        ([("normals", NORMALS, ""), ("beauty", world(), "")], "the layer beauty was read"),
        ([("diffuse", NORMALS, ""), ("rgba", world(), "")], "others are diffuse"),
        ([("depth", NORMALS[..., :1], ""), ("rgba", world(), "")], "number 1, from 0, of several"),
        ([("", world(), ""), ("", NORMALS, "")], "only the first of several"),
        (
            [("rgba.right", NORMALS, "right"), ("rgba.left", world(), "left")],
            "the view left was read; others are right",
        ),
    ],
)
def test_the_part_of_the_picture_is_found_by_its_name(tmp_path, parts, note):
    env = el.EnvMap.open(parts_file(tmp_path / "parts.exr", *parts))
    np.testing.assert_allclose(env.radiance, world(), rtol=1e-6)
    assert note in " ".join(env.notes)


def test_stereo_views_are_known_by_the_attribute_of_a_part_or_by_words_of_its_layers(tmp_path):
    by_part = [("ci", NORMALS, "right"), ("C", world(), "left")]
    by_words = {"rgba.right": NORMALS, "left.rgba": world()}
    for path in (
        parts_file(tmp_path / "parts.exr", *by_part),
        layers_file(tmp_path / "layers.exr", **by_words),
    ):
        np.testing.assert_allclose(el.EnvMap.open(path).radiance, world(), rtol=1e-6)


def test_a_composite_comes_before_a_layer_of_blender_and_after_beauty(tmp_path):
    composite, layer = "Composite.Combined", "ViewLayer.Combined"
    for first, second in ((composite, layer), ("beauty", composite), ("beauty", layer)):
        path = layers_file(tmp_path / "layers.exr", **{second: NORMALS, first: world()})
        env = el.EnvMap.open(path)
        np.testing.assert_allclose(env.radiance, world(), rtol=1e-6)
        assert f"the layer {first} was read" in " ".join(env.notes)


@pytest.mark.parametrize(
    "layers",
    [
        {"diffuse": NORMALS, "specular": world()},
        {"Sky.Combined": NORMALS, "Sun.Combined": world()},
        {"key.beauty": NORMALS, "fill.beauty": world()},
        {"Sky.rgba": NORMALS, "Sun.rgba": world()},
    ],
)
def test_several_candidates_are_listed_and_one_is_chosen_by_hand(tmp_path, layers):
    path = layers_file(tmp_path / "layers.exr", **layers)
    first, second = sorted(layers)
    with pytest.raises(el.EnvLightsError, match=f"may be the picture: {first}, {second}; choose"):
        el.EnvMap.open(path)
    for name, samples in layers.items():
        np.testing.assert_allclose(el.EnvMap.open(path, part=name).radiance, samples, rtol=1e-6)
        by_hand = el.EnvMap.open(path, channels=[f"{name}.{c}" for c in "RGB"])
        np.testing.assert_allclose(by_hand.radiance, samples, rtol=1e-6)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"part": "none"}, "there is no part 'none'; it has"),
        ({"part": 7}, "there is no part 7"),
        ({"part": -1}, "there is no part -1"),
        ({"channels": "X,Y,Z"}, "it has not all of the channels X, Y, Z; it has R, G, B"),
        ({"channels": 3}, "channels must be the names of channels; got int"),
        ({"channels": []}, "got none"),
        ({"channels": "R,G,B,A,Z"}, "got 'R', 'G', 'B', 'A', 'Z'"),
        ({"channels": [1, 2, 3]}, "got 1, 2, 3"),
    ],
)
def test_a_choice_that_the_file_does_not_have_is_refused(tmp_path, options, message):
    path = png(tmp_path / "a.png", codes(world()))
    with pytest.raises(el.EnvLightsError, match=message):
        el.EnvMap.open(path, **options)


def test_pages_of_a_tiff_are_noted_and_chosen_by_number(tmp_path):
    path, spec = str(tmp_path / "pages.tif"), oiio.ImageSpec(*world().shape[1::-1], 3, "uint8")
    file = oiio.ImageOutput.create(path)
    for mode, samples in (("Create", world()), ("AppendSubimage", 0 * world())):
        assert file.open(path, spec, mode)
        assert file.write_image(codes(samples))
    file.close()
    env = el.EnvMap.open(path)
    assert env.radiance.any()
    assert "only the first of several images in the file was read" in env.notes
    assert not el.EnvMap.open(path, part=1).radiance.any()


@pytest.mark.parametrize(
    ("start", "look"),
    [
        (b"GIF89a", "a GIF image, which is read only with any_format=True"),
        (b"RIFF\0\0\0\0WEBPVP8 ", "a WebP image"),
        (b"8BPS", "a Photoshop file"),
        (b"\0\0\0\x18ftypheic", "a HEIC image"),
        (b"DDS ", "a DDS texture"),
        (b"version https://git-lfs.github.com/spec/v1", "a pointer of Git LFS"),
        (b"<!DOCTYPE html>", "a web page; give a Radiance"),
        (b"\x93NUMPY", "a NumPy array"),
        (b"no picture", "no known image; give .* or any_format=True"),
    ],
)
@pytest.mark.parametrize("suffix", ["exr", "hdr"])
def test_other_kinds_are_named_whatever_their_suffix(tmp_path, start, look, suffix):
    path = tmp_path / f"a.{suffix}"
    path.write_bytes(start + bytes(64))
    with pytest.raises(el.EnvLightsError, match=look):
        el.EnvMap.open(path)


@pytest.mark.parametrize("suffix", ["bmp", "tga", "gif"])
def test_other_kinds_are_read_on_request(tmp_path, suffix):
    path = write_file(tmp_path / f"a.{suffix}", codes(world(1.0)))
    env = el.EnvMap.open(path, any_format=True)
    np.testing.assert_allclose(env.radiance, world(1.0), atol=0.01)
    assert el.EnvMap.open(path.read_bytes(), any_format=True) == env


def test_damaged_files_are_a_class_of_their_own_and_name_no_temporary_file(tmp_path):
    files = [
        png(tmp_path / "a.png", codes(world())),
        radiance_file(tmp_path / "a.hdr", world()),
        write_file(tmp_path / "a.exr", world().astype(np.float32)),
        write_file(tmp_path / "a.tif", codes(world())),
        jpeg(tmp_path / "a.jpg", world()),
    ]
    for path in files:
        whole = path.read_bytes()
        for length in (24, len(whole) * 2 // 3):
            with pytest.raises(DamagedFileError, match="the bytes") as refusal:
                el.EnvMap.open(whole[:length])
            assert "envlights-" not in str(refusal.value)


def test_an_xmp_packet_with_entities_is_passed_over(tmp_path):
    bomb = {"ProjectionType": "cubemap"}
    path = jpeg(tmp_path / "a.jpg", world(), bomb)
    data = path.read_bytes()
    old, new = b"<x:xmpmeta", b'<!DOCTYPE l [<!ENTITY a "b">]><x:xmpmeta'
    start = data.index(b"http://ns.adobe.com") - 2
    length = int.from_bytes(data[start : start + 2], "big") + len(new) - len(old)
    data = data[:start] + length.to_bytes(2, "big") + data[start + 2 :].replace(old, new)
    assert el.EnvMap.open(data).radiance.shape == world().shape
    with pytest.raises(el.EnvLightsError, match="cubemap"):
        el.EnvMap.open(path)


@pytest.mark.parametrize("command", ["fit", "detect", "split"])
def test_the_command_line_takes_part_and_colour(tmp_path, command):
    path = layers_file(tmp_path / "layers.exr", diffuse=0 * NORMALS, specular=world(50.0))
    run = [command, str(path), "-n", "1", "--json"]
    refused = CliRunner().invoke(main, run)
    assert refused.exit_code == 2
    assert "choose one with --part" in refused.output
    done = CliRunner().invoke(main, [*run, "--part", "specular", "--colour", "linear"])
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout)


def test_the_command_line_reads_the_standard_input(tmp_path):
    data = radiance_file(tmp_path / "a.hdr", world(50.0)).read_bytes()
    runs = [
        CliRunner().invoke(main, ["detect", name, "-n", "1", "--json"], input=data)
        for name in ("-", str(tmp_path / "a.hdr"))
    ]
    assert runs[0].exit_code == 0, runs[0].output
    assert runs[0].stdout == runs[1].stdout
    assert CliRunner().invoke(main, ["fit", "-", "-n", "1"], input=data).exit_code == 0
