"""How far the lights are determined: tolerances under a map, standard errors of measured values."""

import numpy as np
import pytest

import envlights as el
from envlights import kernels
from tests.fitting import worst_cases
from tests.helpers import NORMALS, SOLID_ANGLES


def moved(direction, angle, turn):
    """`direction` turned by `angle` towards one of its sides."""
    side = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    side /= np.linalg.norm(side)
    other = np.cross(direction, side)
    towards = np.cos(turn) * side + np.sin(turn) * other
    return np.cos(angle) * direction + np.sin(angle) * towards


def growths(radiance, rig, light, **options):
    """How much the error grows when a light is moved by its tolerance, to all sides."""
    others = el.Lights(*(np.delete(each, light, 0) for each in arrays(rig.lights)))
    angle = rig.report.direction_tolerances[light]
    for turn in np.arange(12) * np.pi / 6:
        place = moved(rig.lights.direction[light], angle, turn)
        beside = el.fit(radiance, len(rig.lights), fixed=[place], start=others, **options)
        yield beside.error / rig.error - 1


def arrays(lights):
    return lights.direction, lights.irradiance


@pytest.mark.parametrize("seed", el.synthetic.JUDGING[:3])
@pytest.mark.parametrize("options", [{}, {"ambient": "sh2"}])
def test_moved_by_its_tolerance_a_light_costs_a_tenth_of_the_error(seed, options):
    radiance = el.synthetic.plain(seed, 128).radiance
    rig = el.fit(radiance, 3, **options)
    assert len(rig.report.direction_tolerances) == 3
    for light, tolerance in enumerate(rig.report.direction_tolerances):
        if tolerance < np.deg2rad(15):  # to second order only
            # It is that of the side on which the error grows least.
            least = min(growths(radiance, rig, light, **options))
            assert 0.05 < least < 0.15, f"light {light}: {least}"


def test_over_a_floor_too():
    radiance = el.synthetic.hall(128).radiance
    rig = el.fit(radiance, 3, floor=True)
    for light in range(3):
        above = rig.lights.direction[light, 1] > np.sin(rig.report.direction_tolerances[light])
        assert above
        assert 0.05 < min(growths(radiance, rig, light, floor=True)) < 0.15


def test_upward_surfaces_too():
    radiance = el.synthetic.hall(128).radiance
    rig = el.fit(radiance, 3, normals="upper")
    least = [min(growths(radiance, rig, light, normals="upper")) for light in range(3)]
    assert all(0.05 < growth < 0.15 for growth in least), least


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
    assert "before the error grows by a tenth: " in str(under_map)
    assert "standard error" not in str(under_map)
    assert "condition" not in str(under_map)
    assert "standard error of the directions: " in str(measured)
    assert "a tenth" not in str(measured)


def test_a_light_that_nothing_holds_may_stand_far_off():
    """A light of a hundredth of the flux beside one that shines through the same window."""
    lamps = [el.synthetic.Disc((0.6, 0.64, 0.48), 3, (90, 80, 70))]
    radiance = el.synthetic.scene(128, background=[0.2] * 3, shapes=lamps).radiance
    sharp = el.fit(radiance, 1).report.direction_tolerances[0]
    split = el.Lights([moved([0.6, 0.64, 0.48], 1e-4, 0), [0.6, 0.64, 0.48]], np.ones((2, 3)))
    loose = el.fit(radiance, start=split)
    if len(loose.lights) == 2:
        assert max(loose.report.direction_tolerances) > 2 * sharp


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
    """As of one light meter behind three filters: all of the noise is shared, or most of it."""
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


def test_two_lights_too_close_to_be_told_apart_have_no_finite_standard_error():
    """A hundredth of a degree apart: the condition is beyond what rounding leaves of the digits."""
    exact = worst_cases.cases()["two lights 0.01 degrees apart"]
    towards = np.array([[0, 1, 0], [np.deg2rad(0.01), 1, 0]])
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    rng = np.random.default_rng(3)
    noisy = exact * (1 + 1e-6 * rng.normal(size=exact.shape))
    rig = el.fit_probe(NORMALS, noisy, start=el.Lights(towards, np.ones((2, 3))))
    for report in (rig.report, el.fit_probe(NORMALS, noisy, fixed=towards).report):
        if np.isinf(report.condition):
            moving = [row for row in range(len(report.direction_errors)) if row not in report.fixed]
            assert np.isinf(np.array(report.direction_errors)[moving]).all()
            assert np.isinf(report.irradiance_errors).any()


def test_where_the_condition_is_infinite_every_standard_error_is():
    """Opposite pairs of lights and the ambient term make up for one another."""
    report = el.fit_probe(
        NORMALS, worst_cases.cases()["opposite lights"], 4, weights=SOLID_ANGLES
    ).report
    assert report.condition == np.inf
    assert np.isinf(report.direction_errors).all()
    assert np.isinf(report.irradiance_errors).all()


def test_infinite_standard_errors_are_saved(tmp_path):
    probe = kernels.rig_irradiance(NORMALS, [0.1] * 3, [[0, 1, 0], [0, 1, 0]], np.ones((2, 3)))
    rig = el.fit_probe(NORMALS, probe, fixed=[[0, 1, 0], [0, 1, 0]])
    assert rig.report.condition == np.inf
    rig.save(tmp_path / "rig.json")
    assert el.Rig.load(tmp_path / "rig.json").report == rig.report
