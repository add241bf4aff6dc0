"""The paper's equations and fit against plain sums, other derivatives and other solvers."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import envlights as el
from envlights import kernels
from tests.reference.madsen import (
    cosines,
    derivatives_by_complex_steps,
    probe_as_written,
    probe_of_lit,
)
from tests.reference.peers import jax_in_float64

NORMALS, SOLID_ANGLES = kernels.icosphere(80)
HALL = el.synthetic.hall(256)
TETRAHEDRON = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / np.sqrt(3)
DOCUMENT = Path(__file__).parents[2] / "docs" / "method.md"

radiances = st.tuples(*[st.floats(-5, 5)] * 3)
thetas = st.floats(-4, 4) | st.sampled_from([0.0, np.pi])
lights = st.tuples(radiances, thetas, st.floats(-7, 7)).map(lambda it: [*it[0], *it[1:]])
unknowns = st.tuples(radiances, st.lists(lights, max_size=4)).map(
    lambda it: np.array([*it[0], *np.ravel(it[1])])
)
surfaces = st.fixed_dictionaries(
    {"k_a": st.floats(0, 4), "k_d": st.floats(0, 2), "C": st.tuples(*[st.floats(0, 1)] * 3)}
)


# Equations 4 to 9


@given(unknowns, surfaces)
def test_the_model_is_the_sums_of_the_paper(x, surface):
    received = kernels.probe_model(x, NORMALS[::7], **surface)
    np.testing.assert_allclose(received, probe_as_written(x, NORMALS[::7], **surface), atol=1e-12)


@given(unknowns, surfaces)
def test_the_residual_is_what_the_model_leaves_by_the_root_of_its_weight(x, surface):
    probe = NORMALS + 2
    left = (probe - kernels.probe_model(x, NORMALS, **surface)).ravel()
    alike = kernels.probe_residual(x, NORMALS, probe, **surface)
    np.testing.assert_allclose(alike, left, atol=1e-12)
    weighted = kernels.probe_residual(x, NORMALS, probe, weights=SOLID_ANGLES, **surface)
    np.testing.assert_allclose(weighted**2, np.repeat(SOLID_ANGLES, 3) * left**2, atol=1e-12)


def test_default_coefficients_make_it_the_irradiance_of_a_rig():
    ambient, directions, irradiance = np.array([0.3, 0.2, 0.1]), TETRAHEDRON, np.eye(4)[:, :3] + 1
    x = kernels.pack_lights(ambient, directions, irradiance)
    rig = kernels.rig_irradiance(NORMALS, ambient, directions, irradiance)
    np.testing.assert_allclose(kernels.probe_model(x, NORMALS), rig, rtol=1e-13)


def test_without_lights_there_is_ambient_light_alone():
    x = np.array([1.0, 2.0, 3.0])
    np.testing.assert_array_equal(kernels.probe_model(x, NORMALS, k_a=2), np.tile(2 * x, (80, 1)))
    assert kernels.probe_jacobian(x, NORMALS, NORMALS).shape == (240, 3)


# The Jacobian


def jacobians_by(how, x, surface, weights):
    """Ours, the independent one, and the rows that lie on no terminator."""
    surface = {**surface, "C": np.array(surface["C"])}
    dot = cosines(x, NORMALS)
    ours = kernels.probe_jacobian(x, NORMALS, 0 * NORMALS, weights=weights, **surface)
    theirs = -how(x, surface, dot > 0) * np.sqrt(np.repeat(weights, 3))[:, None]
    is_smooth = np.repeat((np.abs(dot) > 1e-9).all(axis=1), 3)
    return ours[is_smooth], theirs[is_smooth]


def by_complex_steps(x, surface, lit):
    return derivatives_by_complex_steps(lambda z: probe_of_lit(z, NORMALS, **surface, lit=lit), x)


def by_jax(x, surface, lit):
    pytest.importorskip("jax")
    with jax_in_float64() as jax:

        def model(z):
            return probe_of_lit(z, NORMALS, **surface, lit=lit, xp=jax.numpy).ravel()

        return np.asarray(jax.jacfwd(model)(jax.numpy.asarray(x)))


@given(unknowns, surfaces)
def test_the_jacobian_is_that_of_complex_steps(x, surface):
    ours, theirs = jacobians_by(by_complex_steps, x, surface, SOLID_ANGLES)
    assert len(ours) >= 3 * 40 or len(x) > 8  # few rows are on a terminator
    np.testing.assert_allclose(ours, theirs, atol=1e-10)


@settings(max_examples=10)
@given(unknowns, surfaces)
def test_the_jacobian_is_that_of_automatic_differentiation(x, surface):
    ours, theirs = jacobians_by(by_jax, x, surface, np.ones(80))
    np.testing.assert_allclose(ours, theirs, atol=1e-10)


@pytest.mark.parametrize("how", [by_complex_steps, by_jax])
@pytest.mark.parametrize("theta", [0.0, np.pi])
def test_a_light_on_a_pole_loses_phi_and_nothing_else(theta, how):
    x = np.array([0.1, 0.2, 0.3, 3.0, 2.0, 1.0, theta, 0.7])
    surface = {"k_a": 1.0, "k_d": 0.5, "C": (1.0, 0.9, 0.8)}
    ours, theirs = jacobians_by(how, x, surface, np.ones(80))
    np.testing.assert_allclose(ours, theirs, atol=1e-10)
    np.testing.assert_allclose(ours[:, 7], 0, atol=1e-15)
    assert np.linalg.matrix_rank(ours, tol=1e-10) == 7


def test_a_normal_on_the_terminator_has_the_derivative_of_the_dark_side():
    x = kernels.pack_lights(np.zeros(3), [[0, 1, 0]], np.ones((1, 3)))
    on_it, just_lit = [[1.0, 0.0, 0.0]], [[1.0, 1e-9, 0.0]]
    assert not kernels.probe_jacobian(x, on_it, [[0, 0, 0]])[:, 3:].any()
    assert kernels.probe_jacobian(x, just_lit, [[0, 0, 0]])[:, 3:].any()


# The unknowns


@given(st.lists(st.tuples(st.floats(-4, 4), st.floats(-7, 7)), max_size=5), radiances)
def test_lights_survive_the_way_through_the_unknowns(angles, radiance):
    x = np.array([*radiance, *np.ravel([[*radiance, *pair] for pair in angles])])
    once = kernels.unpack_lights(x)
    again = kernels.unpack_lights(kernels.pack_lights(*once))
    assert once[1].shape == once[2].shape == (len(angles), 3)
    for one, two in zip(once, again, strict=True):
        np.testing.assert_allclose(one, two, atol=1e-14)


# Other solvers


X = [1.0, 1.0, 1.0]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: kernels.probe_model([1, 2, 3, 4], NORMALS), r"x must hold 3 \+ 5 M .* got 4"),
        (lambda: kernels.unpack_lights([]), r"3 \+ 5 M numbers .*; got 0"),
        (lambda: kernels.unpack_lights([0, np.nan, 0]), r"x must be finite; row 1 holds NaN"),
        (lambda: kernels.unpack_lights([X]), r"x must have 1 axes; got the shape \(1, 3\)"),
        (lambda: kernels.probe_model(X, [[0, 2, 0]]), r"normal 0 has length 2"),
        (lambda: kernels.probe_model(X, NORMALS, k_a=-1), r"k_a must be a finite number, 0 or m"),
        (lambda: kernels.probe_model(X, NORMALS, k_d=np.inf), r"k_d must be a finite number"),
        (lambda: kernels.probe_model(X, NORMALS, C=(1, 1)), r"C must be three numbers; .*\(2,\)"),
        (lambda: kernels.probe_residual(X, NORMALS, NORMALS[1:]), r"probe must have as many rows"),
        (
            lambda: kernels.probe_jacobian(X, NORMALS, NORMALS, weights=-SOLID_ANGLES),
            r"weights must not be negative; row 0 holds -0\.",
        ),
        (
            lambda: kernels.pack_lights(X, [[0, 1, 0]], [X, X]),
            r"irradiance must have as many rows as directions \(1\); got 2",
        ),
        (lambda: kernels.pack_lights([1], [[0, 1, 0]], [X]), r"ambient must .*\(3,\); got \[1\]"),
        (lambda: kernels.face_radiance(np.ones((8, 16, 3)), 100), r"20 \* 4\^k faces .* got 100"),
        (lambda: kernels.face_radiance(np.ones((8, 16))), r"radiance must have 3 axes"),
        (
            lambda: el.papers.madsen.fit(np.ones((8, 16, 3)), 192),
            r"lights must be at most 191, .*; got 192",
        ),
        (lambda: el.papers.madsen.fit(np.ones((8, 16, 3)), -1), r"lights must be a whole number"),
        (lambda: el.papers.madsen.fit(np.ones((8, 16, 3)), k_d=0), r"k_d and C must be above 0"),
        (
            lambda: el.papers.madsen.fit(np.ones((8, 16, 3)), C=(1, 0, 1)),
            r"k_d and C must be above 0",
        ),
        (
            lambda: el.papers.madsen.fit(np.ones((8, 16, 3)), 2, start=[[0, 1, 0]]),
            r"start must have the shape \(lights, 3\) = \(2, 3\); got \(1, 3\)",
        ),
        (
            lambda: el.papers.madsen.fit(np.ones((8, 16, 3)), 1, start=[[0, 3, 0]]),
            r"direction 0 has length 3",
        ),
    ],
)
def test_bad_input_is_refused_by_name(call, message):
    with pytest.raises(el.EnvLightsError, match=message):
        call()
