"""Irradiance of arrays of lights, against rigs and differences, in each library."""

import numpy as np
import pytest

import envlights as el
from envlights.layers import Lights, probe
from tests.layers.libraries import (
    in_each_library,
    in_library,
    random_lights,
    slopes_and_differences,
    to_jax,
)

NORMALS, _ = el.kernels.icosphere(1280)
#: Cosine and radius of discs at the ends of the formula, and derivatives by both.
SPECIAL = {
    "touches from above": (np.sin(0.3), 0.3, 1, 0),
    "touches from below": (-np.sin(0.3), 0.3, 0, 0),
    "point above": (0.4, 0.0, 1, 0),
    "point on the horizon": (0.0, 0.0, 0.5, 2 / (3 * np.pi)),
    "point below": (-0.4, 0.0, 0, 0),
    "half the sky": (0.0, np.pi / 2, 0.5, 2 / np.pi),
    "half the sky above": (1.0, np.pi / 2, 1, 0),
    "half the sky below": (-1.0, np.pi / 2, 0, 0),
    "opposite": (-1.0, 0.2, 0, 0),
}


@in_each_library
@pytest.mark.parametrize("ambient", ["constant", "sh2"])
def test_the_probe_is_that_of_a_rig(convert, ambient):
    for seed in range(5):
        lights = random_lights(seed, ambient=ambient)
        lights.angular_radius[:2] = 0, np.pi / 2
        ours = np.asarray(probe(in_library(lights, convert), convert(NORMALS)))
        np.testing.assert_allclose(ours, lights.rig().probe(NORMALS), rtol=1e-12)


def test_the_probe_of_single_precision_is_exact_to_1e_5():
    pytest.importorskip("jax")
    for seed in range(5):
        lights = random_lights(seed, lights=4)
        single = in_library(lights, lambda values: to_jax(values, "float32"))
        ours = probe(single, to_jax(NORMALS, "float32"))
        assert ours.dtype == "float32"
        np.testing.assert_allclose(ours, lights.rig().probe(NORMALS), rtol=1e-5)


@in_each_library
def test_a_batch_with_a_mask_is_its_rows(convert):
    lights = random_lights(3, batch=(2, 3))
    mask = np.random.default_rng(0).random((2, 3, 6)) < 0.7
    # Networks pad with zeros.
    masked = lights._replace(direction=lights.direction * mask[..., None], mask=mask * 1.0)
    ours = np.asarray(probe(in_library(masked, convert), convert(NORMALS)))
    assert ours.shape == (2, 3, len(NORMALS), 3)
    for row in np.ndindex(2, 3):
        rig = masked.row(row).rig()
        assert len(rig.lights) == mask[row].sum()
        np.testing.assert_allclose(ours[row], rig.probe(NORMALS), rtol=1e-12)


def test_derivatives_are_differences():
    """The step is 1e-6 of the radius, so that hardly any disc touches the horizon within it."""
    pytest.importorskip("jax")
    weights = to_jax(np.random.default_rng(5).normal(size=(20, 3)))
    normals = to_jax(NORMALS[::64])
    loss = lambda lights: (probe(lights, normals) * weights).sum()  # noqa: E731
    for slope, difference in slopes_and_differences(loss, range(40), 1e-6):
        assert slope == pytest.approx(difference, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("case", SPECIAL)
def test_derivatives_at_the_ends_of_the_formula(case, dtype):
    jax = pytest.importorskip("jax")
    cosine, radius, by_cosine, by_radius = SPECIAL[case]
    normal = np.array([[np.sqrt(1 - cosine**2), cosine, 0]])

    def loss(radius, normal):
        light = Lights(
            to_jax([[0, 1, 0]], dtype), to_jax([[1, 0, 0]], dtype), radius, to_jax([0] * 3, dtype)
        )
        return probe(light, normal)[0, 0]

    slopes = jax.grad(loss, (0, 1))(to_jax([radius], dtype), to_jax(normal, dtype))
    # Along the normal the probe is constant; across it, the cosine changes by the sine.
    across = slopes[1][0] @ to_jax([-cosine, normal[0, 0], 0], dtype)
    assert float(slopes[0][0]) == pytest.approx(by_radius, abs=1e-6)
    assert float(across) == pytest.approx(by_cosine * normal[0, 0], abs=1e-6)


def test_derivatives_of_single_precision_are_finite():
    jax = pytest.importorskip("jax")
    rng = np.random.default_rng(2)
    lights = random_lights(7, lights=4, batch=(10_000,))
    lights.angular_radius[rng.random((10_000, 4)) < 0.1] = 0
    lights.angular_radius[rng.random((10_000, 4)) < 0.1] = np.pi / 2
    lights.direction[::7, 1] = -lights.direction[::7, 0]
    lights.direction[::5, 2] = NORMALS[0]
    single = in_library(lights, lambda values: to_jax(values, "float32"))
    normals = to_jax([NORMALS[0], -NORMALS[0], *NORMALS[::200]], "float32")
    slopes = jax.jit(jax.grad(lambda lights: (probe(lights, normals) ** 2).sum()))(single)
    assert all(bool(jax.numpy.isfinite(each).all()) for each in slopes[:4])


def test_shapes_that_do_not_fit_are_refused():
    lights = random_lights(0)
    with pytest.raises(el.EnvLightsError, match=r"irradiance must have the shape \(6, 3\) beside"):
        probe(lights._replace(irradiance=lights.irradiance[:5]), NORMALS)
    with pytest.raises(el.EnvLightsError, match=r"ambient must have .* or \(9, 3\)"):
        probe(lights._replace(ambient=np.zeros(4)), NORMALS)
    with pytest.raises(el.EnvLightsError, match=r"lights must be el.layers.Lights; got Rig"):
        probe(lights.rig(), NORMALS)
    with pytest.raises(el.EnvLightsError, match="arrays of one library"):
        probe(lights._replace(ambient="black"), NORMALS)
