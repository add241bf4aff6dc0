"""Pictures of 2:1 that are no panorama: two lenses, two eyes, and parts."""

import numpy as np
import pytest

import envlights as el
from envlights.environment.layouts import panorama_check
from envlights.kernels import pixel_directions
from tests.layouts.worlds import smooth
from tests.public_maps import public_maps, read
from tests.reference import srgb

N = 192


def world(directions):
    """A sky with structure in a hundredth to three times the mean, from unit vectors."""
    waves = np.random.default_rng(1).normal(size=(12, 3)) * 5
    values = 0.15 * np.exp(0.35 * np.sin(directions @ waves.T).sum(-1, keepdims=True) / 2)
    return values * np.array([0.8, 0.9, 1.1])


def panorama(height=N):
    return world(pixel_directions(height, 2 * height))


def lens(side, ahead, margin, cut):
    """Circle of 190 degrees in black; margin and cut are fractions of its radius."""
    at = (2 * np.arange(side) + 1) / side - 1
    x, y = np.meshgrid(at, -at)
    radius = np.hypot(x, y) * (1 + margin) * (1 - cut)
    angle, turn = radius * np.radians(95), np.arctan2(y, x)
    towards = [
        -ahead * np.cos(turn) * np.sin(angle),
        np.sin(turn) * np.sin(angle),
        ahead * np.cos(angle),
    ]
    return np.where((radius <= 1)[..., None], world(np.stack(towards, -1)), 0)


def lenses(margin=0.0, cut=0.0, side=N):
    return np.concatenate([lens(side, ahead, margin, cut) for ahead in (1, -1)], axis=1)


def eyes(kind, shift=2):
    whole = panorama(2 * N)
    one = {
        "halves": whole[::2, N : 3 * N : 1][:, ::1][:, : 2 * N : 2],
        "squeezed": whole[::2, ::4],
        "above": whole[::4, ::2],
    }[kind]
    return np.concatenate([one, np.roll(one, shift, axis=1)], axis=0 if kind == "above" else 1)


def codes(linear, noise=0.0):
    """8-bit sRGB codes with noise, as a camera has it."""
    values = 255 * srgb.encode(np.clip(linear, 0, 1))
    values += noise * np.random.default_rng(2).normal(size=values.shape)
    return np.clip(np.round(values), 0, 255).astype(np.uint8)


def doubts(picture, **options):
    notes = el.EnvMap(picture, **options).notes
    return [str(note) for note in notes if note.code == "layout-doubt"]


@pytest.mark.parametrize("noise", [0, 3])
@pytest.mark.parametrize("exposure", [0.3, 1])
@pytest.mark.parametrize(
    "shape", [{}, {"margin": 0.05}, {"margin": 0.15}, {"cut": 0.04}, {"margin": 0.06, "side": 256}]
)
def test_two_lenses_are_refused_or_noted(shape, exposure, noise):
    try:
        found = doubts(codes(exposure * lenses(**shape), noise))
    except el.EnvLightsError as refusal:
        found = [str(refusal)]
    assert "dual fisheye" in found[0]
    assert not doubts(codes(lenses(**shape)), layout="equirectangular")


@pytest.mark.parametrize("noise", [0, 2])
@pytest.mark.parametrize("kind", ["halves", "squeezed", "above"])
@pytest.mark.parametrize("shift", [0, 3])
def test_two_eyes_are_noted(kind, shift, noise):
    assert "two eyes" in doubts(codes(eyes(kind, shift), noise))[0]


def test_two_eyes_with_parallax_by_depth_are_noted():
    """The ground shifts more than the horizon."""
    one = panorama(N)[:, N // 2 : 3 * N // 2]
    top, bottom = (
        np.roll(half, by, axis=1) for half, by in zip((one[:96], one[96:]), (-6, 6), strict=True)
    )
    picture = np.concatenate([one, np.concatenate([top, bottom])], axis=1)
    assert "two eyes" in doubts(codes(picture, 2))[0]


@pytest.mark.parametrize("noise", [0, 3])
@pytest.mark.parametrize("margin", [0, 0.1])
def test_one_lens_between_black_sides_is_noted(margin, noise):
    sides = np.zeros((N, N // 2, 3))
    picture = np.concatenate([sides, lens(N, 1, margin, 0), sides], axis=1)
    assert "may be a fisheye picture" in doubts(codes(picture, noise))[0]
    part = np.concatenate([sides, panorama(N)[:, N // 2 : 3 * N // 2], sides], axis=1)
    assert not any("fisheye" in doubt for doubt in doubts(codes(part, noise)))


@pytest.mark.parametrize("part", [(48, 144, 40), (20, 170, 0), (80, 190, 100)])
@pytest.mark.parametrize("noise", [0, 3])
def test_a_part_of_a_panorama_is_noted(part, noise):
    first, last, left = part
    rows = last - first
    picture = panorama()[first:last, left : left + 2 * rows]
    assert "a part of one" in doubts(codes(picture, noise))[0]


@pytest.mark.parametrize("noise", [0, 3])
@pytest.mark.parametrize("turn", [0, 50, 150])
def test_a_panorama_has_no_doubt(noise, turn):
    assert not doubts(codes(np.roll(panorama(), turn, axis=1), noise))
    assert not doubts(np.roll(panorama(), turn, axis=1))


@public_maps()
def test_real_maps_have_no_doubt(path):
    radiance = read(path)
    for step in (1, 4):
        small = radiance[::step, ::step]
        assert not doubts(small.astype(np.float32))
        for quantile in (0.9, 0.99):
            assert not doubts(codes(small / np.quantile(small, quantile)))


def test_every_way_to_a_map_has_the_note(tmp_path):
    picture = codes(eyes("squeezed"))
    el.EnvMap(picture).to("equirectangular", width=2 * N)
    rig = el.fit(picture, 1)
    assert any("two eyes" in note for note in rig.notes)


def test_a_direction_that_nobody_gave_is_noted():
    square = smooth(pixel_directions(32, 32))
    layout = el.io.Layout.fisheye(mapping="equidistant", fov=180)
    given = el.io.Layout.fisheye(mapping="equidistant", fov=180, forward=(0, 0, 1))
    assert "was taken for the front" in doubts(square, layout=layout)[0]
    assert not doubts(square, layout=given)
    assert "was taken for the front" in doubts(square, layout=el.io.Layout.planar(fov=60))[0]


@pytest.mark.parametrize("number", [1, 2, 7, 10])
def test_the_median_is_that_of_numpy(number):
    cells = np.random.default_rng(number).random((number, 1))
    assert panorama_check._median(cells) == np.median(cells)
