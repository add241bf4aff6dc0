"""Single steps of Loghin (2021): windows, lines, suppression, means."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from envlights import kernels
from tests.reference import loghin

PIXEL = st.tuples(st.integers(-40, 40), st.integers(-40, 40))


def random_image(seed, height=60, width=120):
    return np.random.default_rng(seed).random((height, width), dtype=np.float32)


@pytest.mark.parametrize("reach", [0, 1, 2, 6, 59, 60, 500])
def test_the_neighbour_maximum_is_that_of_scipy(reach):
    ndimage = pytest.importorskip("scipy.ndimage")
    image = random_image(1)
    pixels = np.argwhere(np.ones_like(image, dtype=bool))
    found, place = kernels.neighbour_maximum(image, pixels, reach)
    wanted = ndimage.maximum_filter(image, 2 * reach + 1, mode="constant", cval=-1)
    np.testing.assert_array_equal(found, wanted.ravel())
    np.testing.assert_array_equal(image[place[:, 0], place[:, 1]], found)


@given(
    size=st.tuples(st.integers(1, 12), st.integers(1, 16)),
    reach=st.integers(0, 18),
    levels=st.integers(1, 5),
    pixels=st.sampled_from([1, 3000]),
    sphere=st.booleans(),
)
def test_of_equal_neighbours_the_first_counts(size, reach, levels, pixels, sphere):
    """Windows are read one by one for a few pixels; for many, maxima run along the image."""
    rng = np.random.default_rng(levels)
    image = rng.integers(0, levels, size).astype(np.float32)
    pixels = rng.integers(0, size, (pixels, 2))
    found, place = kernels.neighbour_maximum(image, pixels, reach, sphere=sphere)
    answers = dict(zip(map(tuple, pixels.tolist()), zip(found, place, strict=True), strict=True))
    for pixel, (value, at) in answers.items():
        wanted = loghin.brightest_around(image, pixel, reach, sphere)
        assert (value, tuple(at)) == wanted


def test_on_the_sphere_the_window_crosses_the_seam_and_spans_the_pole_row():
    image = np.zeros((64, 128), np.float32)
    image[0, 70] = 1
    image[32, 127] = 2
    found, place = kernels.neighbour_maximum(image, [[0, 3], [32, 1], [32, 3]], 2, sphere=True)
    assert found.tolist() == [1, 2, 0]
    assert place[:2].tolist() == [[0, 70], [32, 127]]


@given(PIXEL, PIXEL)
def test_a_line_is_that_of_the_reference(start, end):
    assert kernels.bresenham_line(start, end).tolist() == [list(p) for p in loghin.line(start, end)]


@given(PIXEL, PIXEL)
def test_a_line_ends_where_asked_and_never_jumps(start, end):
    line = kernels.bresenham_line(start, end)
    assert line[0].tolist() == list(start)
    assert line[-1].tolist() == list(end)
    assert len(line) == 1 + max(abs(start[0] - end[0]), abs(start[1] - end[1]))
    assert np.abs(np.diff(line, axis=0)).max(initial=0) <= 1


@given(PIXEL, PIXEL)
def test_a_line_and_its_reverse_are_the_same_pixels(start, end):
    forth, back = kernels.bresenham_line(start, end), kernels.bresenham_line(end, start)
    assert forth.tolist() == back[::-1].tolist()


@given(PIXEL, PIXEL)
def test_a_line_is_that_of_scikit_image_but_for_ties(start, end):
    """Both stay within half a pixel of the straight line; only exact halves may differ."""
    draw = pytest.importorskip("skimage.draw")
    ours = kernels.bresenham_line(start, end)
    theirs = np.stack(draw.line(*start, *end), axis=1)
    rows, columns = end[0] - start[0], end[1] - start[1]
    long = int(abs(columns) >= abs(rows))
    length, side = abs((rows, columns)[long]), (rows, columns)[1 - long]
    step = np.arange(length + 1)
    is_tie = (2 * abs(side) * step) % max(2 * length, 1) == length if length else step > 0
    np.testing.assert_array_equal(ours[~is_tie], theirs[~is_tie])


@pytest.mark.parametrize("dimensions", [2, 3])
def test_suppression_is_that_of_all_pairs(dimensions):
    points = np.random.default_rng(2).random((500, dimensions))
    labels = np.full(500, -1)
    for i, point in enumerate(points):
        if labels[i] == -1:
            near = np.linalg.norm(points - point, axis=1) < 0.12
            labels[near & (labels == -1)] = i
    np.testing.assert_array_equal(kernels.suppress(points, 0.12), labels)


def test_suppression_of_many_points_within_a_tiny_distance_takes_no_time():
    """Cells so small that their numbers are beyond whole ones: as one, they took minutes."""
    points = np.random.default_rng(0).random((50000, 2))
    points[-1] = points[0]
    survivor = kernels.suppress(points, 1e-25)
    assert survivor[-1] == 0
    np.testing.assert_array_equal(survivor[:-1], np.arange(49999))


def test_a_dark_gap_parts_what_a_bright_line_joins():
    image = np.zeros((8, 40), np.float32)
    image[4, 2:18] = image[4, 24:30] = 0.9
    found = kernels.merge_along_lines(image, [[4, 3], [4, 15], [4, 26]])
    assert found.tolist() == [0, 0, 2]


def test_a_cap_parts_what_is_far():
    image = np.ones((8, 40), np.float32)
    pixels = [[4, 0], [4, 10], [4, 30]]
    assert kernels.merge_along_lines(image, pixels).tolist() == [0, 0, 0]
    assert kernels.merge_along_lines(image, pixels, farthest=10).tolist() == [0, 0, 2]


def test_on_the_sphere_a_line_crosses_the_seam():
    image = np.zeros((8, 40), np.float32)
    image[4, :4] = image[4, 36:] = 0.9
    pixels = [[4, 2], [4, 37]]
    assert kernels.merge_along_lines(image, pixels).tolist() == [0, 1]
    assert kernels.merge_along_lines(image, pixels, sphere=True).tolist() == [0, 0]


def test_luminance_and_a_resize_of_a_ramp_are_exact():
    ramp = np.arange(64, dtype=np.float32)[:, None] * np.ones(128, np.float32)
    small = kernels.resize_bilinear(ramp, 16, 32)
    np.testing.assert_allclose(small[:, 0], 4 * np.arange(16) + 1.5, rtol=1e-6)
    rgb = np.random.default_rng(0).random((4, 8, 3), dtype=np.float32)
    np.testing.assert_allclose(kernels.luminance(rgb), rgb @ [0.2126, 0.7152, 0.0722], rtol=1e-6)


@pytest.mark.parametrize(("wrap", "mode"), [(False, "nearest"), (True, "wrap")])
def test_a_blur_is_that_of_scipy(wrap, mode):
    ndimage = pytest.importorskip("scipy.ndimage")
    image = random_image(4)
    across = ndimage.gaussian_filter1d(image, 1.5, axis=1, mode=mode, truncate=10 / 3)
    wanted = ndimage.gaussian_filter1d(across, 1.5, axis=0, mode="nearest", truncate=10 / 3)
    np.testing.assert_allclose(kernels.blur(image, 1.5, wrap=wrap), wanted, atol=2e-6)


@pytest.mark.parametrize("wrap", [False, True])
def test_a_resize_at_the_border_mixes_with_the_other_side_only_if_it_wraps(wrap):
    """An impulse in the last column, in closed form: three quarters and one quarter."""
    image = np.zeros((1, 8), np.float32)
    image[0, -1] = 1.0
    wanted = np.zeros(16)
    wanted[13:] = 0.25, 0.75, 0.75 if wrap else 1.0
    wanted[0] = 0.25 if wrap else 0.0
    np.testing.assert_allclose(kernels.resize_bilinear(image, 1, 16, wrap=wrap)[0], wanted)


def test_pixels_are_those_of_numpy():
    """To the bit, also on the borders of pixels and beyond the image."""
    rng = np.random.default_rng(3)
    borders = np.stack([rng.integers(0, 81, 500) / 80, rng.integers(0, 61, 500) / 60], axis=1)
    uv = np.concatenate([rng.uniform(-0.5, 1.5, (500, 2)), borders])
    wanted = np.clip(np.floor(uv[:, ::-1] * [60, 80] + 1e-9), 0, [59, 79])
    np.testing.assert_array_equal(kernels.uv_to_pixel(uv, 60, 80), wanted)


@pytest.mark.parametrize("axes", [1, 2, 3])
def test_weighted_means_are_those_of_numpy(axes):
    """To the bit, with lights in any order, weights of 0 and lights of no weight at all."""
    rng = np.random.default_rng(axes)
    points, weights = rng.normal(size=(999, axes)), rng.random(999) * (rng.random(999) < 0.8)
    light = 7 * rng.integers(-20, 20, 999)
    weights[light == 14] = 0.0
    which = np.unique(light, return_inverse=True)[1]
    weights_or_one = np.where(np.bincount(which, weights)[which] > 0, weights, 1.0)
    sums = [np.bincount(which, weights_or_one * axis) for axis in points.T]
    wanted = np.stack(sums, axis=1) / np.bincount(which, weights_or_one)[:, None]
    np.testing.assert_array_equal(kernels.weighted_means(points, weights, light), wanted)
    assert kernels.weighted_means(np.zeros((0, axes)), [], []).shape == (0, axes)


def test_white_noise_costs_no_more_than_its_pairs_of_survivors():
    """Suppression leaves samples so far apart that few fit, however many there were."""
    image = random_image(7, 512, 1024)
    pixels = np.argwhere(image > 0.98)
    pixels = pixels[np.argsort(-image[tuple(pixels.T)], kind="stable")]
    survivors = np.unique(kernels.suppress(pixels, 14.0))
    # Discs of half the distance do not overlap; 0.91 of a plane is the densest that they pack.
    assert len(survivors) < 0.91 * (512 + 14) * (1024 + 14) / (np.pi * 7.0**2)
