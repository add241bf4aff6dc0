"""Windows with a view: sky above a garden, found by their edges."""

import numpy as np
import pytest
from benchmarks.cards import corner_error, views

import envlights as el
from envlights.kernels.sphere import pixel_directions
from tests.conftest import real_maps
from tests.public_maps import public_maps

#: Corners of the window of `lebombo`, as columns and rows of 1024 x 512 pixels, marked by hand at
#: the outer edge of its white frame, from the top left one to the right.
LEBOMBO = [(575.3, 198.0), (728.0, 218.0), (728.0, 315.0), (575.7, 341.7)]
#: Corners of both windows behind one curtain, with the lit cornice above.
INTERIOR = [(523.2, 143.0), (713.0, 155.9), (711.8, 299.0), (523.2, 306.0)]


def directions_of(corners):
    """Unit vectors of points of a map of 1024 x 512 pixels."""
    column, row = np.transpose(corners)
    phi, theta = 2 * np.pi * column / 1024, np.pi * row / 512
    sine = np.sin(theta)
    return np.stack([np.sin(phi) * sine, np.cos(theta), -np.cos(phi) * sine], axis=1)


def assert_within_a_degree(cards, marked):
    window = cards.corners[cards.shape.index("rectangle")]
    cosine = np.einsum("ij,ij->i", window, directions_of(marked)).clip(-1, 1)
    assert np.rad2deg(np.arccos(cosine)).max() < 1.0
    assert any("by edges of the map" in note for note in cards.notes)


@pytest.fixture(scope="module")
def rooms():
    return [(el.EnvMap(radiance), matrix) for radiance, matrix in views(4, 3)]


def test_windows_with_a_view_are_rectangles_with_the_corners_of_their_frames(rooms):
    for env, matrix in rooms:
        cards, _ = el.split(env, shapes=True)
        assert cards.shape[0] == "rectangle"
        assert corner_error(cards, matrix, env.width) < 1.0
        assert any("by edges of the map" in note for note in cards.notes)


def test_the_whole_view_leaves_the_map(rooms):
    env, matrix = rooms[0]
    cards, rest = el.split(env, shapes=True)
    p = pixel_directions(env.height, env.width) @ np.linalg.inv(matrix).T
    place = p[..., :2] / np.where(p[..., 2:] > 1e-6, p[..., 2:], np.inf)
    inside = ((place > 0.05) & (place < 0.95)).all(axis=-1) & (p[..., 2] > 1e-6)
    wall = rest.radiance[~inside & (p[..., 2] > 0)]
    assert rest.radiance[inside].max() < np.quantile(wall, 0.999)
    normals = el.kernels.icosphere(320)[0]
    both = rest.probe(normals) + cards.to_map(env.width).probe(normals)
    assert np.abs(both / env.probe(normals) - 1).max() < 1e-3


def test_a_map_turned_about_the_vertical_has_turned_windows(rooms):
    env, matrix = rooms[1]
    columns = env.width // 3
    turned, _ = el.split(np.roll(env.radiance, columns, axis=1), shapes=True)
    angle = 2 * np.pi * columns / env.width
    cosine, sine = np.cos(angle), np.sin(angle)
    turn = np.array([[cosine, 0, -sine], [0, 1, 0], [sine, 0, cosine]])
    assert corner_error(turned, turn @ matrix, env.width) < 1.0


def test_a_wall_without_contrast_on_one_side_has_no_window(rooms):
    env, matrix = rooms[2]
    p = pixel_directions(env.height, env.width) @ np.linalg.inv(matrix).T
    b = np.where(p[..., 2] > 0, p[..., 1] / p[..., 2], 0)
    inside = (b > 0.8) & (b < 1) & (p[..., 0] > 0) & (p[..., 0] < p[..., 2])
    radiance = env.radiance.copy()
    radiance[b > 0.8] = np.median(radiance[inside])
    cards, _ = el.split(radiance, shapes=True)
    assert not any("by edges of the map" in note for note in cards.notes)


@public_maps("interior")
def test_two_windows_behind_a_curtain_are_one_card(path):
    cards, _ = el.split(path, shapes=True)
    assert_within_a_degree(cards, INTERIOR)


@real_maps("hdr/lebombo_1k.hdr", all_quick=True)
def test_the_window_of_a_room_with_a_garden_has_its_corners(path):
    cards, _ = el.split(path, shapes=True)
    assert_within_a_degree(cards, LEBOMBO)
