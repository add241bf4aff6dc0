"""Six files by names: lists, mappings, folders, patterns."""

import shutil

import numpy as np
import pytest

import envlights as el
from envlights.environment.files.image_output import write_exr, write_hdr
from envlights.environment.layouts import Layout, recognise
from envlights.environment.layouts.face_names import order_of_names
from envlights.environment.layouts.faces import stored_faces
from envlights.environment.picture_files import faces_of_mapping, read_picture
from tests.layouts.worlds import smooth, upright_directions

NAMES = {
    "opengl": ["px", "nx", "py", "ny", "pz", "nz"],
    "openexr": ["+X", "-X", "+Y", "-Y", "+Z", "-Z"],
    "pannellum": ["front", "right", "back", "left", "up", "down"],
}
WORLD = smooth(upright_directions(16))
BORDER = smooth(upright_directions(16, border=True))


def write(folder, order, names, *, prefix="", suffix=".exr", faces=WORLD):
    folder.mkdir(exist_ok=True)
    paths = []
    for name, face in zip(names, stored_faces(faces, order), strict=True):
        paths.append(folder / f"{prefix}{name}{suffix}")
        (write_exr if suffix == ".exr" else write_hdr)(paths[-1], np.ascontiguousarray(face))
    return paths


def read(source, **arguments):
    image = read_picture(source)
    return recognise(image.pixels, image.hints, Layout(**arguments), image.coverage)


@pytest.mark.parametrize("order", sorted(NAMES))
@pytest.mark.parametrize("kind", ["folder", "{face}", "*", "%", "list", "mapping"])
def test_six_files_become_upright_faces(tmp_path, order, kind):
    faces = BORDER if order == "openexr" else WORLD
    paths = write(tmp_path / "sky", order, NAMES[order], prefix="sky_", faces=faces)
    source = {
        "folder": tmp_path / "sky",
        "list": paths[3:] + paths[:3],
        "mapping": dict(zip(NAMES[order], paths, strict=True)),
    }.get(kind, str(tmp_path / "sky" / f"sky_{kind}.exr"))
    arranged = read(source)
    assert arranged.source[2:5:2] == (order, "name")
    np.testing.assert_array_equal(arranged.samples.reshape(faces.shape), faces)


@pytest.mark.parametrize(
    ("names", "order"),
    [
        (["posx", "negx", "posy", "negy", "posz", "negz"], "opengl"),
        (["pos_x", "neg_x", "pos_y", "neg_y", "pos_z", "neg_z"], "opengl"),
        (["Night_PX_2k", "Night_NX_2k", "Night_PY_2k", "Night_NY_2k"], ""),
        (["a_px_2k", "a_nx_2k", "a_py_2k", "a_ny_2k", "a_pz_2k", "a_nz_2k"], "opengl"),
        (["env-px", "env-nx", "env-py", "env-ny", "env-pz", "env-nz"], "opengl"),
        (["x+", "x-", "y+", "y-", "z+", "z-"], ""),
        (["c_+X", "c_-X", "c_+Y", "c_-Y", "c_+Z", "c_-Z"], "openexr"),
        (["F", "R", "B", "L", "U", "D"], "py360convert"),
        (["skyft", "skyrt", "skybk", "skylf", "skyup", "skydn"], "pannellum"),
        (["Front", "Right", "Back", "Left", "Top", "Bottom"], "pannellum"),
        (["p1", "p2", "p3", "p4", "p5", "p6"], ""),
        (["one", "two", "three", "four", "five", "six"], ""),
        (["px"] * 6, ""),
        ([""] * 6, ""),
    ],
)
def test_names_determine_an_order(names, order):
    for turn in range(3):
        named = order_of_names(names[turn:] + names[:turn])
        assert (named.order if named else "") == order
        if order:
            first = (names[turn:] + names[:turn])[named.positions[0]]
            assert first == names[0]


@pytest.mark.parametrize("order", ["opengl", "pannellum"])
def test_numbers_are_ordered_by_their_seams(tmp_path, order):
    write(tmp_path / "n", order, "012345", prefix="m_")
    arranged = read(tmp_path / "n")
    assert arranged.source[2:5] == (order, "cell-centred", "seams")
    np.testing.assert_array_equal(arranged.samples.reshape(WORLD.shape), WORLD)
    assert read(tmp_path / "n", faces=order).source.recognised_by == "argument"


def test_a_list_without_telling_names_keeps_its_order(tmp_path):
    paths = write(tmp_path, "opengl", ["one", "two", "three", "four", "five", "six"])
    assert read(paths).source[2:5:2] == ("opengl", "seams")
    data = [path.read_bytes() for path in paths]
    np.testing.assert_array_equal(read(data).samples, read(paths).samples)


def test_names_that_lie_are_corrected_by_the_seams(tmp_path):
    write(tmp_path, "openexr", NAMES["opengl"])
    arranged = read(tmp_path)
    assert arranged.source[2:5:2] == ("openexr", "seams")
    np.testing.assert_array_equal(arranged.samples.reshape(WORLD.shape), WORLD)
    assert "the names of the files name the order of OpenGL, whose edges" in arranged.notes[-1]


def test_named_faces_that_are_turned_get_a_note(tmp_path):
    turned = WORLD.copy()
    turned[4:] = np.rot90(turned[4:], 1, axes=(1, 2))
    write(tmp_path, "pannellum", NAMES["pannellum"], faces=turned)
    assert "but their edges do not fit" in read(tmp_path).notes[-1]


def test_other_sources_are_refused(tmp_path):
    paths = write(tmp_path / "a", "opengl", NAMES["opengl"], suffix=".hdr")
    shutil.copytree(tmp_path / "a", tmp_path / "b")
    write_hdr(tmp_path / "b" / "ny.hdr", np.ones((8, 8, 3), np.float32))
    shutil.copytree(tmp_path / "a", tmp_path / "c")
    write_hdr(tmp_path / "c" / "ny.hdr", np.ones((8, 16, 3), np.float32))
    (tmp_path / "empty").mkdir()
    for source, words in [
        (tmp_path / "b", r"one size; got .*px\.hdr 16x16.*ny\.hdr 8x8"),
        (tmp_path / "c", r"are squares; .*ny\.hdr has 16x8 pixels"),
        (tmp_path / "empty", "it is a folder, which holds 0 pictures, and a cube map has six"),
        (paths[:5], r"list holds 5 pictures \(px, nx, py, ny, pz\)"),
        (tmp_path / "a" / "{face}.exr", "pattern holds 0 pictures"),
        (tmp_path / "a" / "100%.exr", "there is no such file"),
        (tmp_path / "a" / "*.exr", "there is no such file"),
        ([*paths[:5], tmp_path / "gone.hdr"], "gone.hdr: there is no such file"),
    ]:
        with pytest.raises(el.EnvLightsError, match=words):
            read_picture(source)
    with pytest.raises(el.EnvLightsError, match=r"faces='pannellum' contradicts the names"):
        read(tmp_path / "a", faces="pannellum")
    with pytest.raises(el.EnvLightsError, match="up to 255 pixels; got 16 rows"):
        read_picture(tmp_path / "a", max_pixels=6 * 256 - 1)


def test_the_share_that_alpha_shows_is_stacked(tmp_path):
    import OpenImageIO as oiio  # noqa: N813, its own name for itself

    paths = write(tmp_path, "opengl", NAMES["opengl"], suffix=".hdr")
    paths[2] = tmp_path / "py.png"
    spec = oiio.ImageSpec(16, 16, 4, "uint8")
    file = oiio.ImageOutput.create(str(paths[2]))
    file.open(str(paths[2]), spec)
    alpha = np.full((16, 16, 4), 255, np.uint8)
    alpha[:8, :, 3] = 0
    file.write_image(alpha)
    file.close()
    arranged = read(paths)
    seen = arranged.coverage.reshape(6, 16, 16)
    assert seen[4, :8].max() == 0
    assert seen.sum() == 6 * 256 - 128
    assert read_picture(paths).clip_level is None


def test_mappings_of_arrays_are_read_by_their_names():
    named = dict(zip("FRBLUD", WORLD, strict=True))
    faces, order = faces_of_mapping(named)
    assert order == "py360convert"
    np.testing.assert_array_equal(faces, WORLD)
    with pytest.raises(el.EnvLightsError, match="names such as px nx"):
        faces_of_mapping({"one": WORLD[0]})
    with pytest.raises(el.EnvLightsError, match="are squares"):
        faces_of_mapping(named | {"U": np.ones(5)})
    with pytest.raises(el.EnvLightsError, match=r"one shape and one dtype.*, 3\).*, 4\)"):
        faces_of_mapping(named | {"U": np.ones((16, 16, 4), WORLD.dtype)})
    with pytest.raises(el.EnvLightsError, match=r"one shape and one dtype.*uint8"):
        faces_of_mapping(named | {"U": np.ones(WORLD[0].shape, np.uint8)})
    with pytest.raises(el.EnvLightsError, match="face U must be an array of numbers"):
        faces_of_mapping(named | {"U": [[1, 2], [3]]})
