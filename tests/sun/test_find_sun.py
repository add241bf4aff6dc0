"""Direction and answer of `find_sun`."""

import numpy as np
import pytest

import envlights as el
from envlights.kernels.sphere import pixel_directions
from envlights.sun.direction import Estimate, sun_position
from envlights.sun.parts import best_part
from envlights.sun.sky_image import sky_image
from envlights.sun.spots import single_spot
from tests.helpers import angle_deg
from tests.sun.skies import HEIGHT, cie_clear, codes, expose, sunny, towards
from tests.sun.suns import photograph

PLACE = towards(130, 38)


def sun_in(picture):
    return el.find_sun(el.EnvMap(picture))


@pytest.fixture(scope="module")
def wide():
    """Picture of a sun in a wide white glow, and the direction of the sun."""
    radiance, _, sun = sunny(PLACE)
    return expose(radiance, 0.02)[0], sun


@pytest.fixture(scope="module")
def of_wide(wide):
    return sun_in(wide[0])


@pytest.mark.parametrize("elevation", [12, 35, 60, 80])
def test_the_clipped_pixel_of_a_sun_alone_is_found_to_half_a_pixel(elevation):
    radiance, _, sun = sunny(towards(75, elevation))
    # No part of the sky is white.
    picture = codes(radiance / (1.6 * cie_clear(sun).max()))
    answer = sun_in(picture)
    assert answer.answer == "sun"
    assert angle_deg(answer.direction, sun) < 0.5 * 180 / HEIGHT
    assert np.degrees(answer.plateau_radius) < 0.5


#: Rows, elevation in degrees, and fractions of the sphere that are white: the sun alone, a glow
#: that is almost white, and wide glows.
CLEAR = [
    *((512, elevation, (0.002, 0.01)) for elevation in (10, 30, 50, 70)),
    *((256, elevation, (0.001, 0.05)) for elevation in (20, 40, 60)),
    *(
        pytest.param(height, elevation, (0.001, 0.003, 0.01, 0.03, 0.05), marks=pytest.mark.slow)
        for height in (256, 512, 1024)
        for elevation in (10, 20, 27, 30, 40, 50, 60, 70)
    ),
]


@pytest.mark.parametrize(("height", "elevation", "shares"), CLEAR)
def test_the_sun_of_a_clear_sky_is_found_at_all_sizes_within_three_uncertainties(
    height, elevation, shares
):
    sun = towards(140, elevation)
    radiance = el.synthetic.clear_sky(height, sun).radiance
    for share in shares:
        answer = el.find_sun(photograph(radiance, share)[0])
        # At least 7 pixels of the disc are white in each of these pictures.
        assert answer.answer == "sun"
        error = angle_deg(answer.direction, sun)
        assert error < 3 * np.degrees(answer.direction_uncertainty)
        assert error < 0.7 or answer.plateau_radius > 0


def test_the_joint_error_of_two_estimates_holds_their_difference():
    # From equal errors, the mean has 1 / sqrt(2) of each, and half of any larger difference.
    for value, error in ((0.5, np.sqrt(0.5)), (np.sqrt(2), np.sqrt(0.5)), (8.0, 4.0)):
        joint = Estimate(0.0, 1.0).joined(Estimate(value, 1.0))
        assert joint.value == pytest.approx(value / 2)
        assert joint.error == pytest.approx(error)
    turned = Estimate(0.99, 1.0).joined(Estimate(0.01, 1.0), 400.0, period=1.0)
    assert np.cos(2 * np.pi * turned.value) == pytest.approx(1)
    assert turned.error == pytest.approx(4.0)


#: The glow of a low sun is wider towards the bright horizon, which every estimate follows a little.
#: The largest error of these skies is 2.2 times the uncertainty.
SIGMAS = 2.5


@pytest.mark.parametrize("share", [0.02, 0.06])
@pytest.mark.parametrize("elevation", [25, 38, 55])
def test_a_sun_in_a_white_glow_is_found_within_its_uncertainty(share, elevation):
    radiance, _, sun = sunny(towards(130, elevation))
    answer = sun_in(expose(radiance, share)[0])
    assert answer.answer == "sun"
    assert angle_deg(answer.direction, sun) < SIGMAS * np.degrees(answer.direction_uncertainty)
    assert {"depth", "symmetry", "sky"} == set(answer.evidence)


@pytest.mark.parametrize("columns", [1, 100, 181, 350])
def test_a_turn_of_the_map_turns_the_answer(wide, of_wide, columns):
    answer = sun_in(np.roll(wide[0], columns, axis=1))
    turned = of_wide.azimuth + columns / (2 * HEIGHT) * 2 * np.pi
    expected = towards(np.degrees(turned), np.degrees(of_wide.elevation))
    assert angle_deg(answer.direction, expected) < 0.2
    assert answer.points == of_wide.points
    np.testing.assert_allclose(answer.irradiance, of_wide.irradiance, rtol=1e-9)


def test_the_seam_through_the_sun_changes_nothing(wide, of_wide):
    shift = -int(of_wide.azimuth / (2 * np.pi) * 2 * HEIGHT)
    answer = sun_in(np.roll(wide[0], shift, axis=1))
    assert np.degrees(min(answer.azimuth, 2 * np.pi - answer.azimuth)) < 0.7
    assert answer.elevation == pytest.approx(of_wide.elevation, abs=np.radians(0.2))
    assert answer.plateau_radius == pytest.approx(of_wide.plateau_radius)


def test_a_mirrored_map_mirrors_the_answer(wide, of_wide):
    answer = sun_in(wide[0][:, ::-1])
    # Columns count from -z, so that azimuths change their sign.
    assert angle_deg(answer.direction, of_wide.direction * [-1, 1, 1]) < 0.2


def test_a_wall_before_half_of_the_glow_leaves_the_azimuth(wide, of_wide):
    picture, sun = wide
    directions = pixel_directions(*picture.shape[:2])
    azimuth = np.degrees(np.arctan2(directions[..., 0], -directions[..., 2])) % 360
    lift = np.degrees(np.arcsin(directions[..., 1]))
    walled = picture.copy()
    walled[(azimuth > 132) & (azimuth < 170) & (lift < 60)] = (90, 80, 70)
    answer = sun_in(walled)
    side = np.degrees(answer.azimuth) - np.degrees(np.arctan2(sun[0], -sun[2]))
    assert abs(side) * np.cos(answer.elevation) < 2 * np.degrees(answer.direction_uncertainty)
    assert answer.plateau_radius < of_wide.plateau_radius


def test_a_film_curve_is_recognised():
    radiance, _, sun = sunny(PLACE)
    for film in (False, True):
        x = radiance / np.quantile(radiance.max(axis=2), 0.95) * (7 if film else 1)
        curve = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14) if film else x
        env = el.EnvMap(codes(curve))
        image = sky_image(env.radiance, env.clip_level)
        position = sun_position(image, best_part(image))
        assert position.fit.fit.is_film == film
        assert angle_deg(position.direction, sun) < 2 * position.uncertainty


def disc(*arguments):
    return el.synthetic.Disc(*arguments)


def white_dome():
    return np.full((HEIGHT, 2 * HEIGHT, 3), 255, np.uint8)


def lit_window():
    window = el.synthetic.Rectangle((0.3, 0.4, 1), 30, 40, (3, 3.2, 3.5))
    return codes(
        el.synthetic.scene(HEIGHT, background=[0.08, 0.07, 0.06], shapes=[window]).radiance
    )


def softbox():
    lamp = el.synthetic.Rectangle((0.8, 0.6, 0), 20, 20, (9, 9, 9))
    return codes(el.synthetic.scene(HEIGHT, background=[0.01] * 3, shapes=[lamp]).radiance)


def moonless_night():
    picture = np.zeros((HEIGHT, 2 * HEIGHT, 3))
    picture[: HEIGHT // 2] = (0.004, 0.005, 0.008)
    rng = np.random.default_rng(3)
    stars = rng.integers(0, (HEIGHT // 2, 2 * HEIGHT), (40, 2))
    picture[stars[:, 0], stars[:, 1]] = rng.uniform(0.2, 3, (40, 1))
    return codes(picture)


def white_cloud():
    cloud = disc((0.2, 0.5, 1), 14.0, (2, 2, 2))
    sky = codes(el.synthetic.scene(HEIGHT, background=[0.45, 0.5, 0.56], shapes=[cloud]).radiance)
    sky[HEIGHT // 2 :] = 90
    return sky


@pytest.mark.parametrize(
    "scene",
    [white_dome, lit_window, softbox, moonless_night, white_cloud],
    ids=lambda s: s.__name__,
)
def test_other_white_things_are_no_sun(scene):
    assert sun_in(scene()).answer != "sun"


@pytest.mark.parametrize(
    ("scene", "question"),
    [
        (white_dome, "the sky is smooth"),
        (lit_window, "there is sky all round"),
        (softbox, "the sky is blue"),
        (white_cloud, "the sky is brighter around it"),
        (white_cloud, "shadows are blue"),
        (moonless_night, "it is the only one"),
        (moonless_night, "it is up"),
    ],
)
def test_a_question_says_why_it_is_no_sun(scene, question):
    assert not sun_in(scene()).points[question]


def test_a_single_white_pixel_in_blue_is_the_spot_and_none_of_two_is():
    picture = np.full((HEIGHT, 2 * HEIGHT, 3), (100, 140, 200), np.uint8)
    picture[60, 100] = 255
    directions = pixel_directions(HEIGHT, 2 * HEIGHT)
    assert angle_deg(spot_of(picture), directions[60, 100]) < 1e-4
    picture[60, 400] = 255
    assert spot_of(picture) is None


def test_a_spot_is_found_in_a_steep_even_glow():
    directions = pixel_directions(HEIGHT, 2 * HEIGHT)
    angle = np.arccos(np.clip(directions @ directions[60, 100], -1, 1))
    # In the ring, luminance falls by a fifth.
    radiance = np.array([0.5, 0.6, 0.8]) * np.exp(-6 * angle)[..., None]
    radiance[60, 100] = 1
    assert angle_deg(spot_of(codes(radiance)), directions[60, 100]) < 1e-4


def test_a_pixel_below_white_is_no_spot_in_a_sky_with_a_white_channel():
    picture = np.full((HEIGHT, 2 * HEIGHT, 3), (150, 200, 240), np.uint8)
    picture[60, 100] = 251
    # So that the map is clipped somewhere.
    picture[200] = 255
    assert spot_of(picture) is not None
    picture[50:70, 90:110, 2] = 255
    assert spot_of(picture) is None
    picture[60, 100] = 255
    assert spot_of(picture) is not None


def spot_of(picture):
    env = el.EnvMap(picture)
    return single_spot(sky_image(env.radiance, env.clip_level), env.radiance, env.clip_level)


def test_a_strip_along_the_horizon_is_no_sun():
    radiance, _, _ = sunny(towards(75, 60), ratio=0)
    directions = pixel_directions(HEIGHT, 2 * HEIGHT)
    band = (directions[..., 1] > 0) & (directions[..., 1] < 0.07)
    radiance[band] = 20
    assert sun_in(codes(radiance / 8)).answer == "no"


@pytest.mark.parametrize("height", [64, 100, 512])
def test_other_sizes_have_the_same_answer(height):
    radiance, _, sun = sunny(PLACE, height=height)
    answer = sun_in(expose(radiance, 0.02)[0])
    assert answer.answer == "sun"
    assert angle_deg(answer.direction, sun) < SIGMAS * np.degrees(answer.direction_uncertainty)


def test_a_border_sampled_map_has_the_same_sun(of_wide, wide):
    env = el.EnvMap(wide[0], layout=el.io.Layout(registration="border-sampled"))
    answer = el.find_sun(env)
    assert answer.answer == "sun"
    assert angle_deg(answer.direction, of_wide.direction) < 1
    assert answer.plateau.shape == env.radiance.shape[:2]


def test_a_known_elevation_is_kept_and_the_azimuth_found(wide):
    picture, sun = wide
    elevation = float(np.degrees(np.arcsin(sun[1])))
    answer = el.find_sun(picture, elevation=elevation)
    assert np.degrees(answer.elevation) == pytest.approx(elevation, abs=1e-9)
    assert angle_deg(answer.direction, sun) < 1
