"""The type `Cards`: geometry, radiance, drawing, and changes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import envlights as el
from envlights.cards import geometry

#: Square of half-width 1 at distance 1, and its irradiance for radiance 1 in closed form.
SQUARE = np.transpose([[-2.0, 0, 0], [0, -2, 0], [1, 1, 1]])
SQUARE_IRRADIANCE = 4 / np.sqrt(2) * np.arctan(1 / np.sqrt(2))


def one_card(shape: str = "rectangle", **changes) -> el.Cards:
    return el.Cards([shape], [SQUARE], [[3, 2, 1]], **changes)


def test_the_radiance_of_a_square_is_that_of_the_form_factor_of_a_parallel_square():
    assert np.allclose(one_card().radiance, np.array([[3, 2, 1]]) / SQUARE_IRRADIANCE)


@pytest.mark.parametrize("radius", [0.01, 0.3, 1.2])
def test_the_radiance_of_a_disc_is_that_of_a_light_of_its_angular_radius(radius):
    matrix = geometry.square_towards(np.array([0.6, 0.0, 0.8]), radius)
    disc = el.Cards(["disc"], [matrix], [[1, 1, 1]])
    assert np.allclose(disc.radiance, 1 / (np.pi * np.sin(radius) ** 2), rtol=1e-5)
    assert np.allclose(disc.angular_radius, radius, rtol=1e-5)


def test_corners_size_and_tilt_of_a_square_are_those_of_its_geometry():
    card = one_card()
    assert np.allclose(
        card.corners[0] * np.sqrt(3), [[1, 1, 1], [-1, 1, 1], [-1, -1, 1], [1, -1, 1]]
    )
    assert np.allclose(card.size, np.pi / 2)
    assert np.allclose(card.aspect, 1)
    assert np.allclose(card.tilt, 0)
    assert np.allclose(card.normal, [[0, 0, -1]])


@given(st.floats(-1.4, 1.4), st.floats(-3, 3), st.floats(0.02, 0.6))
def test_a_square_towards_a_light_reads_as_the_map(elevation, azimuth, radius):
    direction = np.array(
        [
            np.cos(elevation) * np.sin(azimuth),
            np.sin(elevation),
            np.cos(elevation) * np.cos(azimuth),
        ]
    )
    matrix = geometry.square_towards(direction, radius)
    assert np.linalg.det(matrix) > 0
    assert matrix[1, 1] <= 0, "V goes down"
    assert np.allclose(geometry.centres(matrix[None])[0], direction)


def test_a_texture_of_four_colours_is_drawn_as_the_map_shows_it():
    colours = np.eye(3)[[0, 1, 2, 0]].reshape(2, 2, 3)
    colours[1, 1] = [1, 1, 0]
    texture = np.kron(colours, np.ones((8, 8, 1)))
    drawn = el.Cards(["rectangle"], [SQUARE], [[3, 3, 1]], [texture]).to_map(256).radiance
    # The card is seen in the middle of the map; its left half is left of the middle.
    top_left, top_right = drawn[52, 116], drawn[52, 140]
    bottom_left, bottom_right = drawn[75, 116], drawn[75, 140]
    assert top_left[0] > 0
    assert top_left[1:].max() == 0
    assert top_right[1] > 0
    assert top_right[[0, 2]].max() == 0
    assert bottom_left[2] > 0
    assert bottom_left[:2].max() == 0
    assert bottom_right[:2].min() > 0
    assert bottom_right[2] == 0


@pytest.mark.parametrize("shape", ["rectangle", "disc", "point"])
@pytest.mark.parametrize("towards", [[0, 1, 0], [0, -1, 0], [0, 0, -1], [0.6, 0.48, 0.64]])
def test_a_drawn_card_has_its_irradiance_also_at_a_pole_and_the_seam(shape, towards):
    matrix = geometry.square_towards(np.array(towards, float), 0.3)
    cards = el.Cards([shape], [matrix], [[3, 2, 1]])
    assert np.allclose(cards.to_map(128).probe(cards.direction), [[3, 2, 1]], rtol=2e-3)


def test_a_distance_leaves_directions_radiance_and_irradiance_as_they_are():
    cards, far = one_card(), one_card().at(70.0)
    assert np.allclose(np.linalg.norm(geometry.centres(far.matrix), axis=1), 70)
    assert np.allclose(far.corners, cards.corners)
    assert np.allclose(far.radiance, cards.radiance)


def test_a_turned_card_lies_in_the_plane_and_is_seen_where_it_was():
    matrix = geometry.square_towards(np.array([0.0, 0.0, 1.0]), 0.02)
    card = el.Cards(["rectangle"], [matrix], [[1, 1, 1]])
    normal = np.array([0.6, 0, -0.8])
    turned = card.facing(0, normal)
    assert np.allclose(turned.normal, [normal])
    assert np.allclose(turned.tilt, np.arccos(0.8))
    assert np.abs(turned.corners - card.corners).max() < 0.02 * 0.03


def test_a_card_cannot_be_turned_edge_on():
    with pytest.raises(el.EnvLightsError, match="all its corners are seen"):
        one_card().facing(0, [1, 0, 0.1])


def test_rotated_cards_shine_from_the_rotated_directions():
    turn = np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]])
    card = one_card()
    assert np.allclose(card.rotated(turn).direction, card.direction @ turn.T)
    assert np.allclose(card.rotated(turn).radiance, card.radiance)


def test_a_dimmed_card_loses_its_place_among_the_brightest():
    other = np.diag([-1.0, 1, -1]) @ SQUARE
    cards = el.Cards(["rectangle", "tube"], [SQUARE, other], [[3, 3, 3], [2, 2, 2]])
    dimmed = cards.dimmed(0, 0.5)
    assert dimmed.shape == ("tube", "rectangle")
    assert np.allclose(dimmed.irradiance, [[2, 2, 2], [1.5, 1.5, 1.5]])
    assert np.allclose(dimmed.texture(1), cards.texture(0) * 0.5)
    assert np.allclose(cards.scaled(2).irradiance, 2 * cards.irradiance)
    assert dimmed.lights.direction.tolist() == dimmed.direction.tolist()


def test_a_slice_has_the_fields_of_its_cards():
    other = np.diag([-1.0, 1, -1]) @ SQUARE
    cards = el.Cards(["disc", "tube"], [SQUARE, other], [[3, 3, 3], [2, 2, 2]], overlap=[0.9, 0.8])
    assert cards[1:].shape == ("tube",)
    assert [card.overlap for card in cards] == [0.9, 0.8]
    assert cards[[1]] == cards[1:]
    assert cards[1].shape == "tube"
    assert "1 tube, 1 disc" in repr(cards)
    assert "tube" in str(cards)
    assert "<table>" in cards._repr_html_()
    assert cards.to_dict()["matrix"] == cards.matrix.tolist()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"shape": ["square"]}, "shape must be one of"),
        ({"shape": []}, "one name for each card"),
        ({"matrix": [np.diag([1.0, 1, -1])]}, "positive determinant"),
        ({"matrix": [np.eye(2)]}, r"shape \(n, 3, 3\)"),
        ({"irradiance": [[-1, 0, 0]]}, "not negative"),
        ({"irradiance": [[1, 0]]}, r"shape \(1, 3\)"),
        ({"overlap": [2]}, "from 0 to 1"),
        ({"textures": [[[1, 1, 1]]]}, "rows, columns, 3"),
        ({"textures": [[[[np.nan, 1, 1]]]]}, "finite"),
        ({"angular_radius": [4]}, "pi / 2"),
        ({"matrix": [[[1, 2], [1]]]}, "matrix must be an array of real numbers"),
        ({"irradiance": [[1, 1], [1]]}, "irradiance must be an array of real numbers"),
        ({"irradiance": [[1e300, 1, 1]]}, "irradiance must be finite, not negative, and at most"),
        ({"matrix": [SQUARE * [1e-3, 1e-3, 1]], "irradiance": [[3e38, 1, 1]]}, "the radiance of"),
        ({"textures": [[[1, 2], [1]]]}, "textures must be an array of real numbers"),
        ({"textures": 5}, "textures must be a sequence .* got 5"),
        ({"textures": np.array(5.0)}, "textures must be a sequence"),
    ],
)
def test_impossible_cards_are_refused(changes, message):
    arguments = {"shape": ["disc"], "matrix": [SQUARE], "irradiance": [[1, 1, 1]]} | changes
    with pytest.raises(el.EnvLightsError, match=message):
        el.Cards(**arguments)


def test_no_card_is_a_black_map():
    cards = el.Cards([], [], [])
    assert not cards.to_map(64).radiance.any()
    assert str(cards) == "no card"


@pytest.mark.parametrize(("number", "rest"), [(12, ""), (13, "1 more card"), (14, "2 more cards")])
def test_a_table_counts_the_cards_that_it_does_not_show(number, rest):
    card = one_card()
    cards = el.Cards(
        ["rectangle"] * number,
        np.repeat(card.matrix, number, axis=0),
        np.repeat(card.irradiance, number, axis=0),
        list(card.textures) * number,
    )
    assert cards.table().rest == rest
    assert len(cards.table().rows) == 12
