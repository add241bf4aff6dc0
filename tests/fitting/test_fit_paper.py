"""`fit_paper`: the iteration of Madsen et al. (2003), and other solvers of its equations."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares

import envlights as el
from envlights import kernels
from envlights.papers import madsen
from tests.reference.peers import jax_in_float64

NORMALS, SOLID_ANGLES = kernels.icosphere(80)
HALL = el.synthetic.hall(256)
TETRAHEDRON = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / np.sqrt(3)
DOCUMENT = Path(__file__).parents[2] / "docs" / "method.md"


def blocks(*names):
    """Run these examples of the documentation, and return what they leave behind."""
    text = DOCUMENT.read_text(encoding="utf-8")
    found = dict(re.findall(r"<!-- (\w+) -->\n```python\n(.*?)```", text, re.DOTALL))
    left: dict[str, object] = {}
    for name in names:
        exec(found[name], left)
    return left


@pytest.mark.slow
def test_scipy_and_jaxopt_end_in_the_same_minimum_as_documented():
    pytest.importorskip("jaxopt")
    with jax_in_float64() as jax:
        left = blocks("both", "scipy", "jaxopt")
        theirs = np.asarray(left["by_jaxopt"].params)
        at = left["start"]
        for differentiate in (jax.jacfwd, jax.jacrev):
            derived = np.asarray(differentiate(left["residual"])(at))
            args = left["normals"], left["probe"]
            wanted = kernels.probe_jacobian(at, *args, weights=left["weights"])
            np.testing.assert_array_equal(derived, wanted)
    ours = left["by_scipy"].x
    for one, two in zip(kernels.unpack_lights(ours), kernels.unpack_lights(theirs), strict=True):
        np.testing.assert_allclose(one, two, atol=1e-4)
    # The same sum as that of `fit`, which no light may leave with a negative radiance.
    rig = el.fit_probe(left["normals"], left["probe"], lights=4, weights=left["weights"])
    np.testing.assert_allclose(
        np.sqrt(2 * left["by_scipy"].cost / np.sum(left["weights"] * (left["probe"] ** 2).T)),
        rig.error,
        rtol=1e-3,
    )


def test_another_solver_finds_nothing_to_gain_from_the_papers_answer():
    found = el.papers.madsen.fit(HALL.radiance)
    problem = render(HALL.radiance)
    polished = least_squares(
        kernels.probe_residual, found.parameters, kernels.probe_jacobian, args=problem, xtol=1e-12
    )
    error = np.sqrt(2 * polished.cost) / np.linalg.norm(problem[1])
    assert error == pytest.approx(found.error, rel=1e-5)


# The paper's fit


def render(radiance):
    """Normals, and the probe under 5120 sources: equations 1 to 3."""
    normals, _ = kernels.icosphere(320)
    sources, solid_angles = kernels.icosphere(5120)
    scene = kernels.face_radiance(radiance, 5120)
    return normals, kernels.sum_over_sources(normals, sources, scene, solid_angles)


def test_the_papers_scene_lights_the_probe_as_the_whole_map_does():
    normals, received = render(HALL.radiance)
    exact = el.EnvMap(HALL.radiance).probe(normals)
    assert kernels.relative_rms(received, exact, np.ones(320)) < 1e-3


def test_a_bright_pixel_is_a_bright_face_around_it():
    centroids, solid_angles = kernels.icosphere(5120)
    pixels = kernels.pixel_directions(64, 128)
    for row, column in [(0, 0), (31, 77), (63, 127)]:
        one = np.zeros((64, 128, 3), np.float32)
        one[row, column] = 1, 2, 3
        fluxes = kernels.face_radiance(one) * solid_angles[:, None]
        (face,) = np.flatnonzero(fluxes.any(axis=1))
        flux = kernels.pixel_solid_angles(64, 128)[row, column] * np.array([1, 2, 3])
        np.testing.assert_allclose(fluxes[face], flux, rtol=1e-12)
        assert centroids[face] @ pixels[row, column] > np.cos(np.deg2rad(2.5))


def keeps_the_claim(found):
    """True if three lights are within 3 degrees of the windows, and the fourth is the wall's."""
    cosine = HALL.lights.direction @ found.direction.T
    (others,) = np.nonzero(~np.isin(np.arange(4), cosine.argmax(axis=1)))
    return bool(
        cosine.max(axis=1).min() > np.cos(np.deg2rad(3))
        and len(others) == 1
        and found.direction[others[0], 2] < -0.9
        and (found.irradiance[others[0]] > 0).all()
    )


@pytest.mark.parametrize("scale", [0.3, 1.0, 100.0])
@pytest.mark.parametrize("height", [64, 256, 512])
def test_the_claim_of_the_paper_holds_on_its_hall(height, scale):
    """Section 3.2: sources at the windows, the last at the wall, in about 20 iterations."""
    hall = el.synthetic.hall(height).radiance * np.float32(scale)
    found = el.papers.madsen.fit(hall, lights=4)
    assert keeps_the_claim(found)
    assert found.steps <= 20
    assert found.stop_reason is el.rigs.StopReason.CONVERGED
    assert found.error < 0.01


def test_damped_steps_keep_the_claim_from_many_starts_and_whole_ones_from_few():
    """The paper's "more or less arbitrarily chosen initial guesses" decide."""
    rng = np.random.default_rng(0)
    starts = [TETRAHEDRON @ np.linalg.qr(rng.normal(size=(3, 3)))[0].T for _ in range(12)]
    damped = [el.papers.madsen.fit(HALL.radiance, start=start) for start in starts]
    whole = [el.papers.madsen.fit(HALL.radiance, start=start, damped=False) for start in starts]
    assert all(found.stop_reason.is_success for found in damped)
    assert sum(map(keeps_the_claim, damped)) >= 5
    assert sum(map(keeps_the_claim, whole)) <= 3


def test_whole_steps_do_as_well_from_where_the_lights_are():
    """Close to the answer nothing is shortened, and a step that changes nothing is the last."""
    found = el.papers.madsen.fit(HALL.radiance)
    again = el.papers.madsen.fit(HALL.radiance, start=found.direction, damped=False)
    assert again.stop_reason is el.rigs.StopReason.CONVERGED
    assert again.steps < 10
    np.testing.assert_allclose(again.parameters, found.parameters, atol=1e-3)


def test_damped_steps_never_raise_the_error():
    for many in (1, 3, 7):
        found = el.papers.madsen.fit(HALL.radiance, lights=many)
        assert (np.diff(found.errors) <= 0).all()
        assert len(found.direction) == many


def test_two_pixels_in_the_dark_come_back_as_the_faces_that_they_are_in():
    dark = np.zeros((64, 128, 3), np.float32)
    dark[20, 30], dark[40, 100] = (900, 800, 700), (300, 400, 500)
    scene = kernels.face_radiance(dark)
    centroids, solid_angles = kernels.icosphere(5120)
    (faces,) = np.flatnonzero(scene.any(axis=1))[None]
    found = el.papers.madsen.fit(dark, lights=2, k_a=0)
    assert found.stop_reason in (el.rigs.StopReason.EXACT, el.rigs.StopReason.CONVERGED)
    order = (found.direction @ centroids[faces].T).argmax(axis=0)
    np.testing.assert_allclose(found.direction[order], centroids[faces], atol=1e-6)
    flux = scene[faces] * solid_angles[faces, None]
    np.testing.assert_allclose(found.irradiance[order], flux, rtol=1e-6)
    np.testing.assert_array_equal(found.ambient, 0)


def test_coefficients_scale_ambient_light_as_equation_4_does_and_leave_the_rig_alone():
    one = el.papers.madsen.fit(HALL.radiance)
    tenth = el.papers.madsen.fit(HALL.radiance, k_a=0.1 * np.pi)
    np.testing.assert_allclose(tenth.ambient, 10 * one.ambient, rtol=1e-3)
    # Gray: a colour would weigh the channels against each other.
    gray = el.papers.madsen.fit(HALL.radiance, k_a=1, k_d=0.5, C=(0.8, 0.8, 0.8))
    for other in (tenth, gray):
        np.testing.assert_allclose(other.rig().ambient, one.rig().ambient, rtol=1e-3)
        np.testing.assert_allclose(other.irradiance, one.irradiance, rtol=1e-3)


def test_the_rig_is_what_was_found():
    found = el.papers.madsen.fit(HALL.radiance)
    rig = found.rig()
    received = kernels.probe_model(found.parameters, NORMALS)
    np.testing.assert_allclose(rig.probe(NORMALS), received, rtol=1e-12)
    assert (rig.error, rig.report.steps) == (found.error, found.steps)
    assert rig.report.measured_on == "the 320 fitted normals"


def test_negative_light_is_an_answer_of_the_paper_but_no_rig():
    below = el.papers.madsen.fit(HALL.radiance, start=-HALL.lights.direction, lights=3)
    assert below.irradiance.min() < 0
    with pytest.raises(
        el.EnvLightsError, match=r"must not hold negative light; the smallest value is -"
    ):
        below.rig()


@pytest.mark.parametrize("damped", [True, False])
def test_a_black_map_is_explained_at_once(damped):
    found = el.papers.madsen.fit(np.zeros((16, 32, 3)), lights=3, damped=damped)
    assert found.stop_reason is el.rigs.StopReason.EXACT
    np.testing.assert_allclose(found.irradiance, 0, atol=1e-12)
    np.testing.assert_allclose(found.ambient, 0, atol=1e-12)


def test_no_light_is_an_answer():
    found = el.papers.madsen.fit(np.full((64, 128, 3), (1.0, 2.0, 3.0)), lights=0)
    assert found.stop_reason is el.rigs.StopReason.CONVERGED
    np.testing.assert_allclose(found.ambient, [1, 2, 3], rtol=1e-2)


@settings(max_examples=20)
@given(
    st.integers(0, 2**32 - 1),
    st.integers(0, 9),
    st.sampled_from([1e-30, 1e-3, 1.0, 1e6, 1e38]),
    st.booleans(),
)
def test_any_map_gets_finite_lights(seed, many, scale, damped):
    rng = np.random.default_rng(seed)
    radiance = (rng.uniform(size=(8, 16, 3)) ** 8 * scale).astype(np.float32)
    found = el.papers.madsen.fit(radiance, lights=many, damped=damped, max_steps=15)
    assert found.steps <= 15
    for part in (found.ambient, found.direction, found.irradiance, found.errors):
        assert np.isfinite(part).all()


def give_steps(monkeypatch, change):
    """Let each least-squares step be what `change` makes of the right one."""
    lstsq = np.linalg.lstsq

    def changed_lstsq(*given, **options):
        step, *rest = lstsq(*given, **options)
        return change(step), *rest

    monkeypatch.setattr(np.linalg, "lstsq", changed_lstsq)


def test_a_step_that_cannot_be_computed_leaves_the_lights_before_it(monkeypatch):
    def fails(*_):
        raise np.linalg.LinAlgError

    give_steps(monkeypatch, fails)
    found = el.papers.madsen.fit(HALL.radiance)
    assert found.stop_reason is el.rigs.StopReason.RAN_AWAY
    assert not found.stop_reason.is_success
    np.testing.assert_array_equal(found.irradiance, 1)


def test_a_whole_step_beyond_every_float_leaves_the_lights_before_it(monkeypatch):
    give_steps(monkeypatch, lambda step: 1e300 * step)
    found = el.papers.madsen.fit(HALL.radiance, damped=False)
    assert (found.stop_reason, found.steps) == (el.rigs.StopReason.RAN_AWAY, 0)
    np.testing.assert_array_equal(found.irradiance, 1)
    assert np.isfinite(found.errors).all()


def test_a_damped_step_that_only_raises_the_error_is_not_taken(monkeypatch):
    give_steps(monkeypatch, lambda step: -step)
    found = el.papers.madsen.fit(HALL.radiance)
    assert (found.stop_reason, found.steps) == (el.rigs.StopReason.CONVERGED, 0)
    np.testing.assert_array_equal(found.irradiance, 1)


def test_a_step_that_changes_nothing_is_the_last(monkeypatch):
    give_steps(monkeypatch, lambda step: 0 * step)
    for damped in (True, False):
        found = el.papers.madsen.fit(HALL.radiance, damped=damped)
        assert (found.stop_reason, found.steps) == (el.rigs.StopReason.CONVERGED, 1)


@pytest.mark.parametrize("lights", [1, 4, 5, 7])
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_a_step_is_small_relative_to_radiances_and_in_radians(lights, scale):
    x = np.concatenate([[scale] * 3, np.tile([scale] * 3 + [1.0, 2.0], lights)])
    assert madsen._is_small(np.zeros_like(x), x)
    for number in range(len(x)):
        step = np.zeros_like(x)
        is_angle = number >= 3 and (number - 3) % 5 >= 3
        step[number] = 1e-3 if is_angle else 1e-3 * scale
        assert not madsen._is_small(step, x)
        assert madsen._is_small(1e-9 * step, x)


def test_steps_end_at_their_limit():
    for most in (0, 1, 3):
        found = el.papers.madsen.fit(HALL.radiance, max_steps=most)
        assert (found.stop_reason, found.steps) == (el.rigs.StopReason.OUT_OF_STEPS, most)
        assert not found.stop_reason.is_success


def test_the_same_map_gives_the_same_bits():
    one, two = (el.papers.madsen.fit(HALL.radiance, lights=5) for _ in range(2))
    np.testing.assert_array_equal(one.parameters, two.parameters)
    assert one.errors == two.errors


# Refusals
