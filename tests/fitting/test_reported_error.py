"""The error that a fit reports, against the probe of the map at other normals."""

import numpy as np
import pytest

import envlights as el

HEIGHTS = (2, 3, 4, 5, 7, 8, 12, 16, 21, 32, 48, 64, 100, 128)


def spiral(count):
    """Normals on a spiral from pole to pole, of equal weight."""
    place = np.arange(count) + 0.5
    height, turn = 1 - 2 * place / count, np.pi * (1 + 5**0.5) * place
    radius = np.sqrt(1 - height**2)
    return np.stack([radius * np.cos(turn), height, radius * np.sin(turn)], axis=-1)


NORMALS = spiral(5120)


def generated_map(seed):
    """A sky with one to four suns of a few pixels, many of them at the poles and at the seam."""
    rng = np.random.default_rng(seed)
    height = int(rng.choice(HEIGHTS))
    sky = rng.uniform(0.05, 1, 3) * (1 + rng.choice([0, 0.5]) * rng.random((height, 2 * height, 1)))
    radiance = np.broadcast_to(sky, (height, 2 * height, 3)).astype(np.float32)
    for _ in range(rng.integers(1, 5)):
        tall, wide = rng.integers(1, 4, 2)
        row = rng.choice([0, max(height - tall, 0), rng.integers(height)])
        column = rng.choice([0, 2 * height - 1, rng.integers(2 * height)])
        columns = (column + np.arange(wide)) % (2 * height)
        sun = 10 ** rng.uniform(0.5, 6) * rng.uniform(0.3, 1, 3)
        radiance[row : row + tall, columns] = sun
    return radiance


def assert_error_is_right(seed):
    env = el.EnvMap(generated_map(seed))
    rig = el.fit(env, (1, 2, 4, 8)[seed % 4])
    expected = env.probe(NORMALS)
    difference = np.square(rig.probe(NORMALS) - expected)
    error = np.sqrt(difference.sum() / np.square(expected).sum())
    channels = np.sqrt(difference.sum(axis=0) / np.square(expected).sum(axis=0))
    assert abs(rig.error - error) <= 0.01 * error + 1e-4
    np.testing.assert_allclose(rig.report.channel_errors, channels, rtol=0.01, atol=1e-4)


@pytest.mark.parametrize("start", range(0, 60, 10))
def test_the_error_is_that_of_other_normals(start):
    for seed in range(start, start + 10):
        assert_error_is_right(seed)


@pytest.mark.slow
@pytest.mark.parametrize("start", range(60, 500, 40))
def test_the_error_of_many_maps_is_that_of_other_normals(start):
    for seed in range(start, start + 40):
        assert_error_is_right(seed)


@pytest.mark.parametrize("start", range(0, 120, 20))
def test_the_shadow_error_of_a_small_map_is_that_of_its_harmonics(start):
    """Harmonics end at degree 100, where corners of bright pixels of 11 degrees leave 1e-3."""
    maps = {seed: generated_map(seed) for seed in range(start, start + 20)}
    for seed, radiance in maps.items():
        if not 4 <= len(radiance) <= 16:
            continue
        rig = el.fit(radiance, (1, 2, 4, 8)[seed % 4])
        repeats = 256 // len(radiance)
        fine = radiance.repeat(repeats, axis=0).repeat(repeats, axis=1)
        expected = el.compare(fine, rig).shadow_error
        assert rig.report.shadow_error == pytest.approx(expected, rel=0.02, abs=1e-3)
