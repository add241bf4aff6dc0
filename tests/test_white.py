"""Clip level of pictures of codes, by their own histogram."""

import numpy as np
import pytest

import envlights as el
from envlights import _native
from tests.reference import srgb


def picture(white, peak=30.0, shape=(128, 256)):
    """Codes of a sky with a glow around a sun, cut off at `white`, or smooth if `peak` is small."""
    directions = el.kernels.sphere.pixel_directions(*shape)
    sun = np.array([np.cos(0.6), 0.6, np.sin(0.6)])
    angle = np.degrees(np.arccos(np.clip(directions @ (sun / np.linalg.norm(sun)), -1, 1)))
    sky = 0.12 + 0.15 * (directions[..., 1] + 1) + peak * np.exp(-angle / 4)
    codes = np.minimum(np.round(255 * srgb.encode(np.clip(sky, 0, 1))), white).astype(np.uint8)
    return np.repeat(codes[..., None], 3, axis=2)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("white", [230, 235, 240, 245, 250])
def test_the_clip_level_is_where_the_picture_ends(white, dtype):
    codes = picture(white)
    env = el.EnvMap(codes.astype(dtype) * (1 if dtype == np.uint8 else 257))
    assert env.clip_level == pytest.approx(srgb.decode(white / 255), rel=1e-5)
    assert f"the picture is clipped at code {white} of 255, by its histogram" in env.notes
    assert env.clipped_fraction > 0
    assert el.detect(env).is_clipped.any()
    assert any("lower bound" in note for note in el.fit(env, lights=1).notes)
    assert "no pixel is clipped" not in env.repaired().notes[-1]


@pytest.mark.parametrize("white", [254, 255])
def test_full_range_is_as_ever(white):
    assert el.EnvMap(picture(white)).clip_level == 1.0


@pytest.mark.parametrize("peak", [0.1, 0.2, 0.3, 0.4])
def test_a_smooth_highlight_is_not_clipped(peak):
    codes = picture(255, peak)
    assert codes.max() < 250
    env = el.EnvMap(codes)
    assert env.clip_level == 1.0
    assert env.clipped_fraction == 0


def test_an_even_wall_is_not_clipped():
    codes = np.random.default_rng(0).normal(236, 5, (64, 128, 3)).clip(0, 255).astype(np.uint8)
    assert el.EnvMap(codes).clip_level == 1.0


def test_compression_spreads_the_spike():
    histogram = np.full(256, 1e-3)
    histogram[236:241] = [0.005, 0.015, 0.1, 0.015, 0.005]
    histogram[241:] = 1e-4
    assert _native.white_code(histogram) == 238
    assert _native.white_code(np.zeros(256)) is None
