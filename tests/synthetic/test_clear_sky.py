"""Clear sky with its sun: irradiance in closed form, directions, refusals."""

import numpy as np
import pytest

import envlights as el
from envlights.kernels.image import LUMINANCE

UP = [[0.0, 1.0, 0.0]]
SUN = np.array([0.48, 0.6, 0.64])


@pytest.mark.parametrize("ratio", [0.0, 3.0])
def test_sky_and_sun_have_the_irradiance_of_the_ratio(ratio):
    sky = el.synthetic.clear_sky(256, ratio=ratio)
    env = el.EnvMap(sky.radiance)
    upward = float(env.probe(UP)[0] @ LUMINANCE)
    assert upward == pytest.approx(1 + ratio * SUN[1], rel=2e-3)
    assert len(sky.lights) == (ratio > 0)


@pytest.mark.parametrize("direction", [[0, 1, 0], [0, 1, -2], [1e-9, 1, -2], [2, 1, 3]])
def test_the_sun_is_where_it_was_put(direction):
    sky = el.synthetic.clear_sky(256, direction)
    unit = np.array(direction) / np.linalg.norm(direction)
    assert np.degrees(np.arccos(min(sky.lights.direction[0] @ unit, 1))) < 0.2
    assert sky.lights.luminance[0] == pytest.approx(4.0, rel=2e-3)


def test_the_ground_reflects_a_fifth_of_its_light_in_the_sun():
    sky = el.synthetic.clear_sky(128, ratio=3.0)
    ground = np.unique((sky.radiance[64:] @ LUMINANCE).round(4))
    assert len(ground) == 2
    shade, sun = np.pi * ground / 0.2
    # The ground has a colour, so that luminance differs by a few percent.
    assert shade == pytest.approx(1.0, rel=0.1)
    assert sun == pytest.approx(1 + 3 * SUN[1], rel=0.1)


def test_a_third_of_the_ground_is_in_shadow():
    luminance = el.synthetic.clear_sky(256).radiance[128:] @ LUMINANCE
    weight = el.kernels.pixel_solid_angles(256, 512)[128:]
    is_dark = luminance < (luminance.min() + luminance.max()) / 2
    assert weight[is_dark].sum() / (2 * np.pi) == pytest.approx(1 / 3, abs=0.01)


def test_the_sky_is_brighter_around_the_sun_and_at_the_horizon():
    luminance = el.synthetic.clear_sky(180, [0, 1, -1], ratio=0.0).radiance @ LUMINANCE
    # Azimuth 0 is the first column; 45 degrees above the horizon is row 45.
    assert luminance[45, 0] > 3 * luminance[45, 180]
    assert luminance[88, 180] > luminance[45, 180]


@pytest.mark.parametrize(
    ("sun", "message"),
    [
        ([0, 0, 0], "three finite numbers, and not all 0"),
        ([0, -1, 2], "above the horizon, with y > 0"),
        ([0, np.nan, 1], "three finite numbers, and not all 0"),
        ([1, 2], "three finite numbers, and not all 0"),
    ],
)
def test_an_impossible_sun_is_refused(sun, message):
    with pytest.raises(el.EnvLightsError, match=f"sun must be {message}"):
        el.synthetic.clear_sky(64, sun)
