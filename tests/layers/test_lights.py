"""Lights to and from rigs and labels, as pixels, as Gaussians, and matched to others."""

import numpy as np
import pytest

import envlights as el
from envlights.layers import (
    Lights,
    gloss_error,
    lighting_error,
    map_terms,
    matching_loss,
    probe,
    to_gaussians,
    to_map,
)
from tests.layers.libraries import (
    in_each_library,
    in_library,
    random_lights,
    slopes_and_differences,
    to_jax,
    to_numpy64,
)

NORMALS, SOLID_ANGLES = el.kernels.icosphere(320)
HALL = el.synthetic.hall(64).radiance


@pytest.mark.parametrize("floor", [False, True])
def test_a_rig_comes_back(floor):
    rig = el.fit(HALL, lights=3, floor=floor)
    back = Lights.of(rig).rig(None if floor else HALL)
    np.testing.assert_allclose(back.probe(NORMALS), rig.probe(NORMALS), rtol=1e-12)
    if not floor:
        assert back.error == pytest.approx(rig.error, rel=1e-2)
        assert back.report.measured_on


def test_a_rig_has_the_units_of_its_map():
    env = el.EnvMap(HALL).calibrated(lux=1000)
    back = Lights.of(el.fit(env, lights=3)).rig(env)
    assert back.units == "cd/m2"
    assert back.error == pytest.approx(el.fit(env, lights=3).error, rel=1e-2)


def test_labels_are_a_batch_and_rows_are_rigs():
    rigs = [el.fit(HALL, lights=n, ambient=ambient) for n, ambient in ((1, "sh2"), (3, "constant"))]
    lights = Lights.of_labels(el.batches.label_arrays(rigs, lights=4))
    assert lights.ambient.shape == (2, 9, 3)
    for row, rig in enumerate(rigs):
        np.testing.assert_allclose(
            lights.row(row).rig().probe(NORMALS), rig.probe(NORMALS), rtol=1e-5
        )
    with pytest.raises(el.EnvLightsError, match=r"lights.row\(0\).rig"):
        lights.rig()
    with pytest.raises(el.EnvLightsError, match="irradiance must be finite, not negative"):
        lights.row(0)._replace(irradiance=-lights.irradiance[0]).rig()


def test_labels_above_a_floor_have_the_light_of_the_half_sky():
    rig = el.fit(HALL, lights=3, floor=True)
    lights = Lights.of_labels(el.batches.label_arrays([rig], lights=3)).row(0)
    np.testing.assert_allclose(probe(lights, NORMALS), rig.probe(NORMALS), rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("loss", [lighting_error, gloss_error])
def test_whole_numbers_are_lights_too(loss):
    """Terms of the map are not rounded to them."""
    sky = np.eye(9, 3, dtype=int)
    whole = Lights(np.array([[0, 1, 0]]), np.array([[3, 2, 1]]), np.array([1]), sky)
    terms, exact = map_terms(HALL, degree=96), in_library(whole, to_numpy64)
    assert float(loss(whole, terms)) == pytest.approx(float(loss(exact, terms)))
    np.testing.assert_array_equal(to_map(whole, 16), to_map(exact, 16))


def test_a_direction_of_length_0_makes_no_rig():
    lights = Lights(np.zeros((1, 3)), np.ones((1, 3)), np.zeros(1), np.ones(3))
    with pytest.raises(el.EnvLightsError, match="direction 0 has length 0"):
        lights.rig()


@in_each_library
@pytest.mark.parametrize("ambient", ["constant", "sh2"])
def test_the_map_has_the_flux_and_the_probe_of_the_lights(convert, ambient):
    lights = random_lights(4, batch=(2,), ambient=ambient)
    pixels = np.asarray(to_map(in_library(lights, convert), 64))
    solid_angles = el.kernels.pixel_solid_angles(64, 128)[..., None]
    mean = lights.ambient if ambient == "constant" else lights.ambient[:, 0] / np.sqrt(4 * np.pi)
    discs = lights.irradiance / np.cos(lights.angular_radius / 2)[..., None] ** 2
    np.testing.assert_allclose(
        (pixels * solid_angles).sum((1, 2)), discs.sum(1) + 4 * np.pi * mean, rtol=1e-5
    )
    irradiance = el.EnvMap(np.maximum(pixels[0], 0)).probe(NORMALS)
    np.testing.assert_allclose(irradiance, probe(lights.row(0), NORMALS), rtol=0.03)


def test_the_rim_of_a_disc_is_a_logistic_function_of_the_chord():
    """The logit of the radiance relative to the centre is linear, and 0 at the rim."""
    radius, pixel = 0.8, np.pi / 64
    lights = Lights(*map(np.array, ([[0.0, 1, 0]], [[1.0, 1, 1]], [radius], [0.0] * 3)))
    part = to_map(lights, 64)[:, 0, 0]
    part = part / part.max()
    assert (np.diff(part) <= 0).all()
    at_rim = np.abs(part - 0.5) < 0.49
    polar = (np.flatnonzero(at_rim) + 0.5) * pixel
    inside = np.sin(radius / 2) ** 2 - np.sin(polar / 2) ** 2
    logit = np.log(part[at_rim] / (1 - part[at_rim]))
    width = np.sin(np.hypot(radius, pixel)) * pixel / 4
    np.testing.assert_allclose(logit, inside / width, rtol=1e-5)
    assert len(logit) >= 4


@in_each_library
def test_gaussians_are_those_of_a_set_of_lights(convert):
    lights = random_lights(5)
    discs = lights.rig().lights.spherical_gaussians()
    ours = [np.asarray(each) for each in to_gaussians(in_library(lights, convert))]
    order = np.argsort(-lights.irradiance @ [0.2126, 0.7152, 0.0722])
    for one, other in zip(ours, (discs.amplitude, discs.axis, discs.sharpness), strict=True):
        np.testing.assert_allclose(one[order], other, rtol=1e-9)


def gaussians_loss(lights):
    lobes = to_gaussians(lights._replace(angular_radius=lights.angular_radius + 0.01))
    return (lobes.amplitude / lobes.sharpness[..., None] * lobes.direction).sum()


def matching_of_places(lights):
    """Loss in which the irradiance, and with it the plan, stays."""
    target = in_library(random_lights(99, lights=4), to_jax)
    return matching_loss(lights._replace(irradiance=to_jax(random_lights(9).irradiance)), target)


@pytest.mark.parametrize(
    "loss",
    [lambda lights: (to_map(lights, 16) ** 2).sum(), gaussians_loss, matching_of_places],
    ids=["map", "gaussians", "matching"],
)
def test_derivatives_are_differences(loss):
    pytest.importorskip("jax")
    for slope, difference in slopes_and_differences(loss, range(10), 1e-5):
        assert slope == pytest.approx(difference, rel=1e-6, abs=1e-6)


@in_each_library
def test_a_light_in_two_halves_matches_the_whole(convert):
    """Halves at 0.1 to either side are 2 - 2 cos 0.1 away; each gets half of the irradiance."""
    whole = Lights(*map(np.array, ([[0.0, 0, 1]], [[2.0, 4, 6]], [0.2], [0.0] * 3)))
    x, z = np.sin(0.1), np.cos(0.1)
    halves = Lights(
        np.array([[x, 0, z], [-x, 0, z]]),
        np.ones((2, 1)) * [1.0, 2, 3],
        np.full(2, 0.2),
        np.zeros(3),
    )
    pair = [in_library(each, convert) for each in (halves, whole)]
    assert float(matching_loss(*pair)) == pytest.approx(2 - 2 * z, rel=1e-9)
    assert float(matching_loss(pair[1], pair[1])) == pytest.approx(0, abs=1e-12)
    # The square of half, over the squares of half and of the whole.
    darker = pair[0]._replace(irradiance=pair[0].irradiance / 2)
    assert float(matching_loss(darker, pair[1])) == pytest.approx(2 - 2 * z + 0.2, rel=1e-9)


@in_each_library
def test_a_batch_is_matched_row_by_row_and_black_lights_are_far(convert):
    lights, target = random_lights(1, batch=(3,)), random_lights(2, lights=4, batch=(3,))
    lights = lights._replace(mask=np.array([[1.0] * 6, [1, 0, 0, 1, 1, 0], [0] * 6]))
    ours = np.asarray(matching_loss(in_library(lights, convert), in_library(target, convert)))
    rows = [float(matching_loss(lights.row(i), target.row(i))) for i in range(3)]
    np.testing.assert_allclose(ours, rows, rtol=1e-9)
    with pytest.raises(el.EnvLightsError, match="target must have the leading axes"):
        matching_loss(lights, target.row(0))


def test_a_change_of_exposure_changes_no_match():
    pair = random_lights(1), random_lights(2, lights=4)
    dim = [each._replace(irradiance=1e-3 * each.irradiance) for each in pair]
    assert float(matching_loss(*dim)) == pytest.approx(float(matching_loss(*pair)), rel=1e-9)


def test_lights_are_trees_of_arrays_and_map_over_batches():
    jax = pytest.importorskip("jax")
    lights = in_library(random_lights(1, batch=(3,)), to_jax)
    loss = lambda lights: (probe(lights, to_jax(NORMALS)) ** 2).mean()  # noqa: E731
    ours = jax.jit(jax.vmap(jax.grad(loss)))(lights)
    assert ours.direction.shape == (3, 6, 3)
    matched = jax.jit(jax.vmap(matching_loss))(lights, lights)
    np.testing.assert_allclose(matched, 0, atol=1e-12)
