"""Pictures in files: every projection, every order and arrangement of faces."""

import numpy as np
import OpenEXR
import OpenImageIO as oiio  # noqa: N813, its own name for itself
import pytest

import envlights as el
from envlights.environment.layouts import Layout, recognise
from envlights.environment.layouts.conventions import CONVENTIONS, CROSSES
from envlights.environment.layouts.faces import ARRANGEMENTS
from envlights.environment.layouts.picture import picture_of
from envlights.environment.layouts.picture_layout import angular_map, cube, equirectangular
from envlights.environment.picture_files import read_picture
from tests.layouts.worlds import smooth, upright_directions

N = 16


def world(border):
    return smooth(upright_directions(N, border)).reshape(6 * N, N, 3)


def cube_picture(order):
    border = CONVENTIONS[order].border_sampled
    return picture_of(world(border), cube(N, border_sampled=border), faces=order, notes=("sky",))


def read_back(source, **arguments):
    image = read_picture(source)
    return recognise(image.pixels, image.hints, Layout(**arguments))


@pytest.mark.parametrize("order", sorted(CONVENTIONS))
@pytest.mark.parametrize("arrangement", ARRANGEMENTS)
def test_one_file_of_a_cube_reads_back_without_a_change(tmp_path, order, arrangement):
    picture = cube_picture(order)
    assert picture.save(tmp_path / "a.exr", arrangement=arrangement) == (tmp_path / "a.exr",)
    arranged = read_back(tmp_path / "a.exr")
    assert arranged.layout == picture.layout
    np.testing.assert_array_equal(arranged.samples, world(picture.layout.border_sampled))
    # An array is read by the arguments.
    name = arrangement if arrangement in CROSSES else order
    image = read_picture(tmp_path / "a.exr").pixels
    arranged = recognise(image, layout=Layout("cube", faces=name))
    np.testing.assert_array_equal(arranged.samples, world(picture.layout.border_sampled))


@pytest.mark.parametrize("order", sorted(CONVENTIONS))
@pytest.mark.parametrize("is_folder", [True, False])
def test_six_files_of_a_cube_read_back_by_their_names(tmp_path, order, is_folder):
    picture = cube_picture(order)
    files = picture.save(tmp_path if is_folder else tmp_path / "sky_{face}.exr")
    start = "" if is_folder else "sky_"
    assert [file.stem for file in files] == [start + name for name in CONVENTIONS[order].names]
    arranged = read_back(tmp_path)
    np.testing.assert_array_equal(arranged.samples, world(picture.layout.border_sampled))
    assert arranged.layout == picture.layout


def test_the_stack_of_openexr_has_the_attribute_of_its_environment(tmp_path):
    cube_picture("openexr").save(tmp_path / "a.exr")
    assert OpenEXR.File(str(tmp_path / "a.exr")).header()["envmap"] == OpenEXR.ENVMAP_CUBE
    spec = oiio.ImageInput.open(str(tmp_path / "a.exr")).spec()
    assert spec.getattribute("textureformat") == "CubeFace Environment"
    assert read_back(tmp_path / "a.exr").source[2:5:2] == ("openexr", "attribute")
    cube_picture("py360convert").save(tmp_path / "b.exr")
    assert "envmap" not in OpenEXR.File(str(tmp_path / "b.exr")).header()
    cube_picture("openexr").save(tmp_path / "c.exr", arrangement="strip")
    assert "envmap" not in OpenEXR.File(str(tmp_path / "c.exr")).header()


def test_pictures_of_other_projections_are_saved_as_they_are(tmp_path):
    samples = smooth(upright_directions(32))[0]
    for name in ("a.exr", "a.hdr"):
        picture = picture_of(samples, angular_map(32), coverage=np.ones((32, 32)))
        picture.save(tmp_path / name)
        arranged = read_back(tmp_path / name, projection="angular")
        np.testing.assert_allclose(arranged.samples, samples, rtol=0.005, atol=0.02)
        assert arranged.layout == picture.layout
    panorama = picture_of(np.tile(samples[:16], (1, 1, 1)), equirectangular(16))
    panorama.save(tmp_path / "b.exr", half=True, compression="piz")
    assert read_back(tmp_path / "b.exr").layout == panorama.layout
    border = picture_of(samples[:16], equirectangular(16, border_sampled=True))
    border.save(tmp_path / "c.exr")
    assert read_back(tmp_path / "c.exr").layout.border_sampled


def test_a_picture_is_an_array_and_a_page():
    picture = cube_picture("openexr")
    assert np.asarray(picture) is picture.array
    assert np.array(picture, copy=True) is not picture.array
    assert np.asarray(picture, np.float64).dtype == np.float64
    assert (picture.shape, picture.height, picture.width) == ((96, 16, 3), 96, 16)
    assert repr(picture) == "Picture(16x96 cube, border-sampled, faces in the order of OpenEXR)"
    page = picture._repr_html_()
    assert "16x96 cube" in page
    assert "data:image/png;base64," in page
    assert "equidistant" in repr(picture_of(np.ones((8, 8, 3)), angular_map(8)))
    assert "<img" in picture_of(np.ones((8, 8, 3)), angular_map(8))._repr_html_()


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        ("a.dds", {}, r"do not write \.dds textures; save six \.exr files, and `texassemble"),
        ("a.ktx2", {}, "ktx create --cubemap"),
        ("a.jpg", {}, r"save a picture as .*the suffix must be one of \.exr, \.hdr, \.tif"),
        ("a_{face}.jpg", {}, "the suffix must be one of"),
        ("a.hdr", {"half": True}, r"half and compression are of \.exr files"),
        ("a.exr", {"arrangement": "dice"}, "arrangement must be 'stack' or 'strip'"),
        ("a_{face}.exr", {"arrangement": "strip"}, "arrangement='strip' is of one file"),
        ("gone/a_{face}.exr", {}, "the folder .*gone does not exist"),
    ],
)
def test_other_files_are_refused(tmp_path, name, options, words):
    with pytest.raises(el.EnvLightsError, match=words):
        cube_picture("opengl").save(tmp_path / name, **options)
    assert not [*tmp_path.iterdir()]


def test_faces_are_of_cubes_alone(tmp_path):
    picture = picture_of(np.ones((8, 8, 3)), angular_map(8))
    with pytest.raises(el.EnvLightsError, match="six files are of cubes"):
        picture.save(tmp_path / "{face}.exr")
    with pytest.raises(el.EnvLightsError, match="arrangement='strip' is of cubes"):
        picture.save(tmp_path / "a.exr", arrangement="strip")
    with pytest.raises(el.EnvLightsError, match="faces must be 'opengl'"):
        picture_of(np.ones((48, 8, 3)), cube(8), faces="horizontal-cross")


def test_the_seen_share_has_the_order_of_the_faces():
    samples = world(False)
    picture = picture_of(samples, cube(N), faces="opengl", coverage=samples[..., 0])
    np.testing.assert_array_equal(picture.coverage, picture.array[..., 0])
    assert not np.array_equal(picture.array, samples)
