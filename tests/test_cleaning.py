"""Infinite and NaN samples: light beyond the format, and holes."""

import numpy as np
import pytest

import envlights as el

SUN = (slice(14, 18), slice(20, 24))


def world(sky, sun):
    array = np.full((64, 128, 3), sky, np.float64)
    array[SUN] = sun
    return array


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64])
@pytest.mark.parametrize("sky", [0.01, 0.1, 1.0, 30.0])
def test_an_infinite_sun_is_the_only_light_and_clipped(sky, dtype):
    env = el.EnvMap(world(sky, np.inf).astype(dtype))
    np.testing.assert_allclose(env.radiance[SUN], 65504, rtol=1e-6)
    assert env.clip_level == 65504
    lights = el.detect(env)
    assert len(lights) >= 1
    assert lights.is_clipped[0]
    assert abs(np.rad2deg(lights.azimuth[0]) - 61.9) < 3


def test_an_infinite_sun_is_above_samples_beyond_half_floats():
    array = world(0.1, np.inf)
    array[40, 40] = 1e6
    assert el.EnvMap(array).radiance[16, 22, 0] == 2e6
    array[40, 40] = 3e38
    assert el.EnvMap(array).radiance[16, 22, 0] >= 2.9e38


@pytest.mark.parametrize("halo", [(4, 2, 1), (1, 2, 4), (3, 3, 3), (5, 0, 0)])
def test_an_infinite_sun_has_the_hue_of_its_neighbours(halo):
    array = world(0.0, np.inf)
    array[13:19, 19:25][~np.isinf(array[13:19, 19:25])] = np.tile(halo, 20)
    sun = el.EnvMap(array).radiance[SUN]
    np.testing.assert_allclose(
        sun / 65504, np.broadcast_to(np.array(halo) / max(halo), sun.shape), rtol=1e-5
    )


@pytest.mark.parametrize("channel", [0, 1, 2])
def test_an_infinite_channel_keeps_the_others(channel):
    sun = np.array([600.0, 400.0, 200.0])
    sun[channel] = np.inf
    env = el.EnvMap(world(0.1, sun))
    wanted = np.where(np.isinf(sun), 65504, sun)
    np.testing.assert_allclose(env.radiance[16, 22], wanted)
    assert el.detect(env).is_clipped.tolist() == [True]


@pytest.mark.parametrize("place", [(16, 22), (0, 0), (63, 127), (30, 0)])
def test_nan_takes_the_mean_of_its_neighbours(place):
    array = world(0.25, 1000.0)
    array[place] = np.nan
    env = el.EnvMap(array)
    is_sun = place == (16, 22)
    np.testing.assert_allclose(env.radiance[place], 1000 if is_sun else 0.25)
    where = " in the brightest light" if is_sun else ""
    assert env.notes == (f"3 NaN samples{where} set to the mean of the neighbours",)


@pytest.mark.parametrize("place", [(16, 22), (0, 5), (63, 90), (30, 0), (30, 127), (0, 0)])
def test_all_eight_neighbours_count_once_also_across_the_seam(place):
    array = np.random.default_rng(5).uniform(0.1, 1, (64, 128, 3)).astype(np.float32)
    array[place] = np.nan
    around = np.pad(
        np.pad(array, ((0, 0), (1, 1), (0, 0)), "wrap"), ((1, 1), (0, 0), (0, 0)), "edge"
    )
    row, column = place
    square = around[row : row + 3, column : column + 3].reshape(9, 3)
    wanted = np.nanmean(square, axis=0, dtype=np.float64)
    np.testing.assert_allclose(el.EnvMap(array).radiance[place], wanted, rtol=1e-6)
