"""Angle between the irradiance vectors of two maps."""

import numpy as np
import pytest
from scipy.integrate import dblquad
from scipy.spatial.transform import Rotation

import envlights as el
from envlights.kernels.image import LUMINANCE
from tests.conftest import real_maps
from tests.helpers import angle_deg

#: An axis that is none of the frame.
AXIS = np.array([1.0, 2.0, -1.5]) / np.linalg.norm([1.0, 2.0, -1.5])


def one_pixel(row, column, height=16):
    radiance = np.zeros((height, 2 * height, 3))
    radiance[row, column] = [1.0, 2.0, 3.0]
    return radiance


def irradiance_vector(env):
    """Unit vector along the irradiance vector: E(n) - E(-n) is its product with n."""
    axes = np.eye(3)
    vector = (env.probe(axes, fill="black") - env.probe(-axes, fill="black")) @ LUMINANCE
    return vector / np.linalg.norm(vector)


def about_the_pole(degrees):
    """Rotation that shifts a map to the right by that many degrees of azimuth."""
    return Rotation.from_rotvec([0, -np.deg2rad(degrees), 0]).as_matrix()


@pytest.mark.parametrize(("row", "column"), [(0, 0), (7, 31), (15, 12)])
def test_a_pixel_is_integrated_over_its_square(row, column):
    """The vector of one pixel by quadrature, between a map of that pixel and one of +y."""
    theta = np.pi * np.array([row, row + 1]) / 16
    phi = np.pi * np.array([column, column + 1]) / 16
    parts = [
        lambda t, p: np.sin(p) * np.sin(t) ** 2,
        lambda t, _: np.cos(t) * np.sin(t),
        lambda t, p: -np.cos(p) * np.sin(t) ** 2,
    ]
    vector = np.array([dblquad(part, *phi, *theta, epsabs=1e-13)[0] for part in parts])
    upper_half = np.repeat([1.0, 0.0], 8)[:, None, None] * np.ones((16, 32, 3))
    expected = angle_deg(vector / np.linalg.norm(vector), [0, 1, 0])
    assert el.comparison.vector_angle(one_pixel(row, column), upper_half) == pytest.approx(
        expected, abs=1e-9
    )


def test_a_pixel_and_its_neighbour_across_the_seam_are_a_column_apart():
    angle = el.comparison.vector_angle(one_pixel(8, 0), one_pixel(8, 31))
    assert angle == pytest.approx(
        el.comparison.vector_angle(one_pixel(8, 4), one_pixel(8, 5)), abs=1e-9
    )


def test_lamps_count_by_their_luminance():
    """A red and a green lamp of equal luminance, left and right of +z: the vector is between."""
    radiance = np.zeros((16, 32, 3))
    radiance[7:9, 12, 0], radiance[7:9, 19, 1] = 1 / LUMINANCE[0], 1 / LUMINANCE[1]
    between = np.zeros((16, 32, 3))
    between[7:9, 15:17] = 1.0
    assert el.comparison.vector_angle(radiance, between) == pytest.approx(0, abs=1e-5)


def test_brightness_and_size_of_the_maps_do_not_matter():
    hall = el.synthetic.hall(64).radiance
    enlarged = np.repeat(np.repeat(hall, 2, axis=0), 2, axis=1)
    assert el.comparison.vector_angle(hall, 3 * enlarged) == pytest.approx(0, abs=1e-5)


def test_border_sampled_maps_are_integrated_on_their_own_cells():
    """The first and the last column of such a map are halves of one cell on the seam."""
    radiance = np.zeros((8, 16, 3))
    radiance[3:5, [0, -1]] = 1.0
    border = el.EnvMap(radiance, layout=el.io.Layout(registration="border-sampled"))
    lamp = el.Lights([[0, 0, -1]], [[1, 1, 1]]).to_map(64)
    assert el.comparison.vector_angle(border, lamp) == pytest.approx(0, abs=1e-5)


@pytest.mark.parametrize("radiance", [np.zeros((8, 16, 3)), np.full((8, 16, 3), 0.3)])
def test_a_black_or_uniform_map_has_no_vector(radiance):
    assert el.comparison.vector_angle(radiance, one_pixel(3, 3)) is None
    assert el.comparison.vector_angle(one_pixel(3, 3), radiance) is None


@real_maps("hdr/*.hdr", "exr/*.exr", "ldr/*.png", all_quick=True)
def test_a_roll_of_a_real_map_turns_its_vector(path):
    env = el.EnvMap.open(path)
    vector = irradiance_vector(env)
    for columns in (1, env.width // 32, env.width // 2):
        rolled = env.with_radiance(np.roll(env.radiance, columns, axis=1), ())
        expected = angle_deg(vector, about_the_pole(360 * columns / env.width) @ vector)
        assert el.comparison.vector_angle(env, rolled) == pytest.approx(expected, abs=1e-5)


@real_maps("hdr/*.hdr", "exr/*.exr", "openexr_envmaps/Stage*LatLong.exr", "ldr/*.png")
def test_the_vector_of_a_real_map_turns_with_it(path):
    env = el.EnvMap.open(path)
    turn = Rotation.from_rotvec(np.deg2rad(20) * AXIS).as_matrix()
    vector = irradiance_vector(env)
    expected = angle_deg(vector, turn @ vector)
    assert el.comparison.vector_angle(env, env.rotated(turn)) == pytest.approx(expected, abs=0.02)
