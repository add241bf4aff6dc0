"""Synthetic maps have the lights that they say."""

import importlib

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import envlights as el
from envlights import synthetic
from envlights.synthetic import Disc, PixelSun, Rectangle
from tests.helpers import flux


@given(st.floats(0, 1), st.floats(0, 1), st.floats(3, 60))
@example(1.9073486328125e-06, 0.0, 17.25)
def test_discs_have_the_solid_angle_of_a_cap_wherever_they_stand(u, v, radius):
    (direction,) = el.kernels.uniform_sphere([[u, v]])
    lamp = synthetic.scene(64, shapes=[Disc(direction, radius, (1, 2, 4))])
    cap = 2 * np.pi * (1 - np.cos(np.deg2rad(radius)))
    # Coverage is sampled every 180 / 64 / 4 = 0.7 degrees: the rim may be half of that off, d(a) at
    # the angle a around it. That moves the middle by the mean of 2 d(a) cos a, which is at most
    # 4 / pi of 0.35 degrees: outwards on one half of the rim, inwards on the other.
    assert lamp.solid_angle[0] == pytest.approx(cap, rel=0.75 / radius)
    np.testing.assert_allclose(lamp.lights.irradiance[0], flux(lamp.radiance), rtol=1e-6)
    assert np.rad2deg(np.arccos(min(lamp.lights.direction[0] @ direction, 1))) < 0.45


def test_rectangles_have_the_solid_angle_of_a_pyramid():
    """Their closed form is 4 asin(sin(a / 2) sin(b / 2)), with the opening angles a, b."""
    lamp = synthetic.scene(256, shapes=[Rectangle((1, 0, 0), 40, 20, (1, 1, 1))])
    pyramid = 4 * np.arcsin(np.sin(np.deg2rad(20)) * np.sin(np.deg2rad(10)))
    assert lamp.solid_angle[0] == pytest.approx(pyramid, rel=5e-3)


@pytest.mark.parametrize("direction", [(0, 0, -1), (0, 1, 0), (0, -1, 0), (1, 0.2, 0.3)])
def test_a_pixel_sun_is_one_pixel(direction):
    sun = synthetic.scene(32, background=(0.5, 0.5, 0.5), shapes=[PixelSun(direction, (9, 9, 9))])
    assert (sun.radiance == 9).all(axis=2).sum() == 1
    (row,), (column,) = (sun.radiance[..., 0] == 9).nonzero()
    solid_angle = el.kernels.pixel_solid_angles(32, 64)[row, column]
    np.testing.assert_allclose(sun.lights.irradiance[0], 8.5 * solid_angle, rtol=1e-6)


def test_the_front_shape_hides_the_one_behind():
    both = synthetic.scene(
        64, shapes=[Disc((1, 0, 0), 30, (5, 5, 5)), Disc((1, 0, 0), 20, (1, 1, 1))]
    )
    ring, front = both.solid_angle
    assert ring == pytest.approx(2 * np.pi * (np.cos(np.pi / 9) - np.cos(np.pi / 6)), rel=0.02)
    assert front == pytest.approx(2 * np.pi * (1 - np.cos(np.pi / 9)), rel=0.02)
    assert both.radiance[32, 32, 0] == 1


def test_the_hall_has_three_windows_that_outshine_the_rest():
    hall = synthetic.hall(128)
    assert len(hall.lights) == 3
    assert hall.radiance.min() > 0
    assert hall.lights.irradiance.sum() > 0.4 * flux(hall.radiance).sum()


def test_no_direction_is_refused():
    with pytest.raises(el.EnvLightsError, match="a direction must be three numbers"):
        synthetic.scene(8, shapes=[Disc((0, 0, 0), 5, (1, 1, 1))])


def test_shapes_around_one_direction_keep_their_own_solid_angles_and_flux():
    lamp = synthetic.scene(
        64, shapes=[Disc((0, 1, 0), 20, (1, 1, 1)), Disc((0, 1, 0), 5, (50, 50, 50))]
    )
    inner, outer = 2 * np.pi * (1 - np.cos(np.deg2rad([5, 20])))
    np.testing.assert_allclose(lamp.solid_angle, [inner, outer - inner], rtol=0.05)
    np.testing.assert_allclose(lamp.lights.irradiance.sum(axis=0), flux(lamp.radiance), rtol=1e-6)
    np.testing.assert_allclose(lamp.lights.irradiance[:, 0], [50, 1] * lamp.solid_angle, rtol=1e-6)


@pytest.mark.parametrize(
    "shapes",
    [
        [Disc((1, 0.01, 0.02), 0.01, (1, 1, 1))],
        [Disc((1, 0, 0), 10, (0, 0, 0))],
        [PixelSun((1, 0, 0), (9, 9, 9)), Disc((1, 0, 0), 20, (1, 1, 1))],
    ],
    ids=["smaller than a sample", "black", "hidden"],
)
def test_shapes_that_add_no_light_are_refused(shapes):
    with pytest.raises(el.EnvLightsError, match="shape 0 adds no light to the map"):
        synthetic.scene(64, shapes=shapes)


@pytest.mark.parametrize(
    ("background", "direction", "radiance", "message"),
    [
        ((1, 2), (1, 0, 0), (1, 1, 1), r"background must be finite RGB"),
        ((np.nan, 0, 0), (1, 0, 0), (1, 1, 1), r"background must be finite RGB"),
        ((0, 0, 0), (1, 0, 0), (1, 2), r"radiance must be finite RGB"),
        ((0, 0, 0), "up", (1, 1, 1), r"a direction must hold real numbers"),
    ],
)
def test_impossible_scenes_are_refused(background, direction, radiance, message):
    with pytest.raises(el.EnvLightsError, match=message):
        synthetic.scene(8, background=background, shapes=[Disc(direction, 30, radiance)])


def test_a_wall_of_the_closed_room_sees_nothing_but_walls():
    """The form factors of a closed room sum to one, but for what patches in corners lose."""
    room = importlib.import_module("envlights.synthetic.room")  # not the function of that name
    texels = room._charts(32)
    factors = room._form_factors(texels, texels)
    assert factors.sum(axis=1).mean() == pytest.approx(1, abs=0.1)
    seen = texels.area[:, None] * factors
    assert np.abs(seen - seen.T).sum() < 0.05 * seen.sum(), "light goes both ways"


def test_light_in_the_room_is_that_of_its_direct_light():
    one, two = el.synthetic.room(1, 16, seed=3), el.synthetic.room(2, 16, seed=3)
    np.testing.assert_array_equal(one.direct[0], two.direct[0])
    np.testing.assert_array_equal(one.indirect[0], two.indirect[0])
    assert (two.direct[0] != two.direct[1]).any()
    assert (two.indirect >= 0).all()


def test_a_room_without_whole_charts_is_refused():
    with pytest.raises(el.EnvLightsError, match="width must be a multiple of 4; got 18"):
        el.synthetic.room(1, 18)
