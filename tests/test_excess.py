"""Radiance above a maximum as lights: closure, directions, regions."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import envlights as el
from envlights.kernels.image import LUMINANCE
from tests.helpers import NORMALS, angle_deg

REGISTRATIONS = ("cell-centred", "border-sampled")


def sky(height=32):
    return np.full((height, 2 * height, 3), 0.5, np.float32)


def integrals(env):
    """Flux of each channel, and vector irradiance of the luminance, by quadrature in each cell."""
    height, width = env.radiance.shape[:2]
    if env.is_border_sampled:
        edges = [np.r_[0, np.arange(n - 1) + 0.5, n - 1] / (n - 1) for n in (height, width)]
    else:
        edges = [np.arange(n + 1) / n for n in (height, width)]
    node, weight = np.polynomial.legendre.leggauss(8)
    theta, phi = (
        (low[:, None] * (1 - node) + high[:, None] * (1 + node)) / 2 * factor
        for (low, high), factor in zip(
            [(edge[:-1], edge[1:]) for edge in edges], (np.pi, 2 * np.pi), strict=True
        )
    )
    d_theta, d_phi = (
        np.diff(edge)[:, None] / 2 * weight * factor
        for edge, factor in zip(edges, (np.pi, 2 * np.pi), strict=True)
    )
    band = (np.sin(theta) * d_theta).sum(1)
    across, up = (
        (np.sin(theta) ** 2 * d_theta).sum(1),
        (np.sin(theta) * np.cos(theta) * d_theta).sum(1),
    )
    x, whole, z = (np.sin(phi) * d_phi).sum(1), d_phi.sum(1), (-np.cos(phi) * d_phi).sum(1)
    radiance = env.radiance.astype(float)
    luminance = radiance @ LUMINANCE
    vector = [across @ luminance @ x, up @ luminance @ whole, across @ luminance @ z]
    return np.einsum("hwc,h,w->c", radiance, band, whole), np.array(vector)


def flux_of(lights):
    """Flux of discs of uniform radiance: 2 pi (1 - cos a) L with E = pi sin^2 a L."""
    return 2 * lights.irradiance / (1 + np.cos(lights.angular_radius))[:, None]


@pytest.mark.parametrize("registration", REGISTRATIONS)
@given(seed=st.integers(0, 2**31), maximum=st.floats(0.6, 1e3), pixels=st.integers(1, 30))
def test_rest_and_lights_together_are_the_map(registration, seed, maximum, pixels):
    chance = np.random.default_rng(seed)
    radiance = sky()
    at = chance.integers(0, 32, pixels), chance.integers(0, 64, pixels)
    radiance[at] = chance.uniform(0, 1e4, (pixels, 3))
    env = el.EnvMap(radiance, layout=el.io.Layout(registration=registration))
    lights, rest = el.limit(env, maximum)
    assert rest.radiance.max() <= maximum
    np.testing.assert_array_equal(rest.radiance, np.minimum(env.radiance, rest.radiance.max()))
    (whole, vector), (flux, rest_vector) = integrals(env), integrals(rest)
    np.testing.assert_allclose(flux + flux_of(lights).sum(axis=0), whole, rtol=1e-12)
    together = rest_vector + lights.luminance @ lights.direction
    np.testing.assert_allclose(together, vector, atol=1e-12 * (whole @ LUMINANCE))


@pytest.mark.parametrize("registration", REGISTRATIONS)
def test_a_sun_of_one_colour_lights_as_before(registration):
    radiance = sky(64)
    radiance[20:22, 127] = radiance[20:22, 0] = np.array([3, 2, 1]) * 1e4
    env = el.EnvMap(radiance, layout=el.io.Layout(registration=registration))
    lights, rest = el.limit(env, 1.0)
    assert len(lights) == 1
    cosine = NORMALS @ lights.direction[0]
    # A surface that does not cut the sun, which covers 2 x 2 pixels.
    whole = np.abs(cosine) > np.sin(np.deg2rad(6))
    given = np.maximum(cosine, 0)[:, None] * lights.irradiance
    together = rest.probe(NORMALS) + given
    np.testing.assert_allclose(together[whole], env.probe(NORMALS)[whole], rtol=1e-6)


def test_regions_are_joined_across_the_seam_and_the_poles():
    radiance = sky()
    radiance[5, [0, 63]] = 9  # beside each other
    radiance[6, 1] = 9  # and below one, in the corner
    radiance[12, 0] = radiance[13, 63] = 4  # in the corner across the seam
    radiance[0, [10, 40]] = 8  # both touch the pole
    radiance[31, 7] = 7
    radiance[31, 9] = 7  # both touch the other pole
    radiance[20, 5] = 6
    radiance[20, 7] = 5
    lights, _ = el.limit(radiance, 1)
    assert len(lights) == 6
    assert angle_deg(lights.direction, [0, 1, 0]).min() < 1
    assert angle_deg(lights.direction, [0, -1, 0]).min() < 4


def test_a_snake_is_one_region():
    """Labels must travel along all of it."""
    radiance = sky()
    for row in range(2, 20, 2):
        radiance[row, 3:15] = 2
        radiance[row + 1, 3 if row % 4 else 14] = 2
    lights, _ = el.limit(radiance, 1)
    assert len(lights) == 1


def test_a_disc_has_its_size():
    radius = 10.0
    disc = el.synthetic.Disc((1, 0.5, 0.3), radius, (9, 9, 9))
    lights, rest = el.limit(el.synthetic.scene(512, background=[1] * 3, shapes=[disc]).radiance, 1)
    np.testing.assert_allclose(np.rad2deg(lights.angular_radius), radius, rtol=2e-3)
    np.testing.assert_array_equal(rest.radiance, 1)


def test_a_map_below_the_maximum_is_unchanged():
    env = el.EnvMap(sky(), notes="a note")
    lights, rest = el.limit(env, 0.5)
    assert (len(lights), rest, rest.notes) == (0, env, env.notes)


def test_notes_and_parts_of_the_sphere_are_kept():
    seen = np.ones((32, 64), np.float32)
    seen[16:] = 0
    radiance = sky() * seen[..., None]
    radiance[10, 9] = 70
    env = el.EnvMap(radiance, coverage=seen)
    _, rest = el.limit(env, 2)
    np.testing.assert_array_equal(rest.coverage, seen)
    assert not rest.radiance[16:].any()
    assert rest.notes == (*env.notes, "limited to 2: 15.1 % of the flux is in 1 light")
    _, rest = el.limit(np.where(radiance > 2, 1e6, radiance), 2)
    assert rest.notes[-1] == "limited to 2: 100 % of the flux is in 1 light"


def test_units_are_kept():
    radiance = sky()
    radiance[10, 9] = 70
    lights, rest = el.limit(el.EnvMap(radiance, units="cd/m2"), 2)
    assert (lights.units, rest.units) == ("cd/m2", "cd/m2")


def test_half_a_sphere_is_no_light():
    radiance = sky()
    radiance[:20] = 3
    with pytest.raises(el.EnvLightsError, match="wider than half of the sphere"):
        el.limit(radiance, 1)


def test_nothing_is_spread_to_unseen_pixels():
    seen = np.ones((32, 64), np.float32)
    seen[16:] = 0
    seen[15, :] = 0.5
    radiance = sky() * seen[..., None]
    radiance[14, 9] = 70
    env = el.EnvMap(radiance, coverage=seen)
    limited = env.limited(2)
    assert not limited.radiance[16:].any()
    assert limited.radiance[15].max() <= 1
    np.testing.assert_allclose(integrals(limited)[0], integrals(env)[0], rtol=1e-6)
    with pytest.raises(el.EnvLightsError, match="mean radiance of the map"):
        env.limited(0.6)


@pytest.mark.parametrize("take", [lambda env: el.limit(env, 1.0), el.split])
def test_what_remains_keeps_the_exposure_and_the_source_of_its_map(take):
    env = el.EnvMap(el.synthetic.hall(64).radiance)
    env._pixels = replace(env._pixels, ev100=11.0)
    rest = take(env).remainder
    assert (rest.ev100, rest.source, rest.units) == (11.0, env.source, env.units)
