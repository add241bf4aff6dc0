"""Sun of 8-bit pictures of a made clear sky: what users get, against the truth."""

import datetime
from functools import cache

import numpy as np
import pytest

import envlights as el
from envlights.cli.repair import repair_with_sun
from tests.helpers import NORMALS
from tests.sun.suns import photograph

ANGLES = np.radians([140.0, 50.0])


def towards(azimuth, elevation):
    flat = np.cos(elevation)
    return np.array([flat * np.sin(azimuth), np.sin(elevation), -flat * np.cos(azimuth)])


@cache
def picture_of(white_share):
    """The sky, its picture, and the luminance of white."""
    sky = el.synthetic.clear_sky(256, towards(*ANGLES))
    return sky, *photograph(sky.radiance, white_share)


def error(env, truth):
    """Relative error of the probe at the best common scale."""
    seen, wanted = env.probe(NORMALS), truth.probe(NORMALS)
    scale = (seen * wanted).sum() / (seen**2).sum()
    return np.linalg.norm(scale * seen - wanted) / np.linalg.norm(wanted)


@pytest.mark.parametrize("white_share", [0.01, 0.05])
def test_sky_and_sun_light_a_probe_better_than_a_repair_without_one(white_share):
    sky, env, _ = picture_of(white_share)
    truth = el.EnvMap(sky.radiance)
    with_sun = error(el.with_sun(env, "auto").to_map(), truth)
    assert with_sun < 0.5 * error(env.repaired(), truth)
    assert with_sun < 0.1


def test_the_answer_and_its_light_agree_with_the_truth():
    sky, env, white = picture_of(0.01)
    lights, rest = el.with_sun(env)
    assert np.degrees(np.arccos(lights.direction[0] @ towards(*ANGLES))) < 0.5
    ratio = white * lights.luminance[0] / sky.lights.luminance[0]
    assert 0.5 < ratio < 2
    assert "or moon" in rest.notes[-1]


def test_a_ratio_gives_the_irradiance_of_the_sun():
    sky, env, white = picture_of(0.01)
    lights, _ = el.with_sun(env, ratio=1 + 4 * np.sin(ANGLES[1]))
    assert white * lights.luminance[0] == pytest.approx(4.0, rel=0.03)
    assert sky.lights.luminance[0] == pytest.approx(4.0)


@pytest.mark.parametrize("columns", [100, 256])
def test_a_turned_picture_turns_the_result(columns):
    _, env, _ = picture_of(0.01)
    lights, rest = el.with_sun(env)
    rolled = el.EnvMap(np.roll(env.radiance, columns, axis=1), clip_level=env.clip_level)
    turned = el.with_sun(rolled)
    angle = -2 * np.pi * columns / env.width
    cos, sin = np.cos(angle), np.sin(angle)
    turn = np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]])
    apart = np.arccos(np.clip(turned.lights.direction[0] @ turn @ lights.direction[0], -1, 1))
    assert np.degrees(apart) < 0.2
    np.testing.assert_allclose(turned.lights.irradiance, lights.irradiance, rtol=0.02)
    np.testing.assert_allclose(
        np.roll(rest.radiance, columns, axis=1), turned.remainder.radiance, rtol=0.02
    )


def test_a_fit_with_the_sun_has_one_crisp_light():
    _, env, _ = picture_of(0.01)
    rig = el.fit(env, 3, sun="auto", floor=True)
    assert np.degrees(rig.lights.angular_radius[0]) == pytest.approx(0.265)
    assert rig.report.fixed == (0,)
    without = el.fit(env, 3, floor=True)
    assert np.degrees(without.lights.angular_radius[0]) > 2


def test_the_elevation_of_a_time_is_that_of_the_light():
    _, env, _ = picture_of(0.05)
    noon = datetime.datetime(2024, 3, 20, 12, tzinfo=datetime.timezone.utc)
    sun = el.sun.SunAt(noon, latitude=40.0, longitude=0.0)
    lights, _ = el.with_sun(env, sun)
    assert np.degrees(lights.elevation[0]) == pytest.approx(np.degrees(sun.elevation), abs=2)


# Maps that are not clipped


@cache
def whole():
    return el.EnvMap(el.synthetic.clear_sky(256, towards(*ANGLES)).radiance)


def test_the_sun_of_a_map_that_is_not_clipped_is_split_from_it():
    lights, rest = el.with_sun(whole())
    assert np.degrees(lights.angular_radius[0]) == pytest.approx(0.265)
    assert lights.luminance[0] == pytest.approx(4.0, rel=0.05)
    rig = el.Rig([0, 0, 0], lights, error=0.0)
    together = rest.probe(NORMALS) + rig.probe(NORMALS)
    np.testing.assert_allclose(together, whole().probe(NORMALS), rtol=0.02, atol=0.02)
    assert "guess" not in lights.notes[0]


def test_its_direction_gives_the_same():
    lights, _ = el.with_sun(whole(), towards(*ANGLES))
    assert lights == el.with_sun(whole()).lights
    with pytest.raises(el.EnvLightsError, match="sun must be the one that the map holds, sun at"):
        el.with_sun(whole(), [0, 1, 0])


def test_its_repair_changes_nothing():
    repaired = repair_with_sun(whole(), "auto")
    np.testing.assert_array_equal(repaired.radiance, whole().radiance)
    assert "holds its own" in repaired.notes[-2]


def test_a_sun_that_is_not_the_brightest_light_stays():
    sun = el.sun.Sun("sun", direction=[0, 1, 0], irradiance=[1, 1, 1], evidence=("map",))
    lights, rest = el.with_sun(whole(), sun)
    assert len(lights) == 0
    assert rest == whole()
    assert "it is not the brightest light of the map" in rest.notes[-1]
