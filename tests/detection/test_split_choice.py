"""Choice of the lights that a split removes, and refusals."""

import numpy as np
import pytest

import envlights as el
from envlights.synthetic import Disc
from tests.detection.worlds import three, world


def test_lights_are_chosen_by_number_by_share_or_by_name():
    env = three()
    found = el.detect(env)
    assert len(found) == 3
    one = el.split(env, 1)
    assert len(one.lights) == 1
    np.testing.assert_allclose(one.lights.direction[0], found.direction[0], atol=1e-4)
    assert "2 lights stay in the map" in str(one.lights.report)
    for same in (el.split(env, found[:1]), el.split(env, found[[0]]), el.split(env, fraction=0.5)):
        np.testing.assert_array_equal(same.remainder.radiance, one.remainder.radiance)
    assert len(el.split(env, fraction=0.51).lights) == 2
    assert len(el.split(env, fraction=1).lights) == len(el.split(env).lights) == 3
    together = np.cumsum(found.flux_fraction)
    for number, part in enumerate(together / together[-1], 1):
        assert len(el.split(env, fraction=part).lights) == number
    assert len(el.split(env, 2, fraction=1).lights) == 2
    assert len(el.split(env, 0).lights) == len(el.split(env, fraction=0).lights) == 0
    others = el.split(env, found[np.array([False, True, True])])
    left = el.detect(others.remainder)
    assert len(left) == 1
    np.testing.assert_allclose(left.direction[0], found.direction[0], atol=1e-4)


def test_a_lamp_that_stays_is_not_touched_by_one_beside_it():
    env = world([Disc((1, 0, 0), 3.0, (90,) * 3), Disc((1, 0, 0.17), 3.0, (60,) * 3)])
    found = el.detect(env)
    assert len(found) == 2
    rows, columns = found[1:].members.pixel.T
    np.testing.assert_array_equal(
        el.split(env, found[:1]).remainder.radiance[rows, columns], env.radiance[rows, columns]
    )


def test_options_of_detect_are_passed_through():
    assert len(el.split(three(), max_lights=2).lights) == 2


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"lights": -1}, "lights"),
        ({"lights": True}, "lights must be a number"),
        ({"lights": "sun"}, "lights must be a number"),
        ({"fraction": 1.5}, "fraction"),
        ({"methods": "tree"}, None),
        ({"lights": "found", "fraction": 0.5}, "fraction has no effect"),
        ({"lights": "found", "gap_deg": 1}, "gap_deg has no effect"),
        ({"lights": "article"}, 'got those of method "loghin"'),
        ({"lights": "smaller"}, "they are from a map that was reduced to 96x48"),
        ({"lights": "elsewhere"}, "light 0 .* peak luminance of 90, .* pixel here has 0.286"),
        ({"lights": "brighter"}, "light 0 .* peak luminance of 90.18, .* pixel here has 90"),
    ],
)
def test_refusals(arguments, sentence):
    turned, brighter = np.roll(three().radiance, 64, axis=1), three().radiance * np.float32(1.002)
    named = {
        "found": el.detect(three()),
        "article": el.papers.loghin.detect(three()),
        "smaller": el.detect(world([], 48)),
        "elsewhere": el.detect(turned),
        "brighter": el.detect(brighter),
    }
    given = {
        name: named.get(value, value) if name == "lights" else value
        for name, value in arguments.items()
    }
    with pytest.raises(el.EnvLightsError if sentence else TypeError, match=sentence):
        el.split(three(), **given)
