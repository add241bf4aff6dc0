"""Harmonics of maps against closed forms, and against the formulas of other programs."""

import numpy as np
import pytest

import envlights as el
from envlights import kernels
from envlights.environment.harmonics import _PROGRAMS, FACTORS
from envlights.export import AXES

RNG = np.random.default_rng(5)
NORMALS = (lambda v: v / np.linalg.norm(v, axis=1, keepdims=True))(RNG.normal(size=(40, 3)))


@pytest.fixture(scope="module")
def env():
    return el.EnvMap(RNG.uniform(size=(8, 16, 3)).astype(np.float32))


def irradiance(env):
    """Irradiance of orders 0 to 2 at the normals, by the compiled harmonics."""
    return kernels.harmonic_irradiance(NORMALS) @ env.harmonics()


def axes_of(program):
    """Normals in the axes of a program, as x, y and z."""
    return AXES[program].to_target(NORMALS).T[..., None]


def test_a_uniform_map_has_only_the_first_harmonic():
    first, *others = el.EnvMap(np.full((10, 20, 3), 2.0)).harmonics()
    np.testing.assert_allclose(first, 2 * np.sqrt(4 * np.pi))
    np.testing.assert_allclose(others, 0, atol=1e-12)


def test_the_integral_is_that_of_many_small_pixels(env):
    fine = el.EnvMap(env.radiance.repeat(64, axis=0).repeat(64, axis=1))
    centres = kernels.pixel_directions(fine.height, fine.width).reshape(-1, 3)
    angles = kernels.pixel_solid_angles(fine.height, fine.width).reshape(-1, 1)
    sums = kernels.harmonic_radiance(centres).T @ (angles * fine.radiance.reshape(-1, 3))
    np.testing.assert_allclose(env.harmonics(), sums, atol=2e-4)


@pytest.mark.parametrize("registration", ["cell-centred", "border-sampled"])
def test_the_first_harmonic_of_a_pixel_is_its_solid_angle(registration):
    is_border = registration == "border-sampled"
    angles = kernels.pixel_solid_angles(6, 12, border_sampled=is_border)
    for row, column in ((0, 0), (2, 11), (5, 3)):
        radiance = np.zeros((6, 12, 3))
        radiance[row, column] = 1
        env = el.EnvMap(radiance, layout=el.io.Layout(registration=registration))
        first = np.sqrt(1 / (4 * np.pi)) * angles[row, column]
        np.testing.assert_allclose(env.harmonics(0)[0], first, rtol=1e-12)


def test_harmonics_turn_with_the_map():
    env = el.EnvMap(el.synthetic.hall(128).radiance)
    turn = np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]])
    x, z = 3, 2
    np.testing.assert_allclose(env.rotated(turn).harmonics(1)[x], env.harmonics(1)[z], rtol=1e-3)


def test_the_irradiance_is_that_of_the_constants_of_ramamoorthi_and_hanrahan(env):
    """Equation 13 of the paper of 2001."""
    c1, c2, c3, c4, c5 = 0.429043, 0.511664, 0.743125, 0.886227, 0.247708
    x, y, z = NORMALS.T[..., None]
    l00, l1m1, l10, l11, l2m2, l2m1, l20, l21, l22 = env.harmonics(convention="ramamoorthi")
    expected = c1 * l22 * (x**2 - y**2) + c3 * l20 * z**2 + c4 * l00 - c5 * l20
    expected += 2 * c1 * (l2m2 * x * y + l21 * x * z + l2m1 * y * z)
    expected += 2 * c2 * (l11 * x + l1m1 * y + l10 * z)
    np.testing.assert_allclose(irradiance(env), expected, rtol=1e-5, atol=1e-5)


def test_the_irradiance_is_that_of_the_shader_of_three(env):
    """`shGetIrradianceAt` of three.js."""
    x, y, z = axes_of("three")
    sh = env.harmonics(convention="three")
    expected = sh[0] * 0.886227 + sh[1] * 2.0 * 0.511664 * y + sh[2] * 2.0 * 0.511664 * z
    expected += sh[3] * 2.0 * 0.511664 * x + sh[4] * 2.0 * 0.429043 * x * y
    expected += sh[5] * 2.0 * 0.429043 * y * z + sh[6] * (0.743125 * z * z - 0.247708)
    expected += sh[7] * 2.0 * 0.429043 * x * z + sh[8] * 0.429043 * (x * x - y * y)
    np.testing.assert_allclose(irradiance(env), expected, rtol=1e-5, atol=1e-5)


def test_the_irradiance_over_pi_is_that_of_the_shader_of_unity(env):
    """`ShadeSH9` with the constants that Unity packs from `SphericalHarmonicsL2`."""
    x, y, z = axes_of("unity")
    sh = env.harmonics(convention="unity")
    linear = sh[3] * x + sh[1] * y + sh[2] * z + (sh[0] - sh[6])
    quadratic = sh[4] * x * y + sh[5] * y * z + 3 * sh[6] * z * z + sh[7] * z * x
    expected = linear + quadratic + sh[8] * (x * x - y * y)
    np.testing.assert_allclose(irradiance(env) / np.pi, expected, rtol=1e-10)


def polynomials(x, y, z):
    """`Irradiance_SphericalHarmonics` of Filament and `computeEnvironmentIrradiance` of Babylon."""
    return [x**0, y, z, x, y * x, y * z, 3 * z * z - 1, z * x, x * x - y * y]


def test_the_irradiance_over_pi_is_that_of_the_shader_of_filament(env):
    """Its axes are those of glTF, which are ours."""
    sh = env.harmonics(convention="filament")
    expected = np.einsum("kni,kc->nc", polynomials(*NORMALS.T[..., None]), sh)
    np.testing.assert_allclose(irradiance(env) / np.pi, expected, rtol=1e-10)


def test_the_irradiance_over_pi_is_that_of_the_shader_of_babylon(env):
    """`SphericalHarmonics.preScaleForRendering` of Babylon.js, then its shader."""
    # Its importer of glTF scales z by -1 and turns by 180 degrees about y.
    x, y, z = (NORMALS * [-1, 1, 1]).T[..., None]
    basis = [1 / 4, -3 / 4, 3 / 4, -3 / 4, 15 / 4, -15 / 4, 5 / 16, -15 / 4, 15 / 16]
    scaled = np.sign(basis) * np.sqrt(np.abs(basis) / np.pi)
    sh = scaled[:, None] * env.harmonics(convention="babylon")
    expected = np.einsum("kni,kc->nc", polynomials(x, y, z), sh)
    np.testing.assert_allclose(irradiance(env) / np.pi, expected, rtol=1e-10)


@pytest.mark.parametrize("program", ["three", "unity"])
def test_the_axes_are_those_of_the_files(program):
    assert _PROGRAMS[program][0] == AXES[program].matrix


def test_the_factors_are_those_of_the_compiled_harmonics():
    x, y, z = NORMALS.T
    rows = [x**0, y, z, x, x * y, y * z, 3 * z * z - 1, x * z, x * x - y * y]
    np.testing.assert_allclose(kernels.harmonic_irradiance(NORMALS).T, FACTORS[:, None] * rows)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"degree": 3}, "degree must be a whole number up to 2; got 3"),
        ({"convention": "godot"}, "convention must be 'envlights' or"),
    ],
)
def test_unknown_harmonics_are_refused(env, options, message):
    with pytest.raises(el.EnvLightsError, match=message):
        env.harmonics(**options)
