"""Picture of a sun: marks on the map, and shadows."""

import numpy as np
import pytest
from matplotlib.collections import LineCollection

import envlights as el
from tests.sun.suns import TOWARDS, clipped, sky, sun_of


def labels(figure):
    return [text.get_text() for text in figure.axes[0].get_legend().get_texts()]


def test_the_map_shows_the_sun_its_uncertainty_and_the_clipped_part():
    env, plateau = clipped(128, 9)
    figure = el.plot.sun(env, sun_of(plateau))
    assert labels(figure) == ["clipped part", "the sun", "two of three suns are inside"]
    on_map, *shadows = figure.axes
    outline, _ = [each for each in on_map.collections if isinstance(each, LineCollection)]
    ends = np.concatenate(outline.get_segments())
    azimuth, elevation = np.degrees([np.arctan2(TOWARDS[0], -TOWARDS[2]), np.arcsin(TOWARDS[1])])
    middle = (ends.min(axis=0) + ends.max(axis=0)) / 2
    np.testing.assert_allclose(middle, [azimuth, elevation], atol=2)
    assert ends[:, 1].max() - ends[:, 1].min() == pytest.approx(18, abs=3)
    titles = [each.get_title().splitlines()[0] for each in shadows]
    assert titles == ["the map as it is", "with the sun as a light"]
    assert "a guess: true times 0.5 to 2" in figure.get_suptitle()


def test_the_shadow_of_the_sun_is_darker_than_that_of_the_glow():
    env, plateau = clipped(128)
    _, before, after = el.plot.sun(env, sun_of(plateau)).axes
    darkest = [
        np.quantile(np.asarray(axes.images[0].get_array()), 0.02) for axes in (before, after)
    ]
    assert darkest[1] < 0.6 * darkest[0]


@pytest.mark.parametrize("answer", ["perhaps", "no"])
def test_without_a_sun_there_is_one_image(answer):
    figure = el.plot.sun(sky(), sun_of(answer=answer))
    assert len(figure.axes) == 2
    assert f"answer '{answer}'" in figure.get_suptitle()


def test_a_map_without_any_sun_has_no_legend():
    figure = el.plot.sun(sky())
    assert figure.axes[0].get_legend() is None
