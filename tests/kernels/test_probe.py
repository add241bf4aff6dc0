"""The probe against closed forms, brute force, and a path tracer."""

import numpy as np
import pytest

import envlights as el
from envlights import kernels
from tests.helpers import printed_by_threads
from tests.reference import cells

NORMALS, SOLID_ANGLES = kernels.icosphere(320)


def sunny_map(height=1024, sun=5e4):
    """Noise in 22 stops: a gradient, blocks, and a sun of one pixel."""
    rng = np.random.default_rng(7)
    blocks = rng.gamma(0.5, 1.0, size=(height // 16, height // 8, 3))
    radiance = blocks.repeat(16, axis=0).repeat(16, axis=1).astype(np.float32)
    radiance[height // 3, height // 5] = sun
    return radiance


def brute_force(radiance):
    """Sum over the centres of all pixels, in float64, as equations 1 to 3 have it."""
    height, width, _ = radiance.shape
    return kernels.sum_over_sources(
        NORMALS,
        kernels.pixel_directions(height, width).reshape(-1, 3),
        radiance.reshape(-1, 3),
        kernels.pixel_solid_angles(height, width).ravel(),
    )


def relative_difference(received, wanted):
    return kernels.relative_rms(received, wanted, SOLID_ANGLES)


def test_intervals_agree_with_brute_force_under_a_sun():
    radiance = sunny_map()
    received = el.EnvMap(radiance).probe(NORMALS)
    assert relative_difference(received, brute_force(radiance)) < 1e-5


@pytest.mark.parametrize(
    ("height", "bound"), [(64, 1e-5), (256, 1e-6), (512, 3e-7), (1024, 1e-7), (2048, 1e-6)]
)
@pytest.mark.parametrize("registration", ["cell-centred", "border-sampled"])
def test_a_constant_sky_gives_pi(height, bound, registration):
    sky = np.full((height, 2 * height, 3), 0.25, np.float32)
    received = el.EnvMap(sky, layout=el.io.Layout(registration=registration)).probe(NORMALS)
    np.testing.assert_allclose(received, np.pi * 0.25, rtol=bound)


@pytest.mark.parametrize(
    ("row", "column"), [(0, 5), (63, 5), (20, 0), (20, 127), (32, 64), (40, 90)]
)
def test_one_pixel_gives_its_flux_times_the_cosine(row, column):
    radiance = np.zeros((64, 128, 3), np.float32)
    radiance[row, column] = 1000, 500, 250
    expected = NORMALS @ cells.vector_solid_angle(row, column, 64, 128)[:, None] * [1000, 500, 250]
    received = el.EnvMap(radiance).probe(NORMALS)
    # Only where the horizon cuts the pixel does its part behind it not count.
    cosine = NORMALS @ kernels.pixel_directions(64, 128)[row, column]
    clear = np.abs(cosine) > np.pi / 64
    np.testing.assert_allclose(received[clear], np.maximum(expected, 0)[clear], atol=1e-6)
    cut = received[~clear] - np.maximum(expected, 0)[~clear]
    assert (
        np.abs(cut).max(initial=0)
        <= np.pi / 64 * kernels.pixel_solid_angles(64, 128)[row, 0] * 1000
    )


@pytest.mark.parametrize("height", [2, 3, 4, 8, 16, 32])
@pytest.mark.parametrize("registration", ["cell-centred", "border-sampled"])
def test_small_maps_are_integrated_cell_by_cell(height, registration):
    """The worst normal was off by 2e-5, the error of four nodes where a horizon ends in a strip."""
    radiance = np.random.default_rng(0).gamma(0.3, 1, (height, 2 * height, 3)).astype(np.float32)
    received = el.EnvMap(radiance, layout=el.io.Layout(registration=registration)).probe(
        NORMALS[::4]
    )
    is_border = registration == "border-sampled"
    wanted = cells.irradiance(radiance, NORMALS[::4], border_sampled=is_border)
    np.testing.assert_allclose(received, wanted, rtol=1e-4)


def normals_behind(row, column, height, width):
    """The normals whose horizon lies before a pixel, all of it."""
    theta = np.linspace(row, row + 1, 33) * np.pi / height
    phi = np.linspace(column, column + 1, 33)[:, None] * 2 * np.pi / width
    x, z = np.sin(phi) * np.sin(theta), -np.cos(phi) * np.sin(theta)
    pixel = np.stack([x, np.cos(theta) + 0 * phi, z], axis=-1).reshape(-1, 3)
    # Between two of those points a pixel bulges by a part of the square of their distance.
    return NORMALS[(NORMALS @ pixel.T).max(axis=1) < -((np.pi / height / 32) ** 2)]


@pytest.mark.parametrize(
    ("height", "width"), [(2, 4), (3, 7), (8, 16), (16, 32), (64, 128), (65, 131), (256, 512)]
)
@pytest.mark.parametrize(("down", "across"), [(0, 0), (0.4, 0.3), (0.5, 0.99)])
def test_no_sun_shines_through_the_probe(height, width, down, across):
    """Behind a sun of 1e9 times the room, the room is right to 1e-6 of itself."""
    row, column = int(down * height), int(across * width)
    behind = normals_behind(row, column, height, width)
    room = np.ones((height, width, 3), np.float32)
    room[row, column] = 0
    sunny = room.copy()
    sunny[row, column] = 1e9, 1e3, 0
    received = kernels.irradiance(sunny, behind)
    np.testing.assert_allclose(received, kernels.irradiance(room, behind), rtol=1e-6)
    # A normal has the same irradiance without its opposite.
    alone = [kernels.irradiance(sunny, normal[None])[0] for normal in behind[:5]]
    np.testing.assert_allclose(alone, received[:5], rtol=1e-6)


def test_probes_on_both_sides_add_up_to_the_whole_sphere():
    """E(n) - E(-n) = n . F, the vector flux: the horizon drops out."""
    radiance = sunny_map(256)
    env = el.EnvMap(radiance)
    solid_angles = kernels.pixel_solid_angles(256, 512)[..., None]
    directions = kernels.pixel_directions(256, 512)
    flux = np.einsum("yxa,yxc->ac", directions, radiance * solid_angles)
    difference = env.probe(NORMALS) - env.probe(-NORMALS)
    np.testing.assert_allclose(difference, NORMALS @ flux, atol=1e-4 * np.abs(flux).max())


def test_border_sampled_maps_agree_with_their_own_brute_force():
    radiance = sunny_map(256, sun=50)
    received = el.EnvMap(radiance, layout=el.io.Layout(registration="border-sampled")).probe(
        NORMALS
    )
    expected = kernels.sum_over_sources(
        NORMALS,
        kernels.pixel_directions(256, 512, border_sampled=True).reshape(-1, 3),
        radiance.reshape(-1, 3),
        kernels.pixel_solid_angles(256, 512, border_sampled=True).ravel(),
    )
    # Half cells at the border hang on one side of their sample; brute force is off by O(h^2).
    assert relative_difference(received, expected) < 2e-4


def test_the_working_map_is_good_to_2e_4_even_under_a_sun():
    radiance = sunny_map(512)
    received, sources = kernels.working_irradiance(radiance, NORMALS)
    assert relative_difference(received, kernels.irradiance(radiance, NORMALS)) < 2e-4
    assert sources >= 1


PROBE_AND_FIT = """
import numpy as np, envlights as el
radiance = np.random.default_rng(3).gamma(0.3, 1.0, size=(256, 512, 3)).astype(np.float32)
radiance[60, 100] = 3e4
normals, _ = el.kernels.icosphere(320)
rig = el.fit(radiance, lights=3)
errors = np.array(list(rig.report.search_errors.values()))
found = [rig.ambient, rig.lights.direction, rig.lights.irradiance, errors]
# Of eight lights that are tried at once, two are needed: the tries are given up.
two = el.kernels.rig_irradiance(normals, [0, 0, 0], np.eye(3)[:2], [[3, 2, 1], [1, 2, 3]])
lights = el.fit_probe(normals, two, lights=8).lights
assert len(lights) == 2
found += [lights.direction, lights.irradiance]
discs = el.kernels.rig_irradiance(normals, [0, 0, 0], np.eye(3), np.eye(3), [0.1, 0.7, 1.4])
drawn = el.Lights(np.eye(3), np.eye(3), [0.1, 0.7, 1.4]).to_map(64).radiance
found += [discs, drawn]
for array in [el.EnvMap(radiance).probe(normals), *found]:
    print(array.tobytes().hex())
"""


def test_any_number_of_threads_gives_the_same_bits():
    (printed,) = printed_by_threads(PROBE_AND_FIT)
    assert len(printed) > 1000


def test_no_normals_give_no_irradiance():
    assert el.EnvMap(np.ones((2, 4, 3))).probe(np.zeros((0, 3))).shape == (0, 3)


@pytest.mark.parametrize(
    ("normals", "message"),
    [
        ([[0, 2, 0]], r"normal 0 has length 2; it must be a unit vector"),
        ([[0, np.nan, 0]], r"finite"),
        ([[[0, 1, 0]]], r"normals"),
        ([[0, 1]], r"\(n, 3\)"),
    ],
)
def test_bad_normals_are_refused(normals, message):
    with pytest.raises(el.EnvLightsError, match=message):
        el.EnvMap(np.ones((4, 8, 3))).probe(normals)


@pytest.mark.parametrize("given", [np.ndarray.tolist, lambda map: map.astype(">f4"), np.float64])
def test_kernels_take_maps_of_any_floats(given):
    map = np.random.default_rng(4).gamma(0.3, size=(8, 16, 3)).astype(np.float32)
    up = [[0, 1, 0]]
    for kernel in (
        lambda radiance: kernels.irradiance(radiance, up),
        lambda radiance: kernels.working_irradiance(radiance, up)[0],
        lambda radiance: kernels.reduced_luminance(radiance, 8),
    ):
        np.testing.assert_array_equal(kernel(given(map)), kernel(map))
