"""Recognition of pictures: metadata, names and shapes, to a layout or a sentence."""

import math

import numpy as np
import pytest

import envlights as el
from envlights.environment.decoders.source import kind_of, named_source
from envlights.environment.files.hints import Hints
from envlights.environment.files.image_output import write_exr
from envlights.environment.files.images import read_image
from envlights.environment.layouts import Layout, recognise
from envlights.environment.layouts.faces import arranged_faces, stored_faces
from envlights.environment.layouts.picture_layout import MIRRORED
from tests.layouts.files import dds, jpeg_with
from tests.layouts.worlds import smooth, upright_directions

RNG = np.random.default_rng(4)


def noise(height, width):
    return RNG.uniform(0.2, 1, (height, width, 3)).astype(np.float32)


def disc(n, ground=0.0):
    y, x = np.mgrid[:n, :n] * 2 / (n - 1) - 1
    inside = np.hypot(x, y)[..., None] < 1
    return np.where(inside, noise(n, n), ground).astype(np.float32)


#: Size, arguments, and what the layout must hold.
LAYOUTS = [
    ((64, 128), {}, {"kind": "equirectangular", "border_sampled": False}),
    ((64, 128), {"registration": "border-sampled"}, {"border_sampled": True}),
    ((1024, 2047), {}, {"kind": "equirectangular", "width": 2047}),
    ((501, 1000), {}, {"kind": "equirectangular", "height": 501}),
    (
        (30, 180),
        {"projection": "equirectangular", "fov": 360},
        {"whole": (90, 180), "corner": (30, 0)},
    ),
    (
        (40, 60),
        {"projection": "equirectangular", "fov": 120, "horizon": 30},
        {"whole": (90, 180), "corner": (15, 60)},
    ),
    (
        (50, 400),
        {"projection": "cylinder", "fov": 360},
        {"kind": "cylinder", "field_of_view": 2 * math.pi, "horizon": None},
    ),
    ((50, 100), {"projection": "cylinder", "fov": 90, "horizon": 20}, {"horizon": 20}),
    ((64, 64), {"projection": "octahedral"}, {"kind": "octahedral"}),
    ((64, 64), {"projection": "octahedral-equal-area"}, {"kind": "octahedral-equal-area"}),
    (
        (64, 64),
        {"projection": "angular"},
        {"kind": "azimuthal", "mapping": "equidistant", "reach": math.pi},
    ),
    (
        (64, 64),
        {"projection": "mirror-ball"},
        {"mapping": "equisolid", "reach": math.pi, "axes": MIRRORED},
    ),
    (
        (48, 64),
        {"projection": "mirror-ball", "circle": (32, 24, 20)},
        {"height": 48, "width": 64, "circle": (32.0, 24.0, 20.0)},
    ),
    (
        (48, 64),
        {"mapping": "stereographic", "fov": 180},
        {"mapping": "stereographic", "reach": math.pi / 2, "circle": None},
    ),
    (
        (64, 64),
        {"projection": "fisheye", "mapping": "orthographic", "fov": 180, "forward": (0, 1, 0)},
        {"axes": ((0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, -1.0))},
    ),
    (
        (40, 60),
        {"projection": "planar", "fov": 65},
        {"kind": "planar", "field_of_view": math.radians(65)},
    ),
    ((64, 64), {"eye": "right"}, {"kind": "equirectangular", "height": 32, "width": 64}),
    ((32, 128), {"eye": "left"}, {"kind": "equirectangular", "height": 32, "width": 64}),
]


@pytest.mark.parametrize(("size", "arguments", "wanted"), LAYOUTS, ids=str)
def test_a_size_and_arguments_give_a_layout(size, arguments, wanted):
    picture = noise(*size)
    arranged = recognise(picture, layout=Layout(**arguments))
    assert {name: getattr(arranged.layout, name) for name in wanted} == wanted
    assert arranged.samples.shape[:2] == (arranged.layout.height, arranged.layout.width)
    assert np.shares_memory(arranged.samples, picture)
    assert arranged.source.recognised_by == (
        "argument" if {"projection", "mapping"} & arguments.keys() else "shape"
    )


#: Picture, arguments, and words of the refusal.
REFUSALS = [
    (
        noise(64, 64),
        {},
        r"layout='octahedral'.*layout=el\.io\.Layout\.planar.fov=65.*eye='left'",
    ),
    (disc(64), {}, r"layout='angular'.*layout='mirror-ball'.*layout=el\.io\.Layout\.fisheye"),
    (np.tile(disc(64, 0.4)[:32], (2, 1, 1)), {}, r"may be two panoramas, one above the other"),
    (noise(40, 60), {}, r"planar\(fov=65\).*cylinder\(fov=360\).*equirectangular\(fov=360"),
    (
        noise(48, 64),
        {},
        r"a cube map \(layout=.*cube\(faces='horizontal-cross'\)\), a ph",
    ),
    (noise(16, 64), {}, r"beside each other \(layout=.*\.equirectangular\(eye='left'\)\)"),
    (np.ones(12 * 16), {}, "192 pixels in one row are a HEALPix map of n_side 4.*healpy"),
    (np.ones((12 * 16, 3)), {}, "HEALPix map of n_side 4"),
    (np.ones((3, 5, 5, 5)), {}, r"must have the shape .*; got \(3, 5, 5, 5\)"),
    (np.ones((6, 8, 8, 3)), {"projection": "angular"}, "six squares are the faces of a cube"),
    (noise(40, 60), {"projection": "equirectangular"}, "twice as wide as high; got 60x40.*fov="),
    (noise(60, 60), {"projection": "equirectangular"}, "fov=, eye='left' if it holds two eyes"),
    (noise(1, 2), {}, "at least 4x2 pixels; got 2x1"),
    (noise(60, 90), {"projection": "equirectangular", "fov": 360}, "reaches beyond a pole"),
    (noise(40, 60), {"projection": "planar"}, "a photograph needs fov="),
    (noise(64, 64), {"projection": "fisheye", "fov": 180}, "needs mapping=, 'equidistant' or"),
    (noise(64, 64), {"projection": "fisheye", "mapping": "equisolid"}, "needs fov=, the degrees"),
    (noise(40, 60), {"projection": "cylinder"}, "needs fov=, the degrees of azimuth"),
    (noise(40, 60), {"projection": "angular"}, "is square; got 60x40 pixels; crop"),
    (noise(63, 63), {"projection": "octahedral"}, "even number of columns; got 63"),
    (noise(40, 60), {"faces": "opengl"}, "cube map has six square faces; got 60x40"),
    (noise(64, 128), {"projection": "mercator"}, "projection must be 'equirectangular' or"),
    (noise(64, 128), {"fov": 90}, r"fov needs a projection as well .*\.planar\(fov=65\)"),
    (noise(64, 64), {"projection": "angular", "fov": 180}, "fov is no argument of an angular map"),
    (noise(64, 64), {"projection": "mirror-ball", "circle": (1, 2)}, "circle must be centre x"),
    (noise(64, 64), {"projection": "planar", "fov": 0}, "fov must be above 0"),
    (noise(64, 64), {"projection": "planar", "fov": 180}, "fov must be a finite"),
    (noise(64, 64), {"projection": "planar", "fov": 9, "forward": (0, 0, 0)}, "not all 0"),
    (noise(48, 64), {"eye": "left"}, r"one above the other \(1:1\) or left and right \(4:1\)"),
    (noise(8, 48), {"faces": "horizontal-cross"}, "does not fit the shape .*'opengl'"),
]


@pytest.mark.parametrize(
    ("picture", "arguments", "words"), REFUSALS, ids=lambda each: str(each)[:40]
)
def test_what_a_picture_cannot_say_is_requested(picture, arguments, words):
    with pytest.raises(el.EnvLightsError, match=words) as refusal:
        recognise(picture, layout=Layout(**arguments))
    assert "\n" not in str(refusal.value)


def test_dual_fisheyes_are_refused_and_maps_with_few_lights_are_none():
    lamp = np.zeros((64, 128, 3), np.float32)
    lamp[10:14, 30:34] = 90
    for picture in (lamp, np.zeros((64, 128, 3)), np.ones((64, 128, 3))):
        assert el.EnvMap(picture).source.recognised_by == "shape"
    both = np.hstack([disc(64)] * 2)
    for picture in (both, both.repeat(8, axis=0).repeat(8, axis=1)):
        with pytest.raises(el.EnvLightsError, match=r"dual fisheye.*stitch it in the camera's"):
            el.EnvMap(picture)
    assert np.array_equal(el.EnvMap(both, layout="equirectangular").radiance, both)


def test_photographs_of_4_to_3_are_no_crosses():
    cube = smooth(upright_directions(16))
    cross = arranged_faces(cube, "opengl", "horizontal-cross")
    assert recognise(cross).source[:5:2] == ("cube", "horizontal-cross", "shape")
    turned = arranged_faces(np.rot90(cube, 2, axes=(1, 2)), "opengl", "horizontal-cross")
    with pytest.raises(el.EnvLightsError, match=r"do not fit .* or a photograph"):
        recognise(turned)
    named = recognise(turned, layout=Layout("cube"))
    assert "but their edges do not fit" in named.notes[0]
    cross[:16, :16] = noise(16, 16)
    with pytest.raises(el.EnvLightsError, match="faces='horizontal-cross'"):
        recognise(cross)


def test_codes_and_grey_samples_keep_their_type():
    faces = (smooth(upright_directions(16)) * 40).astype(np.uint8)
    for samples in (faces, faces[..., 0], faces[..., :1]):
        arranged = recognise(samples, layout=Layout(faces="directxtex"))
        assert arranged.samples.dtype == np.uint8
        assert arranged.samples.shape[:2] == (96, 16)
    assert recognise(np.ones((4, 8), np.uint16)).samples.shape == (4, 8, 1)


def test_the_seen_share_is_arranged_like_the_samples():
    faces = smooth(upright_directions(8))
    image = arranged_faces(faces, "openexr", "strip")
    arranged = recognise(image, layout=Layout(faces="openexr"), coverage=image[..., 1])
    np.testing.assert_array_equal(arranged.coverage, arranged.samples[..., 1])
    halves = noise(64, 64)
    right = recognise(halves, layout=Layout(eye="right"), coverage=halves[..., 0])
    np.testing.assert_array_equal(right.coverage, halves[32:, :, 0])


def test_cubes_of_dds_and_openexr_with_one_tag_are_one_world(tmp_path):
    """Both are stacks with the attribute "CubeFace Environment", in different orders."""
    faces = smooth(upright_directions(32, border=True)) / 16
    stored = stored_faces(faces, "openexr").reshape(192, 32, 3)
    write_exr(tmp_path / "a.exr", stored, environment="cube")
    dds(tmp_path / "a.dds", stored_faces(faces, "opengl"))
    twins = {}
    for name, order in {"a.exr": "openexr", "a.dds": "opengl"}.items():
        image = read_image(tmp_path / name, any_format=True, any_projection=True)
        assert image.hints.environment == "cube"
        assert image.pixels.shape == (192, 32, 3)
        twins[name] = recognise(image.pixels, image.hints)
        assert twins[name].source[2:5] == (order, "border-sampled", "attribute")
    np.testing.assert_array_equal(twins["a.exr"].samples, faces.reshape(192, 32, 3))
    np.testing.assert_allclose(twins["a.dds"].samples, twins["a.exr"].samples, atol=0.01)


def test_incomplete_cubes_and_strangers_of_dds_are_refused(tmp_path):
    path = dds(tmp_path / "a.dds", smooth(upright_directions(8))[:4] / 4, 0x3E00)
    assert kind_of(named_source(path), any_format=True) == "dds"  # no other reader tries it
    with pytest.raises(el.EnvLightsError, match="only with any_format=True"):
        read_image(path)
    image = read_image(path, any_format=True, any_projection=True)
    with pytest.raises(el.EnvLightsError, match="holds only the faces"):
        recognise(image.pixels, image.hints)


def test_ktx_is_refused_with_a_way_out(tmp_path):
    (tmp_path / "a.ktx2").write_bytes(b"\xabKTX 20\xbb\r\n\x1a\n" + bytes(80))
    for any_format in (True, False):
        with pytest.raises(el.EnvLightsError, match="ktx extract"):
            read_image(tmp_path / "a.ktx2", any_format=any_format)


def test_cylinders_of_gpano_are_read(tmp_path):
    numbers = {
        "GPano__ProjectionType": "cylindrical",
        "GPano__FullPanoWidthPixels": 720,
        "GPano__FullPanoHeightPixels": 400,
        "GPano__CroppedAreaImageWidthPixels": 180,
        "GPano__CroppedAreaImageHeightPixels": 80,
        "GPano__CroppedAreaLeftPixels": 270,
        "GPano__CroppedAreaTopPixels": -60,
    }
    path = jpeg_with(tmp_path / "a.jpg", noise(40, 90), **numbers)
    with pytest.raises(el.EnvLightsError, match="the projection cylindrical"):
        read_image(path)
    image = read_image(path, any_projection=True)
    assert image.pixels.shape == (40, 90, 3)
    arranged = recognise(image.pixels, image.hints)
    assert arranged.layout.field_of_view == pytest.approx(math.pi / 2)
    assert arranged.layout.horizon == 30
    assert arranged.source[0::4] == ("cylinder", "attribute")
    path = jpeg_with(tmp_path / "b.jpg", noise(40, 90), GPano__ProjectionType="cylindrical")
    image = read_image(path, any_projection=True)
    with pytest.raises(el.EnvLightsError, match="needs fov="):
        recognise(image.pixels, image.hints)
    layout = recognise(image.pixels, image.hints, Layout(fov=180)).layout
    assert (layout.kind, layout.horizon) == ("cylinder", None)


@pytest.mark.parametrize("projection", ["fisheye", "mercator", "cubestrip"])
def test_other_projections_of_gpano_are_requested(projection):
    hints = Hints("a.jpg", "jpeg", projection=projection)
    with pytest.raises(el.EnvLightsError, match=rf"is '{projection}'; give layout="):
        recognise(noise(64, 128), hints)
    chosen = Layout("fisheye", mapping="equidistant", fov=180)
    assert recognise(noise(64, 128), hints, chosen).layout.mapping == "equidistant"


def test_stereo_panoramas_are_read_for_one_eye(tmp_path):
    upper, lower = noise(32, 64), noise(32, 64)
    path = jpeg_with(
        tmp_path / "a.jpg", np.vstack([upper, lower]), GSpherical__StereoMode="top-bottom"
    )
    image = read_image(path, any_projection=True)
    with pytest.raises(el.EnvLightsError, match=r"two eyes \(top-bottom\); give .*eye='left'"):
        recognise(image.pixels, image.hints)
    arranged = recognise(image.pixels, image.hints, Layout(eye="right"))
    np.testing.assert_array_equal(arranged.samples, image.pixels[32:])
    assert arranged.notes == ("only the lower half, of the right eye, was read",)


def test_metadata_that_contradict_the_shape_are_refused():
    hints = Hints("a.exr", "openexr", "cube", "", True)
    with pytest.raises(el.EnvLightsError, match=r"a\.exr as a cube map: it has 128x64 pixels"):
        recognise(noise(64, 128), hints)
    assert recognise(noise(64, 128), hints, Layout("equirectangular")).layout.border_sampled
