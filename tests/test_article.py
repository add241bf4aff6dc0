"""Detection as in Loghin (2021): each step against its own truth, all of them against the twin."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import envlights as el
from envlights import kernels
from envlights.synthetic import Disc, Rectangle, scene
from tests.conftest import real_maps
from tests.twins import loghin

PIXEL = st.tuples(st.integers(-40, 40), st.integers(-40, 40))


def random_image(seed, height=60, width=120):
    return np.random.default_rng(seed).random((height, width), dtype=np.float32)


def some_maps():
    lamps = [Disc((1, 0.5, 0), 6, (3, 3, 3)), Rectangle((0, 0.2, 1), 30, 4, (1.1, 1, 1))]
    yield scene(128, background=[0.2] * 3, shapes=lamps).radiance
    yield scene(128, background=[0.1] * 3, shapes=[Disc((0, 0, -1), 9, (2, 2, 2))]).radiance  # seam
    yield scene(128, background=[0.1] * 3, shapes=[Disc((0, 1, 0), 9, (2, 2, 2))]).radiance  # pole
    yield np.random.default_rng(5).random((96, 192, 3), dtype=np.float32)
    yield el.synthetic.hall(128).radiance


def assert_agrees_with_the_twin(radiance):
    """Same samples in the same order, same light for each, same places."""
    image = kernels.luminance(radiance)
    kept, light, means = loghin.detect(image)
    found = el.detect(radiance, method="article", working_width=radiance.shape[1])
    assert found.members.pixel.tolist() == [list(pixel) for pixel in kept]
    assert len(found) == len(means)
    # Lights are numbered by flux; the twin's by their first sample.
    number = {home: found.members.light[home] for home in means}
    assert found.members.light.tolist() == [number[home] for home in light]
    height, width = image.shape
    for home, (row, column) in means.items():
        uv = [[(column + 0.5) / width, (row + 0.5) / height]]
        wanted = kernels.uv_to_direction(uv)[0]
        # The twin adds up in another order.
        np.testing.assert_allclose(found.direction[number[home]], wanted, atol=1e-12)


@pytest.mark.parametrize("which", range(5))
def test_it_agrees_with_the_twin_on_synthetic_maps(which):
    assert_agrees_with_the_twin(list(some_maps())[which])


@real_maps("hdr/*.hdr")
def test_it_agrees_with_the_twin_on_real_maps(path):
    radiance = el.EnvMap.open(path).radiance
    # The twin is slow: every fourth pixel of the real thing.
    assert_agrees_with_the_twin(np.ascontiguousarray(radiance[::4, ::4]))


def test_samples_are_those_of_scipy():
    qmc = pytest.importorskip("scipy.stats.qmc")
    van_der_corput = qmc.Halton(1, scramble=False).random(3145)[:, 0]
    np.testing.assert_allclose(kernels.hammersley(3145)[:, 1], van_der_corput, atol=1e-15)
    halton = qmc.Halton(2, scramble=False).random(3145)
    np.testing.assert_allclose(kernels.halton(3145), halton, atol=1e-15)


@pytest.mark.parametrize("reach", [0, 1, 6])
def test_the_neighbour_maximum_is_that_of_scipy(reach):
    ndimage = pytest.importorskip("scipy.ndimage")
    image = random_image(1)
    pixels = np.argwhere(np.ones_like(image, dtype=bool))
    found, place = kernels.neighbour_maximum(image, pixels, reach)
    wanted = ndimage.maximum_filter(image, 2 * reach + 1, mode="constant", cval=-1)
    np.testing.assert_array_equal(found, wanted.ravel())
    np.testing.assert_array_equal(image[place[:, 0], place[:, 1]], found)


def test_on_the_sphere_the_window_crosses_the_seam_and_spans_the_pole_row():
    image = np.zeros((64, 128), np.float32)
    image[0, 70] = 1
    image[32, 127] = 2
    found, place = kernels.neighbour_maximum(image, [[0, 3], [32, 1], [32, 3]], 2, sphere=True)
    assert found.tolist() == [1, 2, 0]
    assert place[:2].tolist() == [[0, 70], [32, 127]]


@given(PIXEL, PIXEL)
def test_a_line_is_the_twins(start, end):
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
    points = np.random.default_rng(2).random((300, dimensions))
    labels = np.full(300, -1)
    for i, point in enumerate(points):
        if labels[i] == -1:
            near = np.linalg.norm(points - point, axis=1) < 0.12
            labels[near & (labels == -1)] = i
    np.testing.assert_array_equal(kernels.suppress(points, 0.12), labels)


def test_survivors_are_far_apart_and_cover_the_rest():
    points = np.random.default_rng(3).random((500, 2))
    survivor = kernels.suppress(points, 0.1)
    survivors = points[np.unique(survivor)]
    apart = np.linalg.norm(survivors[:, None] - survivors, axis=2)
    assert apart[~np.eye(len(survivors), dtype=bool)].min() >= 0.1
    assert np.linalg.norm(points - points[survivor], axis=1).max() < 0.1


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


def test_a_blur_is_that_of_scipy():
    ndimage = pytest.importorskip("scipy.ndimage")
    image = random_image(4)
    across = ndimage.gaussian_filter1d(image, 1.5, axis=1, mode="wrap", truncate=10 / 3)
    wanted = ndimage.gaussian_filter1d(across, 1.5, axis=0, mode="nearest", truncate=10 / 3)
    np.testing.assert_allclose(kernels.blur(image, 1.5), wanted, atol=2e-6)


def test_the_improvements_find_what_the_article_misses():
    """Exposure, seam and place of the maximum: the three largest losses of the article."""
    lamp = Disc((0, 0.1, -1), 1.5, (60, 60, 60))
    dim = scene(512, background=[0.1] * 3, shapes=[lamp])
    radiance = (1e-3 * dim.radiance).astype(np.float32)
    assert len(el.detect(radiance, method="article")) == 0
    options = {"relative": True, "move_to_maximum": True, "sphere": True, "reduction": "area"}
    found = el.detect(radiance, method="article", **options)
    assert len(found) == 1
    angle = np.rad2deg(np.arccos(found.direction[0] @ dim.lights.direction[0]))
    assert angle < 1.5, f"{angle} degrees off a lamp of 1.5 degrees"


@pytest.mark.parametrize("options", [{}, {"sphere": True, "move_to_maximum": True}])
@pytest.mark.parametrize(
    ("radiance", "count"),
    [
        (np.zeros((64, 128, 3)), 0),
        (np.full((64, 128, 3), 0.5), 0),
        (np.full((64, 128, 3), 2.0), 1),
        (np.full((2, 4, 3), 2.0), 0),  # no sample fits on so few pixels
    ],
)
def test_worst_cases_are_answered(radiance, count, options):
    found = el.detect(radiance, method="article", **options)
    assert len(found) == count
    assert np.isfinite(found.direction).all()
    assert np.isfinite(found.irradiance).all()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: kernels.neighbour_maximum(np.ones((4, 8)), [[4, 0]], 1), "row 4, column 0"),
        (lambda: kernels.neighbour_maximum(np.ones((4, 8)), [[0, -1]], 1), "column -1"),
        (lambda: kernels.neighbour_maximum(np.ones((0, 8)), [[0, 0]], 1), "at least one pixel"),
        (lambda: kernels.merge_along_lines(np.ones((4, 8)), [[0.5, 0]]), "whole numbers"),
        (lambda: kernels.suppress([[np.nan, 0]], 1), "points must be finite"),
        (lambda: kernels.suppress([[1, 2, 3, 4]], 1), r"\(n, 2\)"),
        (lambda: kernels.luminance(np.ones((4, 8))), "3 axes"),
        (lambda: el.detect(np.ones((4, 8, 3)), method="x"), "'tree' or 'article'"),
        (lambda: el.detect(np.ones((4, 8, 3)), method="article", reduction="x"), "'bilinear'"),
        (lambda: el.detect(np.ones((4, 8, 3)), method="article", threshold=-1), "threshold"),
    ],
)
def test_bad_input_is_refused_by_name(call, message):
    with pytest.raises(el.EnvLightsError, match=message):
        call()
