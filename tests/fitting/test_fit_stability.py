"""The fit to extreme numbers, coincident lights and black maps."""

import numpy as np
import pytest

import envlights as el
from tests.conftest import real_maps
from tests.fitting import worst_cases
from tests.helpers import NORMALS, SOLID_ANGLES

CASES = worst_cases.cases()
EVERY_CASE = pytest.mark.parametrize("case", CASES)


def fit_samples(irradiance, lights=4, **options):
    return el.fit_probe(NORMALS, irradiance, lights, weights=SOLID_ANGLES, **options)


def assert_usable(rig):
    assert np.isfinite(rig.lights.direction).all()
    assert np.isfinite(rig.lights.irradiance).all()
    assert (rig.lights.irradiance >= 0).all()
    assert (rig.ambient >= 0).all()
    assert 0 <= rig.error < 1
    assert rig.report.stop_reason.is_success


@EVERY_CASE
@pytest.mark.parametrize("lights", [1, 4, 8])
@pytest.mark.parametrize("ambient", ["constant", "none"])
def test_lights_are_finite_and_not_negative(case, lights, ambient):
    assert_usable(fit_samples(CASES[case], lights, ambient=ambient))


@EVERY_CASE
@pytest.mark.parametrize("lights", [4, 8])
@pytest.mark.parametrize("scale", [1e-6, 1e9])
def test_scale_changes_the_units_and_nothing_else(case, scale, lights):
    one, scaled = (fit_samples(factor * CASES[case], lights) for factor in (1, scale))
    assert len(scaled.lights) == len(one.lights)
    brightest = max(CASES[case].max(), 1e-300)
    difference = scaled.probe(NORMALS) / scale - one.probe(NORMALS)
    assert np.abs(difference).max() < 1e-12 * brightest
    if case == "opposite lights":
        # One pair may lean towards a light of the other, which gives way: any lean looks alike.
        assert one.report.condition == scaled.report.condition == np.inf
        return
    np.testing.assert_allclose(scaled.lights.direction, one.lights.direction, atol=1e-7)
    difference = scaled.lights.irradiance / scale - one.lights.irradiance
    assert np.abs(difference).max(initial=0) < 1e-7 * brightest


@pytest.mark.parametrize("scale", [1e-160, 1e37])
def test_the_report_is_the_same_at_any_scale(scale, tmp_path):
    """The fourth powers of the irradiance overflow, or its squares underflow, in single precision.

    A rig has at most 3.4e38.
    """
    irradiance = np.random.default_rng(6).random((320, 3))
    one, scaled = fit_samples(irradiance, 2).report, fit_samples(scale * irradiance, 2)
    scaled.save(tmp_path / "rig.json")
    scaled = scaled.report
    assert scaled.channel_errors == pytest.approx(one.channel_errors, rel=1e-9)
    assert scaled.max_error == pytest.approx(one.max_error, rel=1e-9)


@pytest.mark.parametrize("scale", [1e-6, 1e9])
def test_a_map_of_any_scale_has_the_same_lights(scale):
    radiance = el.synthetic.hall(128).radiance
    one, scaled = el.fit(radiance, 4), el.fit(radiance * np.float32(scale), 4)
    # The samples are float32, so they are rounded anew: 6e-8 of each.
    np.testing.assert_allclose(scaled.lights.direction, one.lights.direction, atol=1e-5)
    np.testing.assert_allclose(scaled.lights.irradiance / scale, one.lights.irradiance, rtol=1e-5)


@real_maps("hdr/*.hdr")
def test_a_probe_of_any_scale_has_the_same_eight_lights(path):
    """Rounding must not decide ties of the search."""
    irradiance = el.EnvMap.open(path).probe(NORMALS)
    one = el.fit_probe(NORMALS, irradiance, 8, weights=SOLID_ANGLES)
    for scale in (1e-6, 1e9):
        scaled = el.fit_probe(NORMALS, irradiance * scale, 8, weights=SOLID_ANGLES)
        np.testing.assert_allclose(scaled.lights.direction, one.lights.direction, atol=1e-7)
        np.testing.assert_allclose(scaled.error, one.error, rtol=1e-9)


def test_22_stops_apart_each_light_comes_back():
    found = fit_samples(CASES["22 stops between the lights"]).lights
    np.testing.assert_allclose(found.irradiance[:, 0], 2.0 ** np.array([22, 15, 7, 0]), rtol=1e-6)
    # The weakest is 2e-7 of the brightest, so that much of the digits is lost.
    np.testing.assert_allclose(
        found.direction, [[0, 1, 0], [1, 0, 0], [0, 0, 1], [-1, 0, 0]], atol=1e-6
    )


@pytest.mark.parametrize("lights", [1, 2, 4])
def test_lights_closer_than_the_probe_can_tell_are_one(lights):
    rig = fit_samples(CASES["two lights 0.01 degrees apart"], lights)
    assert len(rig.lights) == 1
    assert rig.error < 1e-8
    np.testing.assert_allclose(rig.lights.irradiance[0, 0], 6.0, rtol=1e-6)


def test_opposite_lights_are_explained():
    """Not uniquely: opposite pairs and the ambient term make up for one another."""
    rig = fit_samples(CASES["opposite lights"])
    assert rig.error < 1e-8
    assert rig.report.condition == np.inf


def test_lights_at_the_poles_come_back():
    rig = fit_samples(CASES["lights at the poles"])
    np.testing.assert_allclose(rig.lights.direction, [[0, 1, 0], [0, -1, 0]], atol=1e-9)
    np.testing.assert_allclose(rig.lights.irradiance[:, 0], [2, 1], rtol=1e-9)


def test_a_dominating_sun_does_not_hide_the_room():
    """It is 1e5 times as strong: the room's lights are found all the same."""
    room, found = (
        fit_samples(worst_cases.hall(), 3),
        fit_samples(CASES["one sun over a dim room"], 4),
    )
    sun = np.array([0.3, 0.8, 0.5]) / np.sqrt(0.98)
    np.testing.assert_allclose(found.lights.direction[0], sun, atol=1e-5)
    for direction in room.lights.direction:
        assert (found.lights.direction[1:] @ direction).max() > np.cos(np.deg2rad(3))


@pytest.mark.parametrize("apart", [0.0, 1e-9, 1e-3])
def test_lights_that_start_together_end_as_one_or_apart(apart):
    towards = np.array([[0.0, 1.0, 0.0], [np.sin(apart), np.cos(apart), 0.0]])
    start = el.Rig(np.zeros(3), el.Lights(towards, np.ones((2, 3))), 0.0)
    for lights in ("one light", "lights at the poles"):
        rig = fit_samples(CASES[lights], None, start=start)
        assert_usable(rig)
        assert len(rig.lights) <= 2
    assert fit_samples(CASES["one light"], None, start=start).error < 1e-8


@pytest.mark.parametrize("lights", [2, 8, 32])
def test_lights_that_are_not_needed_do_not_come(lights):
    rig = fit_samples(CASES["one light"], lights)
    assert len(rig.lights) == 1
    assert rig.error < 1e-8


def test_black_channels_stay_black():
    rig = fit_samples(CASES["red alone"])
    assert rig.lights.irradiance[:, 0].all()
    assert not rig.lights.irradiance[:, 1:].any()
    assert not rig.ambient[1:].any()


def test_nothing_and_evenness_need_no_light():
    black, even = fit_samples(CASES["black"]), fit_samples(CASES["even"])
    assert len(black.lights) == len(even.lights) == 0
    assert black.error == 0
    np.testing.assert_allclose(even.ambient, 1 / np.pi, rtol=1e-12)


@pytest.mark.parametrize("height", [8, 32, 128])
def test_the_error_of_a_small_map_is_that_of_its_probe(height):
    """A bright pixel in a corner: as one point it hid an error of 6 % at 16 columns."""
    radiance = np.full((height, 2 * height, 3), 0.1, np.float32)
    radiance[0, 0] = 1e5
    env = el.EnvMap(radiance)
    rig = el.fit(env, 4)
    normals, weights = el.kernels.icosphere(1280)
    error = el.kernels.relative_rms(rig.probe(normals), env.probe(normals), weights)
    assert error < rig.error + 5e-4
