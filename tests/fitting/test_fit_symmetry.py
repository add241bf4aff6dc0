"""A map that is turned, mirrored or scaled has lights that are turned, mirrored and scaled."""

from functools import cache

import numpy as np
import pytest

import envlights as el
from envlights import kernels
from tests.conftest import real_maps
from tests.helpers import NORMALS, printed_by_threads
from tests.reference import cells

#: The probe under the map is looked up on the faces of a cube, which do not turn with the map but
#: at every quarter: lights move within what the table leaves out.
TURNED = 2e-3
#: Rounding alone.
EXACT = 1e-9


@cache
def maps(height):
    """Maps whose lights are well determined: four leave more than the error of the rendering."""
    hard = [el.synthetic.hard(seed, height).radiance for seed in el.synthetic.EVALUATION[:3]]
    return [el.synthetic.hall(height).radiance, *hard]


def by_place(lights):
    """The lights in an order of their own: equals may change places in the rig."""
    order = np.lexsort(lights.direction.round(4).T)
    return lights.direction[order], lights.irradiance[order]


def assert_same(rig, directions, wanted, atol):
    """`rig` has the lights of `wanted`, but in these `directions`."""
    moved = el.Lights(directions, wanted.lights.irradiance)
    for ours, theirs in zip(by_place(rig.lights), by_place(moved), strict=True):
        np.testing.assert_allclose(ours, theirs, atol=atol * max(np.abs(theirs).max(), 1))
    np.testing.assert_allclose(rig.ambient, wanted.ambient, rtol=100 * atol)
    # The normals that measure the error do not turn with the map.
    assert rig.error == pytest.approx(wanted.error, rel=2e-2)


def rotate_columns(directions, columns, width):
    """Directions after the map has moved to the right by that many columns."""
    angle = 2 * np.pi * columns / width
    sin, cos = np.sin(angle), np.cos(angle)
    return directions @ np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]])


@pytest.mark.parametrize(
    ("height", "columns"),
    [(128, 1), (128, 64), (128, 101), (256, 2), (256, 254), (512, 388), (512, 768)],
)
def test_turning_the_map_turns_the_lights(height, columns):
    """By any number of columns, or by whole cells of the working map where it is wider."""
    atol = EXACT if columns * 2 % height == 0 else TURNED
    for radiance in maps(height):
        one = el.fit(radiance, 4)
        rig = el.fit(np.roll(radiance, columns, axis=1), 4)
        assert_same(rig, rotate_columns(one.lights.direction, columns, 2 * height), one, atol)


@pytest.mark.parametrize("floor", [False, True])
def test_mirroring_the_map_mirrors_the_lights(floor):
    for radiance in maps(128):
        one, rig = (el.fit(each, 4, floor=floor) for each in (radiance, radiance[:, ::-1]))
        assert_same(rig, one.lights.direction * [-1, 1, 1], one, EXACT)


def test_turning_the_map_upside_down_turns_the_lights_upside_down():
    for radiance in maps(128):
        one, rig = el.fit(radiance, 4), el.fit(radiance[::-1], 4)
        assert_same(rig, one.lights.direction * [1, -1, 1], one, EXACT)


@pytest.mark.parametrize("scale", [2.0**-20, 2.0**30, 1e-6, 1e9])
@pytest.mark.parametrize("options", [{}, {"floor": True}])
def test_scaling_the_map_scales_the_lights(scale, options):
    """By a power of 2 to the bit; other factors round float32 samples anew, 6e-8 of each."""
    atol = 1e-7 if scale in (1e-6, 1e9) else EXACT
    for radiance in maps(128):
        one = el.fit(radiance, 4, sizes=False, **options)
        scaled = el.fit(radiance * np.float32(scale), 4, sizes=False, **options)
        lights = el.Lights(scaled.lights.direction, scaled.lights.irradiance / scale)
        for ours, theirs in zip(by_place(lights), by_place(one.lights), strict=True):
            np.testing.assert_allclose(ours, theirs, atol=10 * atol * max(theirs.max(), 1))
        np.testing.assert_allclose(scaled.ambient / scale, one.ambient, atol=10 * atol)
        assert scaled.error == pytest.approx(one.error, rel=max(1e-5, atol))


@pytest.mark.parametrize("scale", [2.0**-20, 2.0**30, 1e-6, 1e9])
def test_scaling_the_map_scales_what_lights_and_harmonics_give_together(scale):
    """A light and its opposite differ by harmonics of order 1, so rounding may turn one round."""
    for radiance in maps(128):
        one = el.fit(radiance, 4, ambient="sh2", sizes=False)
        scaled = el.fit(radiance * np.float32(scale), 4, ambient="sh2", sizes=False)
        wanted = one.probe(NORMALS)
        difference = scaled.probe(NORMALS) / scale - wanted
        assert np.abs(difference).max() < 1e-6 * wanted.max()
        assert scaled.error == pytest.approx(one.error, rel=1e-5)


@real_maps("hdr/*.hdr")
def test_real_maps_of_any_scale_have_the_same_lights(path):
    """To the bit, as powers of two round nothing: sizes, too."""
    env = el.EnvMap.open(path)
    for sizes in (False, True):
        one = el.fit(env, 8, sizes=sizes)
        for scale in (2.0**-20, 2.0**5, 2.0**20):
            scaled = el.fit(el.EnvMap(env.radiance * np.float32(scale)), 8, sizes=sizes)
            np.testing.assert_array_equal(scaled.lights.direction, one.lights.direction)
            np.testing.assert_array_equal(scaled.lights.angular_radius, one.lights.angular_radius)
            assert scaled.error == one.error


FIT_IN_EVERY_WAY = """
import envlights as el
for radiance in (el.synthetic.hall(256).radiance, el.synthetic.hard(1000, 512).radiance):
    for options in ({}, {"ambient": "sh2"}, {"floor": True}, {"error": 0.01}):
        rig = el.fit(radiance, None if "error" in options else 6, **options).to_dict()
        print(rig)
"""


def test_any_number_of_threads_gives_the_same_bits():
    assert len(printed_by_threads(FIT_IN_EVERY_WAY)) == 1


def hot_pixels(count, seed):
    """A black map with some bright pixels far apart, their directions and irradiances."""
    rng = np.random.default_rng(seed)
    towards = kernels.uniform_sphere((kernels.hammersley(count) + rng.random(2)) % 1)
    size = (256, 512)  # in smaller maps, a pixel is no point
    radiance = np.zeros((*size, 3), np.float32)
    rows = kernels.uv_to_pixel(kernels.direction_to_uv(towards), *size)
    radiance[tuple(rows.T)] = rng.uniform(1, 10, (count, 3))
    flux = radiance * kernels.pixel_solid_angles(*size)[..., None]
    directions = np.array([cells.mean_of_row(*pixel, *size) for pixel in rows])
    return radiance, el.Lights(directions, flux[tuple(rows.T)])


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("count", range(1, 13))
def test_hot_pixels_on_black_come_back(count, seed):
    radiance, lights = hot_pixels(count, seed)
    rig = el.fit(radiance, count, ambient="none", sizes=False)
    assert len(rig.lights) == count
    for ours, theirs in zip(by_place(rig.lights), by_place(lights), strict=True):
        np.testing.assert_allclose(ours, theirs, atol=1e-9)
    assert rig.report.stop_reason.is_success
