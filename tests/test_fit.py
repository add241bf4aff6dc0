"""The fit against known rigs, scipy, and itself under other scales."""

import numpy as np
import pytest

import envlights as el
from envlights import kernels
from tests.conftest import EQUIRECTANGULAR, real_maps
from tests.twins.madsen import Problem, best_of_random_starts

NORMALS, SOLID_ANGLES = kernels.icosphere(320)


def known_rig():
    direction = np.array([[0.2, 0.9, 0.3], [-0.8, 0.1, 0.5], [0.4, -0.3, -0.8]])
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    return el.Rig(
        [0.3, 0.2, 0.1], el.Lights(direction, [[5, 4, 3], [1, 2, 3], [0.5, 0.5, 0.4]]), error=0.0
    )


@pytest.mark.parametrize("scale", [1.0, 1e-9, 1e9])
def test_known_lights_come_back(scale):
    rig = known_rig()
    found = el.fit_probe(NORMALS, scale * rig.probe(NORMALS), lights=3)
    np.testing.assert_allclose(found.lights.direction, rig.lights.direction, atol=1e-6)
    np.testing.assert_allclose(found.lights.irradiance / scale, rig.lights.irradiance, rtol=1e-6)
    np.testing.assert_allclose(found.ambient / scale, rig.ambient, rtol=1e-6)
    assert found.error < 1e-8
    assert found.report.stop_reason is el.StopReason.EXACT


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
    assert rig.report.errors[2] == rig.error
    assert len(rig.report.errors) == 3


def test_no_light_is_an_answer():
    radiance = el.synthetic.hall(64).radiance
    rig = el.fit(radiance, lights=0)
    assert len(rig.lights) == 0
    assert (rig.ambient > 0).all()
    assert rig.report.errors == (rig.error,)


@pytest.mark.parametrize("lights", [0, 4])
def test_a_black_map_needs_no_light(lights):
    rig = el.fit(np.zeros((16, 32, 3)), lights=lights)
    assert len(rig.lights) == 0
    assert rig.error == 0
    assert not rig.ambient.any()
    assert rig.report.stop_reason is el.StopReason.NOTHING_TO_FIT


def test_a_constant_map_is_ambient_alone():
    rig = el.fit(np.full((64, 128, 3), (1.0, 2.0, 3.0)), lights=0)
    np.testing.assert_allclose(rig.ambient, [1, 2, 3], rtol=1e-3)
    assert rig.error < 1e-4


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
    assert rig.error < rig.report.errors[0]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: el.fit(np.ones((4, 8, 3)), lights=-1), r"lights must be .* 0 or more; got -1"),
        (lambda: el.fit(np.ones((4, 8, 3)), lights=3.5), r"lights must be a whole .* got 3.5"),
        (lambda: el.fit(np.ones((4, 8, 3)), lights=True), r"lights must be a whole .* got True"),
        (lambda: el.fit(np.ones((4, 8)), lights=1), r"shape \(height, width, 3\); got \(4, 8\)"),
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
    assert len(rig.report.errors) == 1


def test_an_error_out_of_reach_is_said():
    rig = el.fit(el.synthetic.hall(128).radiance, lights=1, error=1e-4)
    assert len(rig.lights) == 1
    assert rig.report.stop_reason is el.StopReason.ERROR_NOT_REACHED
    assert not rig.report.stop_reason.is_success


# Ambient and starts


def test_without_ambient_the_lights_do_it_alone():
    rig = known_rig()
    alone = el.Rig([0, 0, 0], rig.lights, error=0.0)
    found = el.fit_probe(NORMALS, alone.probe(NORMALS), lights=3, ambient="none")
    np.testing.assert_allclose(found.lights.irradiance, rig.lights.irradiance, rtol=1e-6)
    hall = el.synthetic.hall(128).radiance
    for lights in (0, 1, 4):
        lit = el.fit(hall, lights=lights, ambient="none")
        assert not lit.ambient.any()
        assert lit.error >= el.fit(hall, lights=lights).error * (1 - 1e-3)
    assert el.fit(hall, lights=0, ambient="none").error == 1.0


def test_without_ambient_it_is_as_good_as_scipy_without_it():
    env = el.EnvMap(el.synthetic.hall(256).radiance)
    wanted = env.probe(NORMALS)
    rig = el.fit_probe(NORMALS, wanted, lights=3, weights=SOLID_ANGLES, ambient="none")
    problem = Problem(NORMALS, SOLID_ANGLES, wanted, 3)

    def without_ambient(x):
        return problem.residual(np.concatenate([np.zeros(3), x]))

    optimize = pytest.importorskip("scipy.optimize")
    theta, phi = np.pi, 2 * np.pi
    uv = kernels.direction_to_uv(rig.lights.direction) * (phi, theta)
    start = np.column_stack([rig.lights.irradiance, uv[:, 1], uv[:, 0]]).ravel()
    lower = np.tile([0, 0, 0, -np.inf, -np.inf], 3)
    best = optimize.least_squares(without_ambient, start, bounds=(lower, np.inf), ftol=1e-12)
    # A polish by another solver from our answer finds nothing to gain.
    assert np.sum(without_ambient(start) ** 2) <= 2 * best.cost * (1 + 1e-6)


@pytest.mark.parametrize("start", ["greedy", "detect", "even"])
def test_every_start_gives_lights_none_negative(start):
    rig = el.fit(el.synthetic.hall(256).radiance, lights=4, start=start)
    assert 1 <= len(rig.lights) <= 4
    assert (rig.lights.irradiance >= 0).all()
    assert rig.error < 0.03


def test_an_earlier_rig_is_followed():
    """A frame later the sun has moved by a degree: each light stays the one it was."""
    suns = [(0.6, 0.8, 0.0), (-0.5, 0.6, 0.6)]
    turned = [(0.6 * np.cos(0.02), 0.8, 0.6 * np.sin(0.02)), suns[1]]

    def frame(directions):
        discs = [el.synthetic.Disc(d, 3, (90, 80, 70)) for d in directions]
        return el.synthetic.scene(128, background=[0.2] * 3, shapes=discs).radiance

    before = el.fit(frame(suns), lights=2)
    after = el.fit(frame(turned), lights=2, start=before)
    fresh = el.fit(frame(turned), lights=2)
    assert after.error <= fresh.error * (1 + 1e-6)
    assert after.report.steps < fresh.report.steps
    moved = np.rad2deg(np.arccos((after.lights.direction * before.lights.direction).sum(axis=1)))
    assert sorted(moved.round(1)) == pytest.approx([0.0, np.rad2deg(0.02) * 0.6], abs=0.3)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"error": -0.1}, "error must be a finite number, from 0 to 1"),
        ({"error": np.nan}, "error must be a finite number"),
        ({"ambient": "x"}, "ambient must be 'constant' or 'none'"),
        ({"start": "x"}, "start must be 'greedy' or 'detect' or 'even'"),
    ],
)
def test_bad_options_are_refused_by_name(options, message):
    with pytest.raises(el.EnvLightsError, match=message):
        el.fit(np.ones((8, 16, 3)), **options)
