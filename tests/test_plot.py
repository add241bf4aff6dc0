"""Pictures of a map with its lights: what they take, and that any notebook shows them."""

import io

import numpy as np
import pytest
from matplotlib.image import imread

import envlights as el
from envlights import plot

HALL = el.EnvMap(el.synthetic.hall(64).radiance)


@pytest.mark.parametrize(
    ("draw", "lights"),
    [(plot.picture, el.fit(HALL, lights=2)), (plot.detection_picture, el.detect(HALL))],
)
def test_a_picture_of_an_array_is_that_of_its_map(draw, lights):
    of_map, of_array = draw(HALL, lights), draw(np.array(HALL.radiance), lights)
    pixels = [imread(io.BytesIO(each._repr_png_())) for each in (of_map, of_array)]
    np.testing.assert_array_equal(*pixels)
    assert pixels[0].std() > 0.05  # something is drawn


def test_the_title_says_which_normals_the_error_is_of():
    title = plot.picture(HALL, el.fit(HALL, lights=1, normals="upper")).get_suptitle()
    assert "on 5120 upward normals" in title
    rig = el.Rig([1, 1, 1], el.Lights([[0, 1, 0]], [[1, 1, 1]]), error=0.5)
    assert (
        "ambient + 1 light: relative RMS error 50 %, as given"
        in plot.picture(HALL, rig).get_suptitle()
    )
