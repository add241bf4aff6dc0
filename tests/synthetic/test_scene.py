"""Synthetic maps and their known lights."""

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
    with pytest.raises(el.EnvLightsError, match="a direction must be three finite numbers"):
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


@pytest.mark.parametrize("level", [1.0, 1e-3, 1e3])
def test_irradiance_with_background_is_the_map_summed_over_the_light(level):
    """A pixel sun and a disc before a gradient, against a sum over the stored pixels."""
    height = 256
    up = el.kernels.pixel_directions(height, 2 * height)[..., 1:2]
    sky = level * (1.2 + up) * [0.9, 1.0, 1.1]
    shapes = [
        PixelSun((0, 0.3, -1), level * np.full(3, 1e5)),
        Disc((1, 0, 0), 8, level * np.full(3, 30)),
    ]
    world = synthetic.scene(height, background=sky, shapes=shapes)
    is_sun = world.radiance[..., :1] > 1e4 * level
    is_disc = shapes[1].coverage(height)[..., None] > 0
    assert is_sun.sum() == 1
    summed = [flux(world.radiance * is_sun), flux(world.radiance * is_disc)]
    np.testing.assert_allclose(world.irradiance_with_background[0], summed[0], rtol=1e-6)
    # The sum over whole pixels has the background of those at the rim as well: 30 to 1 in
    # radiance, and half of a ring one pixel wide of a disc of 11 pixels in radius.
    np.testing.assert_allclose(world.irradiance_with_background[1], summed[1], rtol=5e-3)
    assert (world.irradiance_with_background[1] < summed[1]).all()


def test_what_a_camera_clips_is_no_flux():
    lamp = Disc((1, 0, 0), 10, (50, 50, 50))
    world = synthetic.scene(
        128, background=(0.2,) * 3, shapes=[lamp], camera=lambda radiance: np.minimum(radiance, 1)
    )
    added = 0.8 * (lamp.coverage(128)[..., None] > 0) * np.ones(3)
    np.testing.assert_allclose(world.lights.irradiance[0], flux(added), rtol=1e-6)


def test_a_pixel_sun_is_seen_at_the_centre_of_its_pixel():
    centres = el.kernels.pixel_directions(64, 128)
    for row, column in [(0, 5), (20, 0), (33, 127), (63, 64)]:
        beside = centres[row, column] + [1e-5, 0, 1e-5]
        world = synthetic.scene(64, background=(1, 1, 1), shapes=[PixelSun(beside, (1e5,) * 3)])
        np.testing.assert_allclose(world.lights.direction[0], centres[row, column], atol=1e-12)


@pytest.mark.parametrize("radius", [2.0, 8.0])
@pytest.mark.parametrize("direction", [(0, 0, -1), (0, 1, 0), (0.05, -1, 0), (0.01, 0.5, -1)])
def test_lights_on_the_seam_and_the_poles_are_as_strong_as_elsewhere(direction, radius):
    def lamp(towards):
        return synthetic.scene(256, shapes=[Disc(towards, radius, (3, 3, 3))])

    here, elsewhere = lamp(direction), lamp((0.8, 0.1, 0.5))
    # The rim is known to half a sample of 180 / 256 / 4 = 0.18 degrees: where it lies along a row
    # of samples, as around a pole, all of it may be off by that much.
    np.testing.assert_allclose(
        here.lights.irradiance, elsewhere.lights.irradiance, rtol=2 * 0.09 / radius
    )
    assert here.angular_radius_deg[0] == pytest.approx(radius, abs=0.09)
    towards = np.array(direction) / np.linalg.norm(direction)
    assert np.rad2deg(np.linalg.norm(here.lights.direction[0] - towards)) < 0.02


def test_a_window_with_bars_is_one_light_without_the_bars():
    glass = Rectangle((1, 0, 0), 20, 12, (9, 9, 9))
    barred = Rectangle((1, 0, 0), 20, 12, (9, 9, 9), panes=(2, 3), bar_deg=0.4)
    whole, divided = (synthetic.scene(512, shapes=[window]) for window in (glass, barred))
    assert len(divided.lights) == 1
    # One bar upright and two across, less where they cross.
    bars = (0.4 / 20 + 2 * 0.4 / 12) - 2 * (0.4 / 20) * (0.4 / 12)
    assert divided.solid_angle[0] / whole.solid_angle[0] == pytest.approx(1 - bars, abs=2e-3)


def test_a_turn_by_90_degrees_swaps_the_sides():
    upright = Rectangle((1, 0.3, 0), 30, 5, (1, 1, 1)).coverage(128)
    turned = Rectangle((1, 0.3, 0), 5, 30, (1, 1, 1), tilt_deg=90).coverage(128)
    np.testing.assert_allclose(turned, upright, atol=0.26)  # a row of samples on an edge
    assert turned.sum() == pytest.approx(upright.sum(), rel=1e-3)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: el.synthetic.scene(2, background=[[1, 2], [3]]), "background must be an array of"),
        (lambda: el.synthetic.scene(2**31), "height must be a whole number up to 1048576"),
        (lambda: el.synthetic.plain(0, 2**31), "height must be a whole number up to 1048576"),
        (lambda: el.synthetic.rigs(10**6), "number must be a whole number up to 20000"),
    ],
)
def test_what_no_scene_can_be_made_of_is_refused(make, sentence):
    with pytest.raises(el.EnvLightsError, match=sentence):
        make()


def test_a_synthetic_map_is_taken_as_a_map():
    hall = synthetic.hall(32)
    assert el.EnvMap(hall) == el.EnvMap(hall.radiance)
    assert np.asarray(hall) is hall.radiance
    assert np.array(hall, dtype=np.float64).dtype == np.float64
