"""The picture of a clipped map."""

import io

import numpy as np
import pytest
from matplotlib.image import imread

import envlights as el
from envlights import plot
from envlights.synthetic import Disc, scene


def lamps(count):
    shapes = [Disc((np.sin(a), 0.4, np.cos(a)), 5.0, (9, 9, 9)) for a in np.arange(count) * 0.4]
    return el.EnvMap(
        np.minimum(scene(128, background=[0.1] * 3, shapes=shapes).radiance, 1), white=1.0
    )


def test_the_picture_shows_the_clipped_share_the_depth_and_the_lights():
    env = lamps(2)
    figure = plot.plateau_picture(env, el.detect(env))
    above, below, _ = figure.axes
    title = figure.get_suptitle().replace("\n", " ")
    assert f"{100 * env.clipped_fraction:.2g} % of the sphere" in title
    depth = below.images[0].get_array()
    assert np.nanmax(depth) == pytest.approx(5.0, abs=0.8)
    clipped = above.images[1].get_array()[..., 3] > 0
    np.testing.assert_array_equal(clipped, (env.radiance >= 0.985).any(axis=2))
    for axes in (above, below):
        assert {"1", "2"} <= {text.get_text() for text in axes.texts}
    assert imread(io.BytesIO(figure._repr_png_())).std() > 0.05


@pytest.mark.parametrize("count", [0, 14])
def test_no_light_and_many_are_drawn_too(count):
    env = lamps(count)
    figure = plot.plateau_picture(env, el.detect(env))
    assert figure.get_suptitle().startswith(f"{count} lights in clipped regions")
    assert bool(figure.axes[0].texts) == bool(count)


def test_maps_and_lights_without_a_white_are_refused():
    env = lamps(1)
    with pytest.raises(el.EnvLightsError, match="the map has no clip level"):
        plot.plateau_picture(env.radiance, el.detect(env))
    with pytest.raises(el.EnvLightsError, match="a map that is not clipped"):
        plot.plateau_picture(env, el.detect(env.radiance))
