"""Uncertainty of lights: tolerances under a map, standard errors of measured values."""

import numpy as np
import pytest

import envlights as el
from tests.fitting import worst_cases
from tests.helpers import NORMALS, SOLID_ANGLES


def tilt(direction, angle, turn):
    """`direction` turned by `angle` towards one of its sides."""
    direction = np.asarray(direction)
    side = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    side /= np.linalg.norm(side)
    other = np.cross(direction, side)
    towards = np.cos(turn) * side + np.sin(turn) * other
    return np.cos(angle) * direction + np.sin(angle) * towards


def growths(radiance, rig, light, **options):
    """Growth of the error when a light is moved by its tolerance, to all sides."""
    others = el.Lights(*(np.delete(each, light, 0) for each in arrays(rig.lights)))
    angle = rig.report.direction_tolerances[light]
    for turn in np.arange(12) * np.pi / 6:
        place = tilt(rig.lights.direction[light], angle, turn)
        beside = el.fit(radiance, len(rig.lights), fixed=[place], start=others, **options)
        if rig.lights.angular_radius.any():
            yield beside.report.shadow_error / rig.report.shadow_error - 1
        else:
            yield beside.error / rig.error - 1


def arrays(lights):
    return lights.direction, lights.irradiance


@pytest.mark.parametrize("seed", el.synthetic.EVALUATION[:3])
@pytest.mark.parametrize("options", [{"sizes": False}, {"sizes": False, "ambient": "sh2"}])
def test_moved_by_its_tolerance_a_light_costs_a_tenth_of_the_error(seed, options):
    """On maps that three lights leave far above the error of the rendering."""
    radiance = el.synthetic.hard(seed, 128).radiance
    rig = el.fit(radiance, 3, **options)
    assert len(rig.report.direction_tolerances) == 3
    for light, tolerance in enumerate(rig.report.direction_tolerances):
        if tolerance < np.deg2rad(10):  # to second order only
            # It is that of the side on which the error grows least.
            least = min(growths(radiance, rig, light, **options))
            assert 0.05 < least < 0.15, f"light {light}: {least}"


@pytest.mark.parametrize("seed", el.synthetic.EVALUATION[:2])
def test_of_discs_it_is_the_error_that_was_fitted(seed):
    radiance = el.synthetic.hard(seed, 128).radiance
    rig = el.fit(radiance, 3, objective="shadows")
    for light, tolerance in enumerate(rig.report.direction_tolerances):
        if tolerance < np.deg2rad(5):
            least = min(growths(radiance, rig, light, objective="shadows"))
            assert 0.05 < least < 0.15, f"light {light}: {least}"


def test_over_a_floor_too():
    radiance = el.synthetic.hall(128).radiance
    rig = el.fit(radiance, 3, floor=True, sizes=False)
    tolerances = np.array(rig.report.direction_tolerances)
    assert (rig.lights.direction[:, 1] > np.sin(tolerances)).all()
    for light in range(3):
        assert 0.05 < min(growths(radiance, rig, light, floor=True, sizes=False)) < 0.15


def test_a_fixed_light_has_no_tolerance_and_each_figure_its_light():
    radiance = el.synthetic.hall(128).radiance
    free = el.fit(radiance, 3)
    rig = el.fit(radiance, 3, fixed=free.lights.direction[1:2])
    (row,) = rig.report.fixed
    assert row == 1
    assert rig.report.direction_tolerances[1] == 0
    assert min(rig.report.direction_tolerances[::2]) > 0
    # With one light fixed, the others may stray less.
    assert rig.report.direction_tolerances[0] <= free.report.direction_tolerances[0] * (1 + 1e-6)


def test_a_map_has_no_standard_errors_and_a_probe_no_tolerances():
    env = el.EnvMap(el.synthetic.hall(128).radiance)
    under_map, measured = el.fit(env, 2).report, el.fit_probe(NORMALS, env.probe(NORMALS), 2).report
    assert under_map.direction_errors == under_map.irradiance_errors == ()
    assert under_map.condition == 1
    assert measured.direction_tolerances == ()
    assert len(measured.direction_errors) == len(measured.irradiance_errors) == 2
    assert measured.condition > 1
    assert "direction tolerance (10 % more error): " in under_map.verbose()
    assert "standard error" not in str(under_map)
    assert "condition" not in str(under_map)
    assert "standard error of the directions: " in measured.verbose()
    assert "tolerance" not in measured.verbose()


def test_lights_that_share_a_lamp_may_stand_far_off():
    """Two lights in one broad window hold each other less than one alone is held."""
    window = [el.synthetic.Disc((0.6, 0.64, 0.48), 25, (9, 8, 7))]
    radiance = el.synthetic.scene(128, background=[0.2] * 3, shapes=window).radiance
    one, two = (el.fit(radiance, lights, sizes=False) for lights in (1, 2))
    assert len(two.lights) == 2
    relative = [np.array(rig.report.direction_tolerances) / rig.error for rig in (one, two)]
    assert relative[1].min() > 2 * relative[0].max()


# Standard errors


GREY = el.Rig(
    [0.2] * 3,
    el.Lights([[0.6, 0.64, 0.48], [-0.8, 0.36, 0.48]], [[3, 3, 3], [1.5, 1.5, 1.5]]),
    error=0.0,
)
COLOUR = el.Rig(
    [0.3, 0.2, 0.1],
    el.Lights([[0.6, 0.64, 0.48], [-0.8, 0.36, 0.48]], [[5, 4, 3], [1, 2, 3]]),
    error=0.0,
)


@pytest.mark.parametrize("rig", [GREY, COLOUR], ids=["grey", "colour"])
@pytest.mark.parametrize("shared", [1.0, 0.7])
def test_standard_errors_are_right_for_noise_that_the_channels_share(rig, shared):
    """All or most of the noise is shared, like that of one light meter behind three filters."""
    exact = rig.probe(NORMALS)
    rng = np.random.default_rng(12)
    found = []
    for _ in range(400):
        common, own = rng.normal(size=(320, 1)), rng.normal(size=(320, 3))
        noise = 0.01 * (np.sqrt(shared) * common + np.sqrt(1 - shared) * own)
        found.append(el.fit_probe(NORMALS, exact + noise, start=rig))
    for figure, truth in (("direction", rig.lights.direction), ("irradiance", None)):
        fitted = np.array([getattr(each.lights, figure) for each in found])
        if truth is not None:
            spread = np.sqrt(((fitted - truth) ** 2).sum(axis=2).mean(axis=0))
        else:
            spread = np.sqrt(((fitted - rig.lights.irradiance) ** 2).mean(axis=0))
        stated = np.mean([getattr(each.report, f"{figure}_errors") for each in found], axis=0)
        np.testing.assert_allclose(stated, spread, rtol=0.2)


@pytest.mark.parametrize("noise", [1e-6, 1e-3])
def test_two_lights_a_hundredth_of_a_degree_apart_are_not_claimed_to_be_known(noise):
    exact = worst_cases.cases()["two lights 0.01 degrees apart"]
    noisy = exact * (1 + noise * np.random.default_rng(3).normal(size=exact.shape))
    apart = [tilt([0, 1, 0], 6e-4, turn) for turn in (0, np.pi)]
    rig = el.fit_probe(NORMALS, noisy, start=el.Lights(apart, np.ones((2, 3))))
    assert len(rig.lights) == 2
    assert rig.report.condition == np.inf
    assert np.isinf(rig.report.direction_errors).all()
    is_lit = rig.lights.irradiance > 0
    assert np.isinf(np.array(rig.report.irradiance_errors)[is_lit]).all()


def test_where_the_condition_is_infinite_every_standard_error_is():
    """Opposite pairs of lights and the ambient term make up for one another."""
    report = el.fit_probe(
        NORMALS, worst_cases.cases()["opposite lights"], 4, weights=SOLID_ANGLES
    ).report
    assert report.condition == np.inf
    assert np.isinf(report.direction_errors).all()
    assert np.isinf(report.irradiance_errors).all()


def test_infinite_standard_errors_are_saved(tmp_path):
    rig = el.fit_probe(NORMALS, worst_cases.cases()["opposite lights"], 4, weights=SOLID_ANGLES)
    rig.save(tmp_path / "rig.json")
    assert el.Rig.load(tmp_path / "rig.json").report == rig.report
