"""Ambient terms, and the number of lights that each leaves necessary."""

import numpy as np
import pytest

import envlights as el
from envlights import kernels
from tests.conftest import real_maps
from tests.fitting.worst_cases import known_rig
from tests.helpers import EQUIRECTANGULAR, NORMALS, SOLID_ANGLES
from tests.reference.madsen import Problem


def gradient(slope=0.8):
    """A sky whose radiance is linear in the height: harmonics of order 1 are all of it."""
    height = kernels.pixel_directions(64, 128)[..., 1:2]
    return (1 + slope * height) * [0.8, 0.9, 1.0]


def suns_before(background):
    suns = [el.synthetic.Disc(d, 3, (90, 80, 70)) for d in ((0.6, 0.8, 0.0), (-0.5, 0.6, 0.6))]
    return el.synthetic.scene(128, background=[background] * 3, shapes=suns).radiance


@pytest.mark.parametrize("rows", [64, 128, 256, 512, 1024, 2048])
@pytest.mark.parametrize("ambient", ["constant", "auto"])
def test_a_constant_map_has_no_light_at_any_size(rows, ambient):
    rig = el.fit(np.full((rows, 2 * rows, 3), np.float32(0.7)), ambient=ambient)
    assert len(rig.lights) == 0
    assert rig.report.ambient == "constant"
    np.testing.assert_allclose(rig.ambient, 0.7, rtol=1e-6)
    assert "0 of at most 4 lights used" in rig.report.fewer_lights


def test_no_light_is_added_below_the_error_of_the_rendering():
    """Waves of 1e-4 of the radiance, which lights could follow."""
    waves = 1 + 1e-4 * kernels.pixel_directions(128, 256)[..., :1] ** 3 * np.ones(3)
    rig = el.fit(waves, lights=8)
    assert len(rig.lights) == 0
    assert "the error is already below 1e-4" in rig.report.fewer_lights


@pytest.mark.parametrize("options", [{}, {"error": 0.02}, {"error": 0.001, "lights": 8}])
def test_a_gradient_is_harmonics_without_a_light(options):
    rig = el.fit(gradient(), ambient="auto", **options)
    assert len(rig.lights) == 0
    assert rig.ambient.shape == (9, 3)
    assert rig.error < 2e-4
    assert rig.report.ambient == "sh2"


@pytest.mark.parametrize(
    ("background", "options", "chosen"),
    [
        (0.0, {"error": 0.02}, "none"),
        (0.3, {"error": 0.02}, "sh2"),
        (0.3, {"error": 0.01}, "constant"),
        (0.3, {"error": 0.6}, "constant"),
        (0.3, {"lights": 2, "error": 1e-5}, "sh2"),
        (0.0, {"error": 0.02, "floor": True}, "none"),
        (0.3, {"lights": 2, "floor": True}, "constant"),
    ],
)
def test_the_fewest_lights_are_chosen_then_the_simplest(background, options, chosen):
    radiance = suns_before(background)
    options["sizes"] = False
    rig = el.fit(radiance, ambient="auto", **options)
    assert rig.report.ambient == chosen
    same = el.fit(radiance, ambient=chosen, **options)
    assert rig.to_dict()["lights"] == same.to_dict()["lights"]
    assert rig.to_dict()["ambient"] == same.to_dict()["ambient"]


@pytest.mark.parametrize("options", [{"error": 0.01}, {"lights": 3}, {"lights": 3, "error": 1e-3}])
def test_the_figures_of_each_are_those_of_its_own_fit(options):
    radiance = el.synthetic.hall(128).radiance
    rig = el.fit(radiance, ambient="auto", **options)
    alone = {
        name: el.fit(radiance, ambient=name, **options) for name in ("none", "constant", "sh2")
    }
    assert rig.report.ambients == {name: (len(r.lights), r.error) for name, r in alone.items()}
    if all(each.error > options.get("error", 0) for each in alone.values()):
        assert rig.error <= (1 + 1e-3) * min(each.error for each in alone.values())
    else:
        reached = [len(r.lights) for r in alone.values() if r.error <= options["error"]]
        assert len(rig.lights) == min(reached)
        assert rig.error <= options["error"]


def test_the_choice_is_printed_and_saved(tmp_path):
    rig = el.fit(gradient(), ambient="auto", error=0.05, lights=1)
    text = str(rig.report)
    assert "ambient term 'sh2' selected from  none: 1 light, " in text
    assert "  sh2: 0 lights, " in text
    rig.save(tmp_path / "rig.json")
    assert el.Rig.load(tmp_path / "rig.json").report == rig.report


def test_over_a_floor_harmonics_are_not_tried():
    rig = el.fit(gradient(), ambient="auto", floor=True)
    assert set(rig.report.ambients) == {"none", "constant"}


def test_what_was_asked_for_is_not_called_a_choice():
    rig = el.fit(gradient(), lights=1, ambient="none")
    assert rig.report.ambient == "none"
    assert rig.report.ambients == {}
    assert "chosen" not in str(rig.report)
    with pytest.raises(el.EnvLightsError, match="ambient must be 'none' or 'constant' or 'sh2';"):
        el.fit_probe(np.eye(3), np.eye(3), 0, ambient="auto")


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


# Harmonics


def harmonics(normals):
    """Irradiance of each harmonic, from scipy's own polynomials on the sphere."""
    from scipy.special import sph_harm_y

    # The paper's pole is z; scipy's real and imaginary parts make the real harmonics.
    theta, phi = np.arccos(normals[:, 2].clip(-1, 1)), np.arctan2(normals[:, 1], normals[:, 0])
    columns = []
    for n, m in [(0, 0), (1, -1), (1, 0), (1, 1), (2, -2), (2, -1), (2, 0), (2, 1), (2, 2)]:
        y = sph_harm_y(n, abs(m), theta, phi)
        part = y.real if m == 0 else np.sqrt(2) * (-1) ** m * (y.imag if m < 0 else y.real)
        columns.append([np.pi, 2 * np.pi / 3, np.pi / 4][n] * part)
    return np.stack(columns, axis=1)


def test_harmonics_are_those_of_an_independent_library():
    rng = np.random.default_rng(3)
    coefficients = rng.normal(size=(9, 3))
    nothing = np.zeros((0, 3))
    seen = kernels.rig_irradiance(NORMALS, coefficients, nothing, nothing)
    np.testing.assert_allclose(seen, harmonics(NORMALS) @ coefficients, atol=1e-12)


def test_an_environment_of_harmonics_and_a_light_comes_back():
    rig = known_rig()
    coefficients = np.zeros((9, 3))
    coefficients[0], coefficients[1], coefficients[8] = 1.0, (0.3, 0.2, 0.1), 0.2
    one = el.Rig(coefficients, rig.lights[:1], 0)
    found = el.fit_probe(NORMALS, one.probe(NORMALS), lights=1, ambient="sh2")
    np.testing.assert_allclose(found.ambient, coefficients, atol=1e-6)
    np.testing.assert_allclose(found.lights.direction, one.lights.direction, atol=1e-6)


@real_maps(*EQUIRECTANGULAR)
def test_harmonics_and_one_light_do_well_and_are_nowhere_negative(path):
    env = el.EnvMap.open(path)
    rig = el.fit(env, lights=1, ambient="sh2")
    assert rig.error <= el.fit(env, lights=1).error
    assert rig.error < 0.03
    dense, _ = kernels.icosphere(20480)
    nothing = np.zeros((0, 3))
    ambient = kernels.rig_irradiance(dense, rig.ambient, nothing, nothing)
    assert ambient.min() >= -1e-12 * ambient.max()


@pytest.mark.parametrize("spread", [1e-3, 0.0])
def test_harmonics_are_never_worse_than_the_constant_that_they_hold(spread):
    """All normals are nearly parallel, so the harmonics are nearly indistinguishable."""
    rng = np.random.default_rng(0)
    normals = [0, 1, 0] + spread * rng.normal(size=(40, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    seen = 1 + 0.1 * rng.normal(size=(40, 3))
    constant, harmonics = (
        el.fit_probe(normals, seen, 0, ambient=ambient) for ambient in ("constant", "sh2")
    )
    assert 0.1 < harmonics.error <= constant.error * (1 + 1e-9)


def test_harmonics_under_their_bound_are_the_best_there_are():
    """Against scipy on the same problem, the bound imposed at 1280 normals."""
    optimize = pytest.importorskip("scipy.optimize")
    # A sun that harmonics ring around: unbounded they would be negative.
    wanted = kernels.rig_irradiance(NORMALS, [0, 0, 0], [[0, 1, 0]], [[1, 1, 1]])
    rig = el.fit_probe(NORMALS, wanted, lights=0, weights=SOLID_ANGLES, ambient="sh2")
    root = np.sqrt(SOLID_ANGLES)[:, None]
    columns, target = root * harmonics(NORMALS), root[:, 0] * wanted[:, 0]
    bound = harmonics(kernels.icosphere(1280)[0])
    best = optimize.minimize(
        lambda c: np.sum((columns @ c - target) ** 2),
        rig.ambient[:, 0] + 0.05,
        jac=lambda c: 2 * columns.T @ (columns @ c - target),
        constraints={"type": "ineq", "fun": lambda c: bound @ c, "jac": lambda c: bound},
        method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 500},
    )
    ours = np.sum((columns @ rig.ambient[:, 0] - target) ** 2)
    free = np.linalg.lstsq(columns, target, rcond=None)[0]
    assert (bound @ free).min() < 0
    assert best.fun * (1 - 1e-6) <= ours <= best.fun * (1 + 2e-3)
