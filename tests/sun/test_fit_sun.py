"""Fits in which the sun is one light of its own size and irradiance."""

import numpy as np
import pytest

import envlights as el
from envlights import kernels
from envlights.fitting.sun_light import pixels_of, ratios_of
from tests.helpers import NORMALS
from tests.sun.suns import IRRADIANCE, TOWARDS, clipped, sky, sun_of


def truth(env, sun, normals):
    """Irradiance under the sky and the sun."""
    lights, rest = el.with_sun(env, sun)
    return rest.probe(normals) + el.Rig([0, 0, 0], lights, error=0.0).probe(normals)


@pytest.mark.parametrize("options", [{}, {"sizes": False}, {"ambient": "sh2"}, {"ambient": "none"}])
def test_the_sun_is_one_light_and_the_error_is_against_sky_and_sun(options):
    env, plateau = clipped(128)
    rig = el.fit(env, 3, sun=sun_of(plateau), **options)
    assert len(rig.lights) <= 3
    (row,) = rig.report.fixed
    np.testing.assert_allclose(rig.lights.direction[row], TOWARDS)
    np.testing.assert_allclose(rig.lights.irradiance[row], IRRADIANCE)
    radius = 0.0 if "sizes" in options else np.radians(0.265)
    assert rig.lights.angular_radius[row] == pytest.approx(radius)
    normals, weights = kernels.icosphere(5120)
    wanted = truth(env, sun_of(plateau), normals)
    error = kernels.relative_rms(rig.probe(normals), wanted, weights)
    # A fit measures its error on a map of 256 columns, which adds 1e-4.
    assert rig.error == pytest.approx(error, rel=0.02, abs=2e-4)
    assert rig.report.search_errors[len(rig.lights)] > 0


def test_errors_of_channels_are_relative_to_their_own_irradiance():
    env, plateau = clipped(128)
    rig = el.fit(env, 1, sun=sun_of(plateau))
    normals, weights = kernels.icosphere(5120)
    wanted, seen = truth(env, sun_of(plateau), normals), rig.probe(normals)
    for channel, error in enumerate(rig.report.channel_errors):
        one = [np.repeat(each[:, channel : channel + 1], 3, axis=1) for each in (seen, wanted)]
        assert error == pytest.approx(kernels.relative_rms(*one, weights), rel=0.02, abs=1e-4)
    largest = np.abs(seen - wanted).max() / np.sqrt((wanted**2).mean())
    assert rig.report.max_error == pytest.approx(largest, rel=0.1)


def test_energies_of_sky_and_sun_are_those_of_a_map_that_holds_both():
    env, plateau = clipped(256)
    sun = sun_of(plateau)
    energies, _ = el.fit(env, 1, sun=sun).report.gloss_bands
    wanted, _ = el.fit(el.with_sun(env, sun).to_map(), 0).report.gloss_bands
    # In the map the disc is spread over pixels of 1.4 degrees: 2 % less in degree 17, 4 % in 23.
    np.testing.assert_allclose(energies[:16], wanted[:16], rtol=0.02)


def test_a_gloss_error_is_reached_against_sky_and_sun_with_the_fewest_lights():
    env, plateau = clipped(128)
    sun = sun_of(plateau)
    alone = el.fit(env, 1, sun=sun).report.gloss_error()
    rig = el.fit(env, gloss_error=alone / 2, sun=sun)
    assert rig.report.gloss_error() <= alone / 2
    assert el.fit(env, len(rig.lights) - 1, sun=sun).report.gloss_error() > alone / 2
    assert el.fit(env, gloss_error=1.01 * alone, sun=sun).lights.direction.shape == (1, 3)


def test_a_largest_radius_holds_for_the_lights_beside_the_sun():
    env, plateau = clipped(128)
    rig = el.fit(env, 4, sun=sun_of(plateau), max_radius=0.2)
    assert rig.lights.angular_radius.max() <= 0.2


def test_the_report_says_that_the_sun_is_fixed_and_a_guess():
    env, plateau = clipped()
    rig = el.fit(env, 2, sun=sun_of(plateau))
    text = str(rig)
    assert "the sun is fixed in direction, size and irradiance" in text
    assert text.count("the irradiance is a guess") == 1
    assert "relative to sky and sun" in rig.verbose()
    assert rig.to_dict()["lights"]["notes"] == list(rig.lights.notes)


@pytest.mark.parametrize("registration", ["cell-centred", "border-sampled"])
def test_the_ratio_of_rms_irradiance_has_a_closed_form_for_an_even_sky(registration):
    radiance = np.full((64, 128, 3), 2.0, np.float32)
    env = el.EnvMap(radiance, layout=el.io.Layout(registration=registration))
    lamp = el.Lights([[0.6, 0.8, 0]], [[9, 6, 3]])
    ratios = ratios_of(pixels_of(env), lamp)
    # Over all normals: pi L, and pi L + E max(0, n . d), whose mean is 1/4 and mean square 1/6.
    strength = np.array([9.0, 6.0, 3.0])
    alone = (2 * np.pi) ** 2 * np.ones(3)
    both = alone + 2 * (2 * np.pi) * strength / 4 + strength**2 / 6
    np.testing.assert_allclose(ratios.channels, np.sqrt(alone / both), rtol=1e-3)
    assert ratios.probe == pytest.approx(np.sqrt(alone.sum() / both.sum()), rel=1e-3)
    # With planes, from G (1 - g / pi) / 2: the integral over g, and the value at 0.
    angle = (np.arange(100000) + 0.5) * np.pi / 100000
    kernel = 2 / 3 * (np.sin(angle) + (np.pi - angle) * np.cos(angle)) * (1 - angle / np.pi) / 2
    mean = 2 * np.pi * (kernel * np.sin(angle)).sum() * np.pi / 100000
    alone = 4 * np.pi * mean * 4.0 * np.ones(3)
    both = alone + 2 * 2.0 * mean * strength + strength**2 * np.pi / 3
    assert ratios.shadows == pytest.approx(np.sqrt(alone.sum() / both.sum()), rel=1e-3)


def test_errors_of_the_search_and_of_ambient_terms_are_against_sky_and_sun_too():
    env, plateau = clipped(64)
    rig = el.fit(env, 3, sun=sun_of(plateau), sizes=False)
    assert rig.report.search_errors[len(rig.lights)] == pytest.approx(rig.error)
    assert (
        list(rig.report.search_errors.values()) == sorted(rig.report.search_errors.values())[::-1]
    )
    auto = el.fit(env, error=0.05, ambient="auto", sun=sun_of(plateau))
    lights, error = auto.report.ambients["constant"]
    assert lights == len(auto.lights)
    assert error == pytest.approx(auto.error)


def test_channels_that_neither_sky_nor_sun_has_hold_no_error():
    env = el.EnvMap(np.full((32, 64, 3), [1.0, 0.5, 0.0], np.float32))
    channels = ratios_of(pixels_of(env), el.Lights([[0, 1, 0]], [[3, 0, 0]])).channels
    assert channels[0] < 1
    assert channels[1:] == (1.0, 0.0)


def test_the_error_with_shadows_agrees_with_a_fit_to_the_drawn_sun():
    env, plateau = clipped(512)
    sun = sun_of(plateau)
    rig = el.fit(env, 1, sun=sun, ambient="constant")
    drawn = el.fit(el.with_sun(env, sun).to_map(), 1, fixed=[TOWARDS], ambient="constant")
    assert rig.report.shadow_error == pytest.approx(drawn.report.shadow_error, rel=0.1)
    # That fit may change the irradiance of the sun, so its error is lower.
    assert drawn.error <= rig.error < 1.5 * drawn.error


@pytest.mark.parametrize("goal", [{"error": 0.004}, {"shadow_error": 0.03}])
def test_a_requested_error_is_one_against_sky_and_sun(goal):
    env, plateau = clipped(128)
    rig = el.fit(env, sun=sun_of(plateau), **goal)
    assert rig.report.stop_reason.is_success
    reached = rig.error if "error" in goal else rig.report.shadow_error
    (wanted,) = goal.values()
    assert reached <= wanted
    fewest = el.fit(env, len(rig.lights) - 1, sun=sun_of(plateau)) if len(rig.lights) > 1 else None
    if fewest:
        assert (fewest.error if "error" in goal else fewest.report.shadow_error) > wanted


def test_over_a_floor_the_sky_above_counts():
    env, plateau = clipped(128)
    # A bright ground and a weak sun, so that the ground would change the ratio of sky to sun.
    radiance = env.radiance.copy()
    radiance[64:] = 0.95
    env, weak = el.EnvMap(radiance, clip_level=1.0), IRRADIANCE / 20
    rig = el.fit(env, 2, sun=sun_of(plateau, irradiance=weak), floor=True)
    above = el.with_sun(env, sun_of(plateau)).remainder.radiance.copy()
    above[64:] = 0
    normals, weights = kernels.icosphere(5120)
    sun = el.Rig([0, 0, 0], el.Lights([TOWARDS], [weak], [np.radians(0.265)]), error=0.0)
    wanted = el.EnvMap(above).probe(normals) + sun.probe(normals)
    error = kernels.relative_rms(rig.probe(normals), wanted, weights)
    assert rig.error == pytest.approx(error, rel=0.02, abs=2e-4)


def test_fixed_lights_come_before_the_sun_in_the_report():
    env, plateau = clipped(128)
    lamp = [0.0, 0.6, -0.8]
    rig = el.fit(env, 3, sun=sun_of(plateau), fixed=[lamp])
    directions = rig.lights.direction[list(rig.report.fixed)]
    np.testing.assert_allclose(directions, [lamp, TOWARDS], atol=1e-12)
    assert len(rig.report.direction_tolerances) == len(rig.lights)
    assert rig.report.direction_tolerances[rig.report.fixed[1]] == 0


def test_four_lights_are_three_and_the_sun():
    env = el.EnvMap(el.synthetic.hall(64).radiance)
    sun = sun_of()
    assert len(el.fit(env, sun=sun).lights) == 4
    # More lights would be needed for this error; MuJoCo shows 7.
    assert len(el.fit(env, error=1e-6, sun=sun, target="mujoco").lights) == 7
    assert len(el.fit(env, 1, sun=sun).lights) == 1
    with pytest.raises(el.EnvLightsError, match="lights must be at least 1 with a sun"):
        el.fit(env, 0, sun=sun)


@pytest.mark.parametrize("answer", ["perhaps", "no"])
def test_without_a_sun_the_map_is_fitted_as_it_is(answer):
    env, plateau = clipped()
    rig = el.fit(env, 2, sun=sun_of(plateau, answer))
    plain = el.fit(env, 2)
    assert rig.lights == plain.lights
    assert rig.error == plain.error
    assert any("no sun was added" in note for note in rig.notes)


def test_a_turned_map_turns_the_rig():
    env, plateau = clipped(128)
    turn = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    sun = sun_of(np.roll(plateau, -64, axis=1), direction=turn @ TOWARDS)
    rig, turned = el.fit(env, 2, sun=sun_of(plateau)), el.fit(env.rotated(turn), 2, sun=sun)
    np.testing.assert_allclose(
        turned.probe(NORMALS @ turn.T), rig.probe(NORMALS), rtol=2e-2, atol=2e-2
    )
    assert turned.error == pytest.approx(rig.error, rel=0.05)


def test_an_unknown_sun_is_refused():
    with pytest.raises(el.EnvLightsError, match=r"sun must be 'auto', .*; got 'maybe'"):
        el.fit(sky(), sun="maybe")
