"""Pictures of photographs with their lights."""

import io

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.image import imread

import envlights as el
from envlights import plot


@pytest.fixture(scope="module")
def night():
    image = np.full((200, 320, 3), 0.01)
    image[40:60, 200:230] = 3.0
    image[150:154, 30:34] = 1.0
    return image


def test_a_picture_of_a_photograph_is_that_of_its_lights(night):
    lights = el.detect_photograph(night, 70)
    pictures = [plot.photograph(lights), plot.photograph(night, fov=70)]
    pixels = [imread(io.BytesIO(each._repr_png_())) for each in pictures]
    np.testing.assert_array_equal(*pixels)
    assert pixels[0].std() > 0.05  # something is drawn


def test_links_go_from_the_samples_to_their_lights(night):
    lights = el.detect_photograph(night)
    (axes,) = plot.photograph(lights).axes
    (links,) = [each for each in axes.collections if isinstance(each, LineCollection)]
    segments = np.array(links.get_segments())
    assert len(segments) == len(lights.samples.pixel)
    np.testing.assert_allclose(segments[:, 1], lights.position[lights.samples.light])
    np.testing.assert_allclose(segments[:, 0], lights.samples.first[:, ::-1] + 0.5)
    # Row 0 is at the top.
    assert axes.get_ylim() == (200, 0)
    assert [text.get_text() for text in axes.texts] == ["1", "2"]


@pytest.mark.parametrize("shape", [(60, 300), (300, 60)])
def test_the_steps_have_a_panel_each(shape):
    image = np.full((*shape, 3), 0.01)
    image[20:40, 20:40] = 2.0
    figure = plot.photograph(image, steps=True)
    titles = [axes.get_title().split(":")[0] for axes in figure.axes]
    assert titles[1:] == ["2. bright samples", "3. survivors", "4. lights"]
    assert titles[0].startswith("1. the photograph")
    assert figure._repr_png_().startswith(b"\x89PNG")


def test_a_photograph_without_a_light_is_drawn():
    assert "0 lights" in plot.photograph(np.ones((30, 40))).get_suptitle()
