"""The closed room with boxes, and the light in it."""

import importlib

import numpy as np
import pytest

import envlights as el


def test_a_wall_of_the_closed_room_sees_nothing_but_walls():
    """The form factors of a closed room sum to one, but for what patches in corners lose."""
    room = importlib.import_module("envlights.synthetic.room")  # not the function of that name
    texels = room._charts(32)
    factors = room._form_factors(texels, texels)
    assert factors.sum(axis=1).mean() == pytest.approx(1, abs=0.1)
    exchange = texels.area[:, None] * factors
    assert np.abs(exchange - exchange.T).sum() < 0.05 * exchange.sum(), "light goes both ways"


def test_light_in_the_room_is_that_of_its_direct_light():
    one, two = el.synthetic.room(1, 16, seed=3), el.synthetic.room(2, 16, seed=3)
    np.testing.assert_array_equal(one.direct[0], two.direct[0])
    np.testing.assert_array_equal(one.indirect[0], two.indirect[0])
    assert (two.direct[0] != two.direct[1]).any()
    assert (two.indirect >= 0).all()


def test_a_room_without_whole_charts_is_refused():
    with pytest.raises(el.EnvLightsError, match="width must be a multiple of 4; got 18"):
        el.synthetic.room(1, 18)
