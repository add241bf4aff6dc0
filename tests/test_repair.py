"""Repair of clipped light, with the ground as a light meter."""

import inspect

import numpy as np
import pytest

import envlights as el
from envlights import kernels
from envlights.environment import repair
from envlights.kernels.image import LUMINANCE
from tests.helpers import angle_deg, flux, printed_by_threads

UP = [[0, 1, 0]]
SUN = np.array([0.6, 0.64, 0.48])


def picture(height=64, ground=0.1, sky=0.1, sun_deg=4.0, clip_level=1.0, colour=(1, 1, 1), sun=SUN):
    """A sun at white in an even sky over even ground."""
    directions = kernels.pixel_directions(height, 2 * height)
    radiance = np.where(directions[..., 1:2] > 0, sky, ground) * np.ones(3)
    radiance[angle_deg(directions, sun) < sun_deg] = clip_level * np.array(colour)
    return radiance


def upward(env):
    return float(env.probe(UP)[0] @ LUMINANCE)


# The estimate


def test_the_estimate_is_the_formula():
    ground, sky = 0.05, 0.1
    env = el.EnvMap(picture(ground=ground, sky=sky), clip_level=1.0)
    added = (flux(env.repaired().radiance) - flux(env.radiance)) @ LUMINANCE
    assert added == pytest.approx(3 * (np.pi * ground / 0.2 - upward(env)), rel=1e-5)


def test_no_more_is_added_than_three_times_the_rest():
    env = el.EnvMap(picture(ground=0.9, sky=0.01, sun_deg=15), clip_level=1.0)
    is_whole = env.radiance[..., :1] < 0.985
    rest = flux(np.where(is_whole, env.radiance, 0)) @ LUMINANCE
    added = (flux(env.repaired().radiance) - flux(env.radiance)) @ LUMINANCE
    assert added == pytest.approx(3 * rest, rel=1e-5)


def test_nor_than_four_hundred_times_white():
    env = el.EnvMap(picture(height=256, ground=0.3, sky=0.2, sun_deg=0.5), clip_level=1.0)
    solid_angles = kernels.pixel_solid_angles(256, 512)
    clipped = solid_angles[env.radiance[..., 0] == 1].sum()
    added = (flux(env.repaired().radiance) - flux(env.radiance)) @ LUMINANCE
    assert added == pytest.approx(400 * clipped, rel=1e-4)


@pytest.mark.parametrize(
    ("radiance", "reason"),
    [
        (picture(ground=0.01, sky=0.3), "explains the brightness"),
        (picture(ground=0.3, sky=0.3), "an albedo of 0.99, like a white floor"),
        (picture(ground=1.0, sky=0.3), "the ground itself is clipped"),
        (picture(sun_deg=0.0), "no pixel is clipped"),
    ],
)
def test_where_the_ground_tells_nothing_nothing_is_added_and_the_note_says_why(radiance, reason):
    env = el.EnvMap(radiance, clip_level=1.0)
    repaired = env.repaired()
    np.testing.assert_array_equal(repaired.radiance, env.radiance)
    assert reason in repaired.notes[-1]
    assert "nothing" in repaired.notes[-1]


def test_the_note_holds_the_factor():
    env = el.EnvMap(picture(ground=0.05), clip_level=1.0)
    repaired = env.repaired()
    factor = float(np.divide(*(flux(each.radiance) @ LUMINANCE for each in (repaired, env))))
    assert f"a factor of {factor:.3g} " in repaired.notes[-1]
    assert "two of three" in repaired.notes[-1]


# Numbers of the user


@pytest.mark.parametrize("registration", ["cell-centred", "border-sampled"])
@pytest.mark.parametrize("height", [64, 300])
def test_an_upward_surface_gets_the_irradiance_that_was_asked_for(registration, height):
    env = el.EnvMap(picture(height), layout=el.io.Layout(registration=registration), clip_level=1.0)
    assert upward(env.repaired(irradiance=7.0)) == pytest.approx(7.0, rel=1e-5)


def test_a_ratio_is_that_of_two_readings_of_a_lux_meter():
    env = el.EnvMap(picture(300), clip_level=1.0)
    shaded = np.where(env.radiance < 0.985, env.radiance, np.float32(0))
    repaired = env.repaired(ratio=6.0)
    assert upward(repaired) / upward(el.EnvMap(shaded)) == pytest.approx(6.0, rel=1e-5)


def test_the_scale_of_a_map_does_not_matter():
    env = el.EnvMap(picture(ground=0.2), clip_level=1.0)
    scaled = el.EnvMap(64 * env.radiance, clip_level=64.0)
    np.testing.assert_allclose(scaled.repaired().radiance, 64 * env.repaired().radiance, rtol=1e-5)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"irradiance": 1.0, "ratio": 2.0}, "irradiance or ratio, not both"),
        ({"irradiance": 0.1}, "irradiance must be at least that of the map, 0.32"),
        ({"ratio": 0.5}, "ratio must be at least that of the map, 1.0"),
        ({"irradiance": -1.0}, "irradiance must be a finite number, 0 or more; got -1.0"),
        ({"ratio": "two"}, "ratio must be a finite number, 0 or more; got 'two'"),
    ],
)
def test_impossible_numbers_are_refused(options, message):
    env = el.EnvMap(picture(), clip_level=1.0)
    with pytest.raises(el.EnvLightsError, match=message):
        env.repaired(**options)


def test_a_ratio_to_a_black_sky_is_refused():
    env = el.EnvMap(picture(ground=0, sky=0), clip_level=1.0)
    with pytest.raises(el.EnvLightsError, match="black without the clipped light"):
        env.repaired(ratio=5.0)


def test_what_lies_below_the_horizon_cannot_light_an_upward_surface():
    env = el.EnvMap(picture(sun=-SUN), clip_level=1.0)
    with pytest.raises(el.EnvLightsError, match="below the horizon"):
        env.repaired(irradiance=9.0)


# The map


def test_only_clipped_pixels_change_and_they_keep_their_colour():
    env = el.EnvMap(picture(ground=0.2, colour=(1.0, 0.7, 0.3)), clip_level=1.0)
    repaired = env.repaired()
    is_sun = env.radiance[..., 0] == 1
    np.testing.assert_array_equal(repaired.radiance[~is_sun], env.radiance[~is_sun])
    ratios = repaired.radiance[is_sun] / env.radiance[is_sun]
    assert ratios.min() > 1
    np.testing.assert_allclose(ratios, ratios[:, :1] * np.ones(3), rtol=1e-6)
    assert repaired.clip_level is None
    assert env.notes == repaired.notes[:-1]


def test_an_estimate_that_adds_nothing_leaves_what_detection_finds():
    env = el.EnvMap(picture(256, ground=1e-4), clip_level=1.0)
    repaired = env.repaired()
    assert repaired.notes[-1].startswith("nothing was added")
    assert repaired == env
    assert repaired.clip_level == 1.0
    assert len(el.detect(repaired)) == len(el.detect(env)) > 0
    assert env.repaired(ratio=1.1).clip_level is None


def test_detection_and_fit_find_the_sun_with_its_flux():
    env = el.EnvMap(picture(256, ground=0.1), clip_level=1.0)
    repaired = env.repaired(irradiance=3.0)
    missing = (3.0 - upward(env)) / SUN[1]
    for lights in (el.detect(repaired), el.fit(repaired, lights=1).lights):
        assert angle_deg(lights.direction[0], SUN) < 0.5
        assert lights.irradiance[0] @ LUMINANCE == pytest.approx(missing, rel=0.05)


def test_a_map_that_ends_at_its_own_maximum_is_repaired_too():
    radiance = picture(ground=20.0, sky=10.0, clip_level=4096.0)
    env = el.EnvMap(radiance)
    assert upward(env.repaired(irradiance=500.0)) == pytest.approx(500.0, rel=1e-5)


def test_the_seam_and_the_number_of_threads_change_nothing():
    code = """if True:
        import hashlib, numpy as np, envlights as el
        from tests.test_repair import picture
        radiance = el.EnvMap(picture(130, ground=0.2), clip_level=1.0).repaired().radiance
        print(hashlib.sha256(radiance.tobytes()).hexdigest())
    """
    assert len(printed_by_threads(code)) == 1
    env = el.EnvMap(picture(64, ground=0.2), clip_level=1.0)
    turned = el.EnvMap(np.roll(env.radiance, 37, axis=1), clip_level=1.0)
    rolled = np.roll(env.repaired().radiance, 37, axis=1)
    np.testing.assert_allclose(turned.repaired().radiance, rolled, rtol=1e-5)


def test_the_plateau_is_that_of_detection():
    options = inspect.signature(el.detect).parameters
    columns = options["working_width"].default // 2  # clipped maps are searched in half of them
    assert columns == repair.PLATEAU_COLUMNS
    assert np.deg2rad(options["gap_deg"].default) == pytest.approx(repair.PLATEAU_GAP)


@pytest.mark.parametrize("name", ["sky.exr", "sky.hdr"])
def test_a_file_of_a_repaired_map_says_that_its_light_is_an_estimate(tmp_path, name):
    sky = np.full((64, 128, 3), 0.1)
    sky[12:14, 60:62] = 1.0
    env = el.EnvMap(sky, clip_level=1.0, notes="limited to friends").repaired(irradiance=2.0)
    env.save(tmp_path / name)
    note = env.notes[-1]
    assert el.EnvMap.open(tmp_path / name).notes == (note,)
    assert note in el.fit(tmp_path / name, 1).notes
    assert note.code == "repaired"
