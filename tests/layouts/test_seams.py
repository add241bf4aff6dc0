"""Order and registration of cubes by their seams."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import envlights as el
from envlights.environment.files.images import read_image
from envlights.environment.layouts import Layout, recognise
from envlights.environment.layouts.conventions import DISTINCT
from envlights.environment.layouts.faces import arranged_faces, stored_faces
from envlights.environment.layouts.seams import (
    equal_edges,
    lines_of_faces,
    log_luminance,
    seam_score,
)
from tests.helpers import paths_of_real_maps
from tests.layouts.worlds import looked_up, smooth, upright_directions

#: Orders that a cell-centred strip is recognised as.
NAMES = {"opengl": "opengl", "openexr": "openexr", "py360convert": "pannellum"}


def world(seed=0, n=32, border=False):
    return smooth(upright_directions(n, border), seed)


def score(faces):
    return seam_score(log_luminance(faces))


@given(st.integers(0, 2**32 - 1), st.sampled_from(DISTINCT), st.booleans())
def test_the_order_of_a_world_is_found_or_requested_and_never_wrong(seed, order, border):
    faces = world(seed, border=border)
    image = arranged_faces(faces, order, "stack")
    try:
        arranged = recognise(image)
    except el.EnvLightsError:
        return
    np.testing.assert_array_equal(arranged.samples.reshape(faces.shape), faces)
    assert arranged.source.recognised_by == "seams"
    assert arranged.source.registration == ("border-sampled" if border else "cell-centred")
    assert any("by their seams" in note for note in arranged.notes)


@pytest.mark.parametrize("order", DISTINCT)
def test_orders_of_one_world_are_found(order):
    arranged = recognise(arranged_faces(world(), order, "strip"))
    assert arranged.source.faces == NAMES[order]
    np.testing.assert_array_equal(arranged.samples.reshape(6, 32, 32, 3), world())


@pytest.mark.parametrize("name", ["vertical-cross", "vertical-cross-upright"])
def test_the_turn_of_the_back_face_of_a_cross_is_found(name):
    arranged = recognise(arranged_faces(world(), "opengl", name))
    assert (arranged.source.faces, arranged.source.recognised_by) == (name, "seams")
    np.testing.assert_array_equal(arranged.samples.reshape(6, 32, 32, 3), world())


@pytest.mark.parametrize("path", paths_of_real_maps("hdr/*.hdr"), ids=lambda path: path.stem)
def test_orders_of_real_maps_are_found(path):
    faces = looked_up(read_image(path).pixels, upright_directions(128))
    for order in DISTINCT:
        arranged = recognise(arranged_faces(faces, order, "stack"))
        assert arranged.source.faces == NAMES[order]
        np.testing.assert_array_equal(arranged.samples.reshape(faces.shape), faces)


def test_faces_of_another_convention_are_refused():
    """Up and down turned by a quarter, as in no convention of the table."""
    faces = world().copy()
    faces[4:] = np.rot90(faces[4:], 1, axes=(1, 2))
    with pytest.raises(el.EnvLightsError, match="cannot be decided by their edges"):
        recognise(arranged_faces(faces, "opengl", "stack"))


def test_constant_and_symmetric_faces_are_requested():
    ring = np.broadcast_to(np.hypot(*np.mgrid[-8:9, -8:9])[..., None], (6, 17, 17, 3))
    almost = ring * np.random.default_rng(1).uniform(1, 1.001, ring.shape)
    for faces in (np.ones((6, 8, 8, 3)), ring, almost):
        with pytest.raises(
            el.EnvLightsError, match="give faces= one of 'opengl', 'openexr', 'py360convert'"
        ):
            recognise(faces)


@pytest.mark.parametrize("n", [1, 2, 3, 255, 256, 257, 300, 1000, 2048])
def test_sampled_lines_are_symmetric_pairs(n):
    lines = lines_of_faces(n)
    np.testing.assert_array_equal(lines, n - 1 - lines[::-1])
    assert (lines[0], lines[-1]) == (0, n - 1)
    assert len(lines) == n if n < 257 else 256 <= len(lines) <= 640
    assert n == 1 or (np.diff(lines) == 1).sum() >= len(lines) // 2


@pytest.mark.parametrize("arrangement", ["stack", "strip", "vertical-cross"])
def test_large_faces_are_sampled_without_a_change_of_the_order(arrangement):
    faces = world(n=600)
    arranged = recognise(arranged_faces(faces, "openexr", arrangement))
    np.testing.assert_array_equal(arranged.samples.reshape(faces.shape), faces)
    lines = lines_of_faces(600)
    part = log_luminance(faces[:, lines[:, None], lines])
    assert seam_score(part, lines=lines) == pytest.approx(score(faces), rel=0.05)


def test_equal_edges_are_border_samples():
    assert equal_edges(world(border=True)) == 1
    assert equal_edges(world()) is None
    assert equal_edges(np.ones((6, 8, 8, 3))) == 0
    almost = world(border=True)
    almost[2, 0, 5] *= 1.001
    assert equal_edges(almost) is None
    assert score(world(border=True)) == 0
    assert 0.3 < score(world()) < 1.2


@pytest.mark.parametrize("columns", [(60, 62), (61, 63), (56, 58), (62, 64)])
@pytest.mark.parametrize("dtype", [np.float32, np.uint8])
def test_a_lamp_beside_an_edge_of_a_black_world_is_in_cells(columns, dtype):
    """Its direction is that of the centres of its pixels, by the geometry of a cube."""
    faces = np.zeros((6, 64, 64, 3), dtype)
    faces[0, 20:22, slice(*columns)] = 200
    if columns[1] == 64:  # A lamp across the edge, equal on both sides.
        faces[1, 20:22, :2] = 200
    layout = Layout.cube(faces="pannellum")
    found = recognise(faces, layout=layout)
    assert found.source.registration == "cell-centred"
    assert any("nearly all are constant" in note for note in found.notes)
    directions = upright_directions(64)
    area = (directions @ np.array([0, 0, 1]))[0] ** 3
    env = el.EnvMap(faces.astype(np.float32), layout=layout)
    (light,) = el.detect(env)
    weights = faces[..., 0] * np.stack([area] * 6)
    expected = np.einsum("fij,fijk->k", weights, directions)
    angle = np.degrees(np.arccos(light.direction @ expected / np.linalg.norm(expected)))
    assert angle < 0.05  # A pixel beside the edge is 1 degree wide; border samples are 0.5 off.


def test_a_black_world_with_border_samples_is_read_by_its_argument():
    faces = np.zeros((6, 64, 64, 3), np.float32)
    faces[0, 20:22, 60:62] = 200
    stated = Layout.cube(faces="opengl", registration="border-sampled")
    found = recognise(faces, layout=stated)
    assert (found.source.registration, found.notes) == ("border-sampled", ())
    assert not recognise(np.ones((6, 8, 8, 3)), layout=Layout.cube(faces="opengl")).notes


def test_the_seams_go_before_the_order_of_metadata():
    """`oiiotool cube.dds -o cube.exr` writes the faces of DDS with the attribute of OpenEXR."""
    from envlights.environment.files.hints import Hints

    hints = Hints("a.exr", "openexr", "cube", "", True)
    arranged = recognise(arranged_faces(world(), "opengl", "stack"), hints)
    assert arranged.source[2:5] == ("opengl", "cell-centred", "seams")
    np.testing.assert_array_equal(arranged.samples.reshape(6, 32, 32, 3), world())
    assert "the metadata name the order of OpenEXR, whose edges do not fit" in arranged.notes[0]


def test_a_requested_order_that_does_not_fit_is_used_with_a_note():
    image = arranged_faces(world(), "opengl", "stack")
    arranged = recognise(image, layout=Layout(faces="openexr"))
    assert arranged.source[2:5] == ("openexr", "border-sampled", "argument")
    assert "fit the order of OpenGL, not the order of OpenEXR as stated" in arranged.notes[0]
    assert stored_faces(arranged.samples.reshape(6, 32, 32, 3), "openexr").shape == (6, 32, 32, 3)


#: Directions of lamps of 1.5 degrees: across edges, at corners, and all together.
LAMPS = {
    "edge": [(1, 0.1, 1)],
    "edge above": [(0.3, 1, 1)],
    "corner": [(1, 1, 1)],
    "several": [(1, 0.1, 1), (-1, 0.2, -1), (0.2, 1, 1), (0.1, -1, -1), (-1, -1, 1)],
}


@pytest.mark.parametrize("kind", ["exact", "noise"])
@pytest.mark.parametrize("lamps", LAMPS)
def test_a_right_strip_with_lamps_across_edges_is_accepted_without_a_doubt(lamps, kind):
    directions = upright_directions(256)
    faces = 0.3 * smooth(directions)
    for lamp in LAMPS[lamps]:
        faces[directions @ lamp > np.cos(np.radians(1.5)) * np.linalg.norm(lamp)] = 50
    image = arranged_faces(faces, "opengl", "strip")
    if kind == "noise":
        random = np.random.default_rng(0).normal(size=image.shape)
        image = (image * (1 + 0.03 * random)).astype(np.float32)
    stated = recognise(image, layout=Layout.cube(faces="opengl"))
    assert not any("do not fit" in note or "not the order" in note for note in stated.notes)
    assert recognise(image).source.faces == "opengl"


def test_a_strip_with_mirrored_faces_is_doubted_in_a_smooth_world():
    faces = 0.3 * smooth(upright_directions(64))
    for lamp in LAMPS["several"]:
        faces[upright_directions(64) @ lamp > np.cos(np.radians(3)) * np.linalg.norm(lamp)] = 50
    for mirrored in (1, 2, 3):
        wrong = faces.copy()
        wrong[mirrored] = wrong[mirrored, :, ::-1]
        image = arranged_faces(wrong, "opengl", "strip")
        (note,) = recognise(image, layout=Layout.cube(faces="opengl")).notes
        assert "do not fit" in note
