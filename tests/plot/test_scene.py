"""The scene under a map and under rigs: round trips through Mitsuba, errors without noise."""

import numpy as np
import pytest

import envlights as el
from envlights import plot

pytest.importorskip("mitsuba")

from envlights.scene.still_life import still_life

LIGHTS = el.Lights(
    [[0.48, 0.8, 0.36], [-0.6, 0.64, -0.48], [0, 0.28, 0.96]],
    [[3, 2, 1], [1, 1.5, 2], [0.5, 0.5, 0.4]],
    [0.05, 0.6, 0.25],
)
RIG = el.Rig([0.1, 0.2, 0.3], LIGHTS, error=0.0)


def relative(seen, wanted):
    return np.linalg.norm(seen - wanted) / np.linalg.norm(wanted)


@pytest.mark.slow
def test_a_rig_and_its_map_give_the_same_image():
    """Lights one at a time and added, or all at once in a map."""
    under_map = still_life(RIG.to_map(256), 1.0, 32, 0)
    under_rig = still_life(RIG, 1.0, 32, 1)
    assert under_rig.noise < 0.05
    assert under_rig.error(under_map) < 0.01
    points = el.Rig(RIG.ambient, el.Lights(LIGHTS.direction, LIGHTS.irradiance), error=0.0)
    assert still_life(points, 1.0, 32, 1).error(under_map) > 0.03


def test_one_bounce_is_the_direct_light_alone():
    sky = el.Rig([1.0] * 3, LIGHTS[:0], error=0.0)
    direct, whole = (still_life(sky, 0.0, 16, 3, bounces).image for bounces in (1, 3))
    # A surface of reflectance 0.7 reflects at most 0.7 of a sky of 1, and more from other surfaces.
    assert 0.4 < direct.mean() < 0.7
    assert whole.mean() > 1.02 * direct.mean()


@pytest.mark.slow
def test_noise_is_not_taken_for_an_error():
    """Few paths and many: the noise falls, the error stays what it is."""
    truth = still_life(RIG, 0.0, 64, 0)
    brighter = el.Rig(
        1.1 * RIG.ambient,
        el.Lights(LIGHTS.direction, 1.1 * LIGHTS.irradiance, LIGHTS.angular_radius),
        0.0,
    )
    few, many = (still_life(brighter, 0.0, samples, 5) for samples in (4, 64))
    assert many.noise < 0.5 * few.noise
    for still in (few, many):
        assert still.error(truth) == pytest.approx(0.1, rel=0.06)
    assert relative(few.image, truth.image) == pytest.approx(np.hypot(0.1, few.noise), rel=0.2)


def test_below_the_floor_no_light_passes():
    below = el.Rig([0, 0, 0], el.Lights([[0, -1, 0]], [[9, 9, 9]], [0.5]), error=0.0)
    still = still_life(below, 0.0, 1, 0)
    assert not still.image.any()
    assert still.noise == still.error(still) == 0


@pytest.mark.slow
def test_seeds_give_the_same_image_and_titles_tell_its_figures():
    env = el.EnvMap(el.synthetic.hall(32).radiance)
    rig = el.Rig([0.3] * 3, LIGHTS, error=0.0)
    once, again = (plot.scene(env, rig, RIG, samples=1, seed=3) for _ in range(2))
    titles = [axes.get_title() for axes in once.axes]
    assert titles == [axes.get_title() for axes in again.axes]
    assert titles[0].startswith("the map\nnoise ")
    assert titles[1].startswith("ambient + 3 lights with sizes\nerror ")
    assert titles.count("rig minus map") == 2
    for one, other in zip(once.axes, again.axes, strict=True):
        for image, same in zip(one.images, other.images, strict=True):
            np.testing.assert_array_equal(image.get_array(), same.get_array())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "rigs must be one rig or more, each an argument; got none"),
        ([LIGHTS], "rigs must be one rig or more, each an argument; got Lights"),
    ],
)
def test_what_is_no_rig_is_refused(arguments, message):
    with pytest.raises(el.EnvLightsError, match=message):
        plot.scene(np.ones((4, 8, 3)), *arguments)


def test_maps_that_mitsuba_reads_otherwise_are_refused():
    env = el.EnvMap(np.ones((4, 8, 3)), layout=el.io.Layout(registration="border-sampled"))
    with pytest.raises(el.EnvLightsError, match="must be cell-centred to be rendered; got border"):
        plot.scene(env, RIG, samples=1)
