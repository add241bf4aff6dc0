"""Detection as in Loghin (2021): each step against its own truth, all against the reference."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import envlights as el
from envlights import kernels
from envlights.synthetic import Disc, Rectangle, scene
from tests.conftest import real_maps
from tests.helpers import printed_by_threads
from tests.reference import loghin

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


OPTIONS = [
    {},
    {"move_to_maximum": True},
    {"sphere": True},
    {"sphere": True, "move_to_maximum": True, "merge_cap_deg": 20.0},
    {"merge_cap_deg": 20.0, "relative": True},
]


def assert_agrees_with_the_reference(radiance, options):
    """Same samples in the same order, same light for each, same directions."""
    width = radiance.shape[1]
    found = el.detect(radiance, method="article", working_width=width, **options)
    rest = {name: value for name, value in options.items() if name != "relative"}
    unit = found.report.threshold / 0.8
    kept, light, directions = loghin.detect(kernels.luminance(radiance), unit=unit, **rest)
    assert found.members.pixel.tolist() == [list(pixel) for pixel in kept]
    assert len(found) == len(directions)
    # Our lights are numbered by flux, those of the reference by their first sample.
    number = {home: found.members.light[home] for home in directions}
    assert found.members.light.tolist() == [number[home] for home in light]
    for home, wanted in directions.items():
        # The reference adds up in another order.
        np.testing.assert_allclose(found.direction[number[home]], wanted, atol=1e-12)


@pytest.mark.parametrize("options", OPTIONS, ids=" ".join)
@pytest.mark.parametrize("which", range(5))
def test_it_agrees_with_the_reference_on_synthetic_maps(which, options):
    assert_agrees_with_the_reference(list(some_maps())[which], options)


def lamps_before_noise():
    """No two pixels are alike, so that rounding decides nothing."""
    lamps = [Disc((1, 0.5, 0), 12, (3, 3, 3)), Rectangle((0, 0.2, 1), 30, 8, (1.4, 1.3, 1.3))]
    radiance = scene(256, background=[0.2] * 3, shapes=lamps).radiance
    noise = np.random.default_rng(6).uniform(0.9, 1.1, radiance.shape[:2])
    return (radiance * noise[..., None]).astype(np.float32)


@pytest.mark.parametrize("blur_px", [0.0, 1.0, 2.0])
@pytest.mark.parametrize("options", [OPTIONS[0], OPTIONS[1], OPTIONS[3]], ids=" ".join)
def test_reduction_and_blur_are_those_of_the_reference_from_end_to_end(blur_px, options):
    """Here the reference has its own steps 1 and 2, in float64."""
    radiance = lamps_before_noise()
    found = el.detect(radiance, method="article", working_width=200, blur_px=blur_px, **options)
    image = loghin.reduce_bilinear(radiance.astype(float) @ [0.2126, 0.7152, 0.0722], 200)
    if blur_px:
        image = loghin.blur(image, blur_px)
    kept, light, directions = loghin.detect(image, **options)
    assert len(found) == len(directions) > 0
    assert found.members.pixel.tolist() == [list(pixel) for pixel in kept]
    number = {home: found.members.light[home] for home in directions}
    assert found.members.light.tolist() == [number[home] for home in light]
    for home, wanted in directions.items():
        # The weights of the working image are float32.
        np.testing.assert_allclose(found.direction[number[home]], wanted, atol=1e-6)


@pytest.mark.parametrize("options", [OPTIONS[0], OPTIONS[3]], ids=" ".join)
@real_maps("hdr/*.hdr")
def test_it_agrees_with_the_reference_on_real_maps(path, options):
    radiance = el.EnvMap.open(path).radiance
    # The reference is slow: take every second pixel.
    assert_agrees_with_the_reference(np.ascontiguousarray(radiance[::2, ::2]), options)


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


def test_a_blur_is_that_of_scipy():
    ndimage = pytest.importorskip("scipy.ndimage")
    image = random_image(4)
    across = ndimage.gaussian_filter1d(image, 1.5, axis=1, mode="wrap", truncate=10 / 3)
    wanted = ndimage.gaussian_filter1d(across, 1.5, axis=0, mode="nearest", truncate=10 / 3)
    np.testing.assert_allclose(kernels.blur(image, 1.5), wanted, atol=2e-6)


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


@pytest.mark.parametrize("sphere", [False, True])
@pytest.mark.parametrize("reduction", ["bilinear", "area"])
def test_a_flat_top_at_the_maximum_is_clipped(reduction, sphere):
    """Both detectors agree, in the map's own pixels."""
    lamps = [Disc((1, 0.1, 0.1), 8.0, (9, 9, 9)), Disc((-1, 0.1, 0.1), 8.0, (0.9, 0.9, 0.9))]
    radiance = scene(512, background=[0.1] * 3, shapes=lamps).radiance
    options = {"method": "article", "reduction": reduction, "sphere": sphere, "working_width": 256}
    clipped = el.detect(np.minimum(radiance, 1), **options)
    assert clipped.is_clipped.tolist() == [True, False]
    assert clipped.direction[0] @ [1, 0, 0] > 0.9
    sun = radiance.copy()
    sun[300, 300] = 99.0
    assert not el.detect(sun, **options).is_clipped.any(), "the map is brighter elsewhere"


@pytest.mark.parametrize(("code", "lights"), [(231, 0), (232, 1)])
def test_a_threshold_of_0_8_is_the_code_231(code, lights):
    """Samples of 8 bits are decoded from sRGB before the steps see them."""
    picture = np.full((64, 128, 3), code, np.uint8)
    assert len(el.detect(picture, method="article")) == lights


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


@pytest.mark.parametrize("options", [{}, {"move_to_maximum": True, "sphere": True}])
@pytest.mark.parametrize("radius", [10, 25])
def test_the_irradiance_of_a_lamp_is_the_sum_over_its_samples(radius, options):
    """Also where samples move: a lamp does not shine from all places that see it."""
    one = scene(512, background=[0.05] * 3, shapes=[Disc((1, 0.2, 0.1), radius, (5, 4, 3))])
    found = el.detect(one.radiance, method="article", **options)
    wanted = one.lights
    np.testing.assert_allclose(found.flux.sum(axis=0), wanted.irradiance[0], rtol=0.12)
    # Samples beside it that see it may be lights of their own: the lamp itself comes first.
    cap = 2 * np.pi * (1 - np.cos(np.deg2rad(radius)))
    np.testing.assert_allclose(found.solid_angle[0], cap, rtol=0.12)


@pytest.mark.parametrize("exponent", [-20, 7, 20])
def test_relative_levels_follow_the_exposure(exponent):
    """A power of 2, so that nothing is rounded."""
    radiance = el.synthetic.hall(128).radiance
    options = {"method": "article", "relative": True}
    plain = el.detect(radiance, **options)
    scaled = el.detect(np.float32(2.0**exponent) * radiance, **options)
    assert len(plain) > 0
    np.testing.assert_array_equal(scaled.direction, plain.direction)
    np.testing.assert_array_equal(scaled.flux, 2.0**exponent * plain.flux)


@pytest.mark.parametrize("pixel", [(0, 0), (0, 90), (255, 300), (128, 0), (128, 511), (40, 0)])
def test_one_lit_pixel_is_found_where_it_is(pixel):
    """On the poles, on either side of the seam and at a corner."""
    radiance = np.zeros((256, 512, 3), np.float32)
    radiance[pixel] = 9.0
    options = {"move_to_maximum": True, "sphere": True, "window_px": 40}
    found = el.detect(radiance, method="article", **options)
    assert len(found) == 1
    uv = [[(pixel[1] + 0.5) / 512, (pixel[0] + 0.5) / 256]]
    np.testing.assert_allclose(found.direction, kernels.uv_to_direction(uv), atol=1e-12)
    assert found.elongation.tolist() == [1.0] or found.members.light.size > 1


def test_white_noise_costs_no_more_than_its_pairs_of_survivors():
    """Suppression leaves samples so far apart that few fit, however many there were."""
    image = random_image(7, 512, 1024)
    pixels = np.argwhere(image > 0.98)
    pixels = pixels[np.argsort(-image[tuple(pixels.T)], kind="stable")]
    survivors = np.unique(kernels.suppress(pixels, 14.0))
    # Discs of half the distance do not overlap; 0.91 of a plane is the densest that they pack.
    assert len(survivors) < 0.91 * (512 + 14) * (1024 + 14) / (np.pi * 7.0**2)


def test_any_number_of_threads_gives_the_same_bits():
    code = (
        "import numpy as np, envlights as el;"
        "radiance = 2 * np.random.default_rng(0).random((256, 512, 3), dtype=np.float32);"
        "options = dict(method='article', blur_px=1.0, sphere=True, working_width=300);"
        "found = el.detect(radiance, **options);"
        "print(found.direction.tobytes().hex(), found.members.light.tolist())"
    )
    assert len(printed_by_threads(code)) == 1


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
    assert np.isfinite(found.flux).all()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: kernels.neighbour_maximum(np.ones((4, 8)), [[4, 0]], 1), "row 4, column 0"),
        (lambda: kernels.neighbour_maximum(np.ones((4, 8)), [[0, -1]], 1), "column -1"),
        (lambda: kernels.neighbour_maximum(np.ones((0, 8)), [[0, 0]], 1), "at least one pixel"),
        (lambda: kernels.merge_along_lines(np.ones((4, 8)), [[0.5, 0]]), "whole numbers"),
        (
            lambda: kernels.neighbour_maximum([[0, np.nan]], [[0, 0]], 1),
            "row 0, column 1.*holds NaN",
        ),
        (
            lambda: kernels.neighbour_maximum([[0, 1], [2]], [[0, 0]], 1),
            "luminance must be an array",
        ),
        (lambda: kernels.merge_along_lines([[0, np.inf]], [[0, 0]]), "row 0, column 1.*holds inf"),
        (lambda: kernels.merge_along_lines([[0, 1]], [[0, 0]], points=[[0, 0], [1, 1]]), "got 2"),
        (lambda: kernels.bresenham_line((0, 0), (0, 2**40)), "shorter than 16777216 pixels"),
        (lambda: kernels.bresenham_line((0, -(2**63)), (0, 2**63 - 1)), "shorter than"),
        (lambda: kernels.resize_bilinear([[0, 1]], 2**31, 2**31), "up to 1073741824 pixels"),
        (lambda: kernels.resize_bilinear([[0, np.nan]], 1, 1), "column 1.*holds NaN"),
        (lambda: kernels.blur([[0, 1]], 1e300), "sigma must be from 0 to 2"),
        (lambda: kernels.luminance(np.full((2, 4, 3), np.nan)), "luminance of radiance"),
        (lambda: kernels.uv_to_pixel([[np.nan, 0]], 4, 8), "uv must be finite"),
        (lambda: kernels.uv_to_pixel([[0, 0, 0]], 4, 8), r"shape \(n, 2\)"),
        (lambda: kernels.weighted_means([[0, 0]], [-1], [0]), "weights must not be negative"),
        (
            lambda: kernels.weighted_means([[0, 0]], [1, 1], [0]),
            r"weights must have .* \(1\); got 2",
        ),
        (lambda: kernels.weighted_means([[0, 0]], [1], [0, 0]), r"light must have .* \(1\); got 2"),
        (lambda: kernels.weighted_means([[0, 0]], [1], [0.5]), "light must hold whole numbers"),
        (lambda: kernels.weighted_means([[0, 0]], [np.nan], [0]), "weights must be finite"),
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
