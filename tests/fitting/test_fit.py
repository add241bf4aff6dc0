"""The fit against known rigs, scipy, and itself under other scales."""

import re
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import envlights as el
from envlights import _native, kernels
from tests.conftest import real_maps
from tests.fitting.worst_cases import known_rig
from tests.helpers import EQUIRECTANGULAR, NORMALS, SOLID_ANGLES
from tests.reference.madsen import Problem, best_of_random_starts


@pytest.mark.parametrize("scale", [1.0, 1e-9, 1e9])
def test_known_lights_come_back(scale):
    rig = known_rig()
    found = el.fit_probe(NORMALS, scale * rig.probe(NORMALS), lights=3)
    np.testing.assert_allclose(found.lights.direction, rig.lights.direction, atol=1e-6)
    np.testing.assert_allclose(found.lights.irradiance / scale, rig.lights.irradiance, rtol=1e-6)
    np.testing.assert_allclose(found.ambient / scale, rig.ambient, rtol=1e-6)
    assert found.error < 1e-8
    assert found.report.stop_reason is el.rigs.StopReason.EXACT


def test_asking_for_more_lights_than_there_are_gives_no_more():
    rig = known_rig()
    found = el.fit_probe(NORMALS, rig.probe(NORMALS), lights=8)
    assert len(found.lights) == 3


def test_weights_decide_between_contradicting_values():
    normals = np.concatenate([NORMALS, NORMALS])
    one, two = known_rig().probe(NORMALS), 2 * known_rig().probe(NORMALS)
    weights = np.repeat([1.0, 0.0], 320)
    found = el.fit_probe(normals, np.concatenate([one, two]), lights=3, weights=weights)
    np.testing.assert_allclose(found.probe(NORMALS), one, rtol=1e-6)


def test_hall_has_its_lights_at_the_windows_and_the_fourth_towards_the_wall():
    """The claim of Madsen et al. (2003), section 3.2."""
    hall = el.synthetic.hall()
    rig = el.fit(hall.radiance, lights=4)
    assert rig.error < 0.01
    nearest = np.rad2deg(np.arccos((hall.lights.direction @ rig.lights.direction.T).max(axis=1)))
    assert nearest.max() < 3
    assert rig.lights.direction[3, 2] < -0.9
    assert rig.report.stop_reason.is_success


def test_error_is_that_of_the_rig_against_the_exact_probe_at_other_normals():
    env = el.EnvMap(el.synthetic.hall(256).radiance)
    rig = el.fit(env, lights=2)
    normals, solid_angles = kernels.icosphere(20480)
    error = kernels.relative_rms(rig.probe(normals), env.probe(normals), solid_angles)
    assert rig.error == pytest.approx(error, rel=0.02)
    assert rig.report.sized_error == rig.error
    assert len(rig.report.search_errors) == 3


def test_energy_of_the_field_is_that_of_the_probe_at_many_normals():
    radiance = el.synthetic.hall(128).radiance
    normals, solid_angles = kernels.icosphere(20480)
    received, _ = kernels.working_irradiance(radiance, normals)
    energy = _native.map_energy(radiance, False, 256, 5e-3)
    assert energy == pytest.approx(np.sum(solid_angles[:, None] * received**2), rel=1e-4)


def test_no_light_is_an_answer():
    radiance = el.synthetic.hall(64).radiance
    rig = el.fit(radiance, lights=0)
    assert len(rig.lights) == 0
    assert (rig.ambient > 0).all()
    assert rig.report.search_errors == {0: rig.error}
    assert rig.report.sized_error is None


@pytest.mark.parametrize("lights", [0, 4])
def test_a_black_map_needs_no_light(lights):
    rig = el.fit(np.zeros((16, 32, 3)), lights=lights)
    assert len(rig.lights) == 0
    assert rig.error == 0
    assert not rig.ambient.any()
    assert rig.report.stop_reason is el.rigs.StopReason.NOTHING_TO_FIT


def test_a_constant_map_is_ambient_alone():
    rig = el.fit(np.full((64, 128, 3), (1.0, 2.0, 3.0)), lights=0)
    np.testing.assert_allclose(rig.ambient, [1, 2, 3], rtol=1e-8)
    # The probes that measure the error are rendered from 64 rows of cells.
    assert rig.error < 1.3e-4


def numbers_of(rig):
    """All numbers of a fit."""
    return rig.to_dict()


def maps_of_several_sizes():
    """Maps with different pixels, for which the kernels make different tables."""
    hall = el.synthetic.hall
    border_sampled = el.EnvMap(
        hall(96).radiance, layout=el.io.Layout(registration="border-sampled")
    )
    return [el.EnvMap(hall(96).radiance), border_sampled, hall(64), hall(97), hall(192)]


def test_maps_of_other_sizes_in_between_change_nothing():
    maps = maps_of_several_sizes()
    alone = [[numbers_of(el.fit(env, lights=2)) for _ in range(2)][1] for env in maps]
    for _ in range(2):
        assert [numbers_of(el.fit(env, lights=2)) for env in maps] == alone


def test_maps_of_several_sizes_at_once_are_fitted_as_one_by_one():
    maps = maps_of_several_sizes()
    alone = [numbers_of(el.fit(env, lights=2)) for env in maps]
    with ThreadPoolExecutor(len(maps)) as threads:
        together = threads.map(lambda env: numbers_of(el.fit(env, lights=2)), 4 * maps)
    assert list(together) == 4 * alone


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_scaling_the_map_scales_the_lights_and_nothing_else(scale):
    radiance = el.synthetic.hall(128).radiance
    one, scaled = el.fit(radiance, lights=3), el.fit(radiance * np.float32(scale), lights=3)
    np.testing.assert_allclose(scaled.lights.direction, one.lights.direction, atol=1e-5)
    np.testing.assert_allclose(scaled.lights.irradiance / scale, one.lights.irradiance, rtol=1e-4)
    assert scaled.error == pytest.approx(one.error, rel=1e-4)


@pytest.mark.parametrize("lights", [1, 3])
def test_the_twin_has_the_jacobian_that_it_claims(lights):
    rng = np.random.default_rng(5)
    problem = Problem(NORMALS, SOLID_ANGLES, rng.uniform(size=(320, 3)), lights)
    x = problem.random_start(rng)
    step = 1e-7
    for i, slope in enumerate(problem.jacobian(x).T):
        ahead, behind = x.copy(), x.copy()
        ahead[i] += step
        behind[i] -= step
        measured = (problem.residual(ahead) - problem.residual(behind)) / (2 * step)
        np.testing.assert_allclose(slope, measured, atol=1e-6)


def fitted_error(irradiance, lights):
    return el.fit_probe(NORMALS, irradiance, lights=lights, weights=SOLID_ANGLES).error


@pytest.mark.parametrize("lights", [1, 2, 4])
def test_the_fit_is_as_good_as_many_random_starts_of_scipy_on_the_hall(lights):
    irradiance = el.EnvMap(el.synthetic.hall(128).radiance).probe(NORMALS)
    best = best_of_random_starts(NORMALS, SOLID_ANGLES, irradiance, lights, starts=30, seed=1)
    assert fitted_error(irradiance, lights) <= 1.02 * best


@pytest.mark.slow
@real_maps("hdr/*.hdr")
def test_the_fit_is_as_good_as_many_random_starts_of_scipy_on_real_maps(path):
    env = el.EnvMap.open(path)
    irradiance = env.probe(NORMALS)
    irradiance /= irradiance.max()
    for lights in (1, 2, 4, 8):
        best = best_of_random_starts(NORMALS, SOLID_ANGLES, irradiance, lights, starts=30, seed=1)
        ours = fitted_error(irradiance, lights)
        assert ours <= 1.02 * best, f"{lights} lights: {ours:.6f}, scipy {best:.6f}"


@real_maps(*EQUIRECTANGULAR)
def test_real_maps_give_lights_that_a_renderer_can_use(path):
    rig = el.fit(el.EnvMap.open(path), lights=4)
    assert (rig.lights.irradiance >= 0).all()
    assert (rig.ambient >= 0).all()
    assert rig.error < 0.06
    assert rig.error < rig.report.search_errors[0]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: el.fit(np.ones((4, 8, 3)), lights=-1), r"lights must be .* 0 or more; got -1"),
        (lambda: el.fit(np.ones((4, 8, 3)), lights=3.5), r"lights must be a whole .* got 3.5"),
        (lambda: el.fit(np.ones((4, 8, 3)), lights=True), r"lights must be a whole .* got True"),
        (
            lambda: el.fit(np.ones((4, 8, 2)), lights=1),
            r"shape \(height, width, 3\).*got \(4, 8, 2\)",
        ),
        (
            lambda: el.fit_probe(NORMALS, np.ones((319, 3))),
            r"irradiance must have as many rows as normals \(320\); got 319",
        ),
        (lambda: el.fit_probe(NORMALS[:5], np.ones((5, 3))), r"at least 8 normals for 4 lights"),
        (lambda: el.fit_probe(2 * NORMALS, np.ones((320, 3))), r"normal 0 has length 2"),
        (
            lambda: el.fit_probe(NORMALS, np.full((320, 3), np.nan)),
            r"irradiance must be finite; row 0 holds NaN",
        ),
        (
            lambda: el.fit_probe(NORMALS, np.ones((320, 3)), weights=np.zeros(320)),
            "weights must not all be 0",
        ),
        (
            lambda: el.fit_probe(NORMALS, np.ones((320, 3)), weights=-np.ones(320)),
            r"weights must not be negative; row 0 holds -1",
        ),
    ],
)
def test_bad_input_is_refused_by_name(call, message):
    with pytest.raises(el.EnvLightsError, match=message):
        call()


# How many lights


@real_maps("hdr/*.hdr")
def test_an_error_is_reached_with_the_fewest_lights(path):
    env = el.EnvMap.open(path)
    rig = el.fit(env, error=0.02)
    assert rig.error <= 0.02
    assert rig.report.stop_reason.is_success
    fewer = el.fit(env, lights=len(rig.lights) - 1)
    assert fewer.error > 0.02


def test_an_error_that_ambient_reaches_needs_no_light():
    even = np.full((64, 128, 3), 0.5)
    even[:32] += 0.01
    rig = el.fit(even, error=0.05)
    assert len(rig.lights) == 0
    assert len(rig.report.search_errors) == 1


def test_an_error_out_of_reach_is_said():
    rig = el.fit(el.synthetic.hall(128).radiance, lights=1, error=1e-4)
    assert len(rig.lights) == 1
    assert rig.report.stop_reason is el.rigs.StopReason.ERROR_NOT_REACHED
    assert not rig.report.stop_reason.is_success
    assert "note: the requested error was not reached" in str(rig)


# Notes, options and limits


def test_notes_of_the_map_are_those_of_the_rig():
    radiance = np.array(el.synthetic.hall(64).radiance)
    radiance[3, 5, 1] = np.nan
    assert el.fit(radiance, lights=1).notes == ("1 NaN sample set to the mean of the neighbours",)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"error": -0.1}, "error must be a finite number, from 0 to 1"),
        *(
            ({name: value}, f"^{name} must be below 1 .*; got 1")
            for name in ("error", "shadow_error", "gloss_error")
            for value in (1, 1.0, np.float32(1))
        ),
        ({"error": np.nan}, "error must be a finite number"),
        ({"ambient": "x"}, "ambient must be 'none' or 'constant' or 'sh2' or 'auto'"),
        ({"fixed": [[0, 2, 0]]}, "direction 0 has length 2"),
        ({"fixed": [0, 1, 0]}, "fixed must have 2 axes"),
        ({"fixed": [[0, 1, 0], [0, 0, 1]], "lights": 1}, "lights must be at least the 2 fixed"),
        ({"start": "x"}, "start must be 'greedy' or 'detect' or 'even'"),
    ],
)
def test_bad_options_are_refused_by_name(options, message):
    with pytest.raises(el.EnvLightsError, match=message):
        el.fit(np.ones((8, 16, 3)), **options)


def test_lights_that_only_follow_the_pattern_of_the_normals_are_not_tried():
    """A coarse constant map: its error is that of its few rows, which no light can mend."""
    rig = el.fit(np.ones((8, 16, 3)), lights=40, ambient="sh2")
    assert len(rig.lights) <= 1
    assert max(rig.report.search_errors) < 10
    assert "of at most 40 lights used: the error is already below 1e-4" in rig.report.fewer_lights


def test_the_smallest_numbers_there_are_do_not_overflow():
    rig = el.fit_probe(NORMALS, known_rig().probe(NORMALS) * 1e-310, lights=3)
    assert np.isfinite(rig.lights.irradiance).all()
    assert rig.error < 1e-3


# The report


def test_the_report_holds_the_errors_of_the_rig():
    env = el.EnvMap(el.synthetic.hall(256).radiance)
    rig = el.fit(env, lights=3)
    normals, solid_angles = kernels.icosphere(20480)
    wanted, weights = env.probe(normals), solid_angles[:, None]
    difference = rig.probe(normals) - wanted
    channels = np.sqrt((weights * difference**2).sum(axis=0) / (weights * wanted**2).sum(axis=0))
    np.testing.assert_allclose(rig.report.channel_errors, channels, rtol=0.05)
    rms = np.sqrt((weights * wanted**2).sum() / weights.sum() / 3)
    assert rig.report.max_error == pytest.approx(np.abs(difference).max() / rms, rel=0.1)
    assert rig.report.max_error >= rig.error


def test_standard_errors_are_those_of_many_noisy_probes():
    rig = known_rig()
    exact = rig.probe(NORMALS)
    rng = np.random.default_rng(11)
    noise = 0.01
    found = [
        el.fit_probe(NORMALS, exact + rng.normal(scale=noise, size=exact.shape), start=rig)
        for _ in range(300)
    ]
    direction = np.array([f.lights.direction for f in found])
    irradiance = np.array([f.lights.irradiance for f in found])
    stated = found[0].report
    spread = np.sqrt(((direction - rig.lights.direction) ** 2).sum(axis=2).mean(axis=0))
    np.testing.assert_allclose(stated.direction_errors, spread, rtol=0.15)
    spread = np.sqrt(((irradiance - rig.lights.irradiance) ** 2).mean(axis=0))
    np.testing.assert_allclose(stated.irradiance_errors, spread, rtol=0.2)


def test_the_condition_number_tells_lights_that_the_probe_cannot():
    def condition(directions):
        exact = kernels.rig_irradiance(NORMALS, [0.1] * 3, directions, np.ones((2, 3)))
        return el.fit_probe(NORMALS, exact, fixed=directions).report.condition

    apart = condition([[0, 1, 0], [1, 0, 0]])
    close = condition([[0, 1, 0], [np.sin(1e-3), np.cos(1e-3), 0]])
    assert 1 < apart < 10
    assert close > 100 * apart


def test_a_grey_map_is_fitted_in_one_channel():
    grey = el.synthetic.hall(128).radiance[..., :1].repeat(3, axis=2)
    rig = el.fit(grey, lights=2)
    assert "2 of 3 channels skipped: black or equal to another" in rig.report.skipped
    np.testing.assert_array_equal(rig.lights.irradiance[:, 0], rig.lights.irradiance[:, 2])
    colour = grey * np.float32([1, 0.5, 0])
    assert not el.fit(colour, lights=2).lights.irradiance[:, 2].any()
    assert "1 of 3 channels skipped: black or equal to another" in el.fit(colour).report.skipped


def test_a_rig_of_a_map_that_ends_at_white_says_what_it_rests_on():
    codes = np.full((64, 128, 3), 60, np.uint8)
    codes[10:14, 30:34] = 255
    for rig in (el.fit(codes, 1), el.papers.madsen.fit(codes, 1)):
        assert re.search(r"clipped pixels hold [1-9].* % of the map's flux.*", rig.notes[-1])
    assert not any("clipped" in note for note in el.fit(codes // 2, 1).notes)


@pytest.mark.parametrize("ambient", ["none", "constant"])
def test_a_rig_without_lights_is_no_black_map(ambient):
    rig = el.fit(el.synthetic.hall(16).radiance, 0, ambient=ambient)
    assert len(rig.lights) == 0
    assert rig.report.stop_reason is el.rigs.StopReason.CONVERGED
