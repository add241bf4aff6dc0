"""Pictures of cards."""

import numpy as np
import pytest
from matplotlib.colors import to_hex

import envlights as el
from envlights.plot.cards import _COLOURS
from tests.export import cards

MAP = el.EnvMap(cards.to_map(cards.WINDOW, 128).radiance + np.float32(0.1))


def test_an_outline_goes_through_the_corners_of_the_card():
    (axes,) = el.plot.cards(MAP, cards.WINDOW).axes
    line = next(each for each in axes.lines if len(each.get_xdata()) > 100)
    assert to_hex(line.get_color()) == _COLOURS["rectangle"]
    drawn = np.column_stack(line.get_data())
    uv = el.kernels.direction_to_uv(cards.WINDOW.corners[0]) * (360, -180) + (0, 90)
    for corner in uv:
        assert np.linalg.norm(drawn - corner, axis=1).min() < 1e-9


def test_an_outline_over_the_seam_has_a_gap():
    over = el.Cards(["rectangle"], [cards.facing(0, 0, 40, 20)], [[1, 1, 1]])
    (axes,) = el.plot.cards(MAP, over).axes
    x = next(each for each in axes.lines if len(each.get_xdata()) > 100).get_xdata()
    assert np.isnan(x).any()
    steps = np.abs(np.diff(x))
    assert steps[np.isfinite(steps)].max() < 180


def test_a_texture_is_the_right_way_up():
    figure = el.plot.card_textures(cards.WINDOW)
    codes = figure.axes[0].images[0].get_array()
    brightest = [int(np.argmax(codes[row, column])) for row in (0, -1) for column in (0, -1)]
    assert brightest[:3] == [0, 1, 2]
    assert figure.axes[0].images[0].origin == "upper"


def test_a_ball_under_rest_and_cards_is_that_under_the_map():
    parts = el.cards.CardSplit(cards.WINDOW, el.EnvMap(np.full((64, 128, 3), 0.1, np.float32)))
    whole, _, ours = (
        np.asarray(each.images[0].get_array()) for each in el.plot.card_balls(MAP, parts).axes
    )
    assert np.abs(whole - ours).mean() < 0.01


def test_no_cards_are_drawn_too():
    none = cards.WINDOW[:0]
    assert len(el.plot.cards(MAP, none).axes) == 1
    el.plot.card_textures(none)
    el.plot.card_balls(MAP, el.cards.CardSplit(none, MAP))


def test_only_cards_are_drawn():
    with pytest.raises(el.EnvLightsError, match="cards must be Cards; got Lights"):
        el.plot.cards(MAP, cards.WINDOW.lights)
