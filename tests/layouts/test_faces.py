"""Conventions of cubes: against specifications, and there and back."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import envlights as el
from envlights.environment.layouts import Layout, recognise
from envlights.environment.layouts.conventions import CONVENTIONS, CROSSES, FACES
from envlights.environment.layouts.faces import (
    ARRANGEMENTS,
    arranged_faces,
    cross_of_faces,
    faces_of_cross,
    outside_of_cross,
    split_strip,
    stored_faces,
    upright_faces,
)
from tests.helpers import paths_of_real_maps
from tests.layouts.worlds import looked_up, opengl_directions, smooth, upright_directions


def faces_of_numbers(n):
    """Faces whose samples all differ."""
    return np.arange(6 * n * n * 3, dtype=np.float32).reshape(6, n, n, 3)


@given(st.integers(1, 5), st.sampled_from(sorted(CONVENTIONS)))
def test_each_order_goes_there_and_back(n, order):
    faces = faces_of_numbers(n)
    np.testing.assert_array_equal(upright_faces(stored_faces(faces, order), order), faces)
    np.testing.assert_array_equal(stored_faces(upright_faces(faces, order), order), faces)


@given(st.integers(1, 5), st.sampled_from(sorted(CROSSES)))
def test_each_cross_goes_there_and_back(n, order):
    cross = cross_of_faces(faces_of_numbers(n), order)
    np.testing.assert_array_equal(faces_of_cross(cross, order), faces_of_numbers(n))
    assert not outside_of_cross(cross, order).any()
    assert np.count_nonzero(cross) == np.count_nonzero(faces_of_numbers(n))


@given(st.integers(1, 5), st.sampled_from(sorted(CONVENTIONS)), st.booleans())
def test_strips_are_cut_in_their_order(n, order, is_stack):
    image = arranged_faces(faces_of_numbers(n), order, "stack" if is_stack else "strip")
    assert image.shape[:2] == ((6 * n, n) if is_stack else (n, 6 * n))
    np.testing.assert_array_equal(upright_faces(split_strip(image), order), faces_of_numbers(n))


@given(st.sampled_from(sorted(CONVENTIONS)), st.sampled_from(ARRANGEMENTS), st.integers(2, 6))
def test_a_named_arrangement_is_recognised_without_a_change(order, arrangement, n):
    image = arranged_faces(faces_of_numbers(n), order, arrangement)
    name = arrangement if arrangement in CROSSES else order
    arranged = recognise(image, layout=Layout("cube", faces=name))
    np.testing.assert_array_equal(arranged.samples.reshape(6, n, n, 3), faces_of_numbers(n))
    assert arranged.source[:3] == ("cube", image.shape[:2], name)
    assert (arranged.layout.height, arranged.layout.width) == (6 * n, n)


def test_faces_of_opengl_are_those_of_its_specification():
    stored = smooth(opengl_directions(16))
    np.testing.assert_allclose(
        upright_faces(stored, "opengl"), smooth(upright_directions(16)), rtol=1e-5
    )


@pytest.mark.parametrize("turned", range(6))
def test_a_face_that_is_turned_by_mistake_is_seen(turned):
    """The test of the specification fails for each face, if its turn is wrong."""
    stored = smooth(opengl_directions(16))
    stored[turned] = np.rot90(stored[turned], 2)
    difference = np.abs(upright_faces(stored, "opengl") - smooth(upright_directions(16)))
    place = FACES.index(CONVENTIONS["opengl"].faces[turned])
    assert [face.max() > 0.1 for face in difference] == [k == place for k in range(6)]


def test_each_edge_of_upright_faces_has_two_faces_of_equal_directions():
    """Closed form of the edges that the seams compare."""
    from envlights.environment.layouts import seams

    at = dict(zip(FACES, upright_directions(5, border=True), strict=True))
    assert len(seams._EDGES) == 12
    for one, side, other, other_side, turn in seams._EDGES:
        first = seams._side(at[one], side)
        np.testing.assert_allclose(first, seams._side(at[other], other_side)[::turn], atol=1e-15)


@pytest.mark.parametrize("order", sorted(CROSSES))
def test_neighbours_in_a_cross_share_their_edge(order):
    """An unfolded cube is a surface: directions do not jump between squares, but at the back."""
    n = 4
    image = cross_of_faces(upright_directions(n, border=True), order)
    rows, columns = image.shape[0] // n, image.shape[1] // n
    joined = 0
    for row, column in np.ndindex(rows, columns):
        for down, right in ((1, 0), (0, 1)):
            here = image[row * n : row * n + n, column * n : column * n + n]
            row_end, column_end = (row + down) * n, (column + right) * n
            there = image[row_end : row_end + n, column_end : column_end + n]
            if there.size and here.any() and there.any():
                edges = (here[-1], there[0]) if down else (here[:, -1], there[:, 0])
                joined += np.allclose(*edges)
    assert joined == (4 if order == "vertical-cross-upright" else 5)


@pytest.mark.parametrize("path", paths_of_real_maps("openexr_envmaps/*Cube.exr"), ids=str)
def test_cubes_of_openexr_show_their_panorama(path):
    """Pairs of one world, written by the library itself."""
    from envlights.environment.files.images import read_image

    image = read_image(path, any_projection=True)
    panorama = read_image(str(path).replace("Cube", "LatLong")).pixels
    arranged = recognise(image.pixels, image.hints)
    n = arranged.layout.width
    faces = arranged.samples.reshape(6, n, n, 3)[:, ::8, ::8]
    directions = upright_directions(n, border=True)[:, ::8, ::8]
    wanted = looked_up(_cells(panorama), directions)
    for face, truth in zip(faces, wanted, strict=True):
        logs = np.log(face.mean(axis=2) + 1e-3), np.log(truth.mean(axis=2) + 1e-3)
        assert np.median(np.abs(logs[0] - logs[1])) < 0.05
        if min(log.std() for log in logs) > 0.1:
            assert np.corrcoef(logs[0].ravel(), logs[1].ravel())[0, 1] > 0.8


def _cells(panorama):
    return el.EnvMap(panorama, layout=el.io.Layout(registration="border-sampled")).cells()
