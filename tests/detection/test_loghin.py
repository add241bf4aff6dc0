"""Detection as in Loghin (2021): each step against its own truth, all against the reference."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import envlights as el
from envlights import kernels
from envlights.papers.loghin import Settings
from envlights.synthetic import Disc, Rectangle, scene
from tests.conftest import real_maps
from tests.helpers import printed_by_threads
from tests.reference import loghin


@cache
def some_maps():
    return list(_some_maps())


def _some_maps():
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
    {"sampling": "halton"},
]


def assert_agrees_with_the_reference(radiance, options):
    """Same samples in the same order, same light for each, same directions."""
    width = radiance.shape[1]
    found = el.papers.loghin.detect(radiance, working_width=width, settings=Settings(**options))
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
    assert_agrees_with_the_reference(some_maps()[which], options)


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
    settings = Settings(blur_px=blur_px, **options)
    found = el.papers.loghin.detect(radiance, working_width=200, settings=settings)
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


@pytest.mark.parametrize("sphere", [False, True])
@pytest.mark.parametrize("reduction", ["bilinear", "area"])
def test_a_flat_top_at_the_maximum_is_clipped(reduction, sphere):
    """Both detectors agree, in the map's own pixels."""
    lamps = [Disc((1, 0.1, 0.1), 8.0, (9, 9, 9)), Disc((-1, 0.1, 0.1), 8.0, (0.9, 0.9, 0.9))]
    radiance = scene(512, background=[0.1] * 3, shapes=lamps).radiance
    options = {"settings": Settings(reduction=reduction, sphere=sphere), "working_width": 256}
    clipped = el.papers.loghin.detect(np.minimum(radiance, 1), **options)
    assert clipped.is_clipped.tolist() == [True, False]
    assert clipped.direction[0] @ [1, 0, 0] > 0.9
    sun = radiance.copy()
    sun[300, 300] = 99.0
    assert not el.papers.loghin.detect(sun, **options).is_clipped.any(), (
        "the map is brighter elsewhere"
    )


@pytest.mark.parametrize(("code", "lights"), [(231, 0), (232, 1)])
def test_a_threshold_of_0_8_is_the_code_231(code, lights):
    """Samples of 8 bits are decoded from sRGB before the steps see them."""
    picture = np.full((64, 128, 3), code, np.uint8)
    assert len(el.papers.loghin.detect(picture)) == lights


def test_the_improvements_find_what_the_article_misses():
    """Exposure, seam and place of the maximum: the three largest losses of the article."""
    lamp = Disc((0, 0.1, -1), 1.5, (60, 60, 60))
    dim = scene(512, background=[0.1] * 3, shapes=[lamp])
    radiance = (1e-3 * dim.radiance).astype(np.float32)
    assert len(el.papers.loghin.detect(radiance)) == 0
    settings = Settings(relative=True, move_to_maximum=True, sphere=True, reduction="area")
    found = el.papers.loghin.detect(radiance, settings=settings)
    assert len(found) == 1
    angle = np.rad2deg(np.arccos(found.direction[0] @ dim.lights.direction[0]))
    assert angle < 1.5, f"{angle} degrees off a lamp of 1.5 degrees"


@pytest.mark.parametrize("options", [{}, {"move_to_maximum": True, "sphere": True}])
@pytest.mark.parametrize("radius", [10, 25])
def test_the_irradiance_of_a_lamp_is_the_sum_over_its_samples(radius, options):
    """Also where samples move: a lamp does not shine from all places that see it."""
    one = scene(512, background=[0.05] * 3, shapes=[Disc((1, 0.2, 0.1), radius, (5, 4, 3))])
    found = el.papers.loghin.detect(one.radiance, settings=Settings(**options))
    wanted = one.lights
    np.testing.assert_allclose(found.flux.sum(axis=0), wanted.irradiance[0], rtol=0.12)
    # Samples beside it that see it may be lights of their own: the lamp itself comes first.
    cap = 2 * np.pi * (1 - np.cos(np.deg2rad(radius)))
    np.testing.assert_allclose(found.solid_angle[0], cap, rtol=0.12)


@pytest.mark.parametrize("exponent", [-20, 7, 20])
def test_relative_levels_follow_the_exposure(exponent):
    """A power of 2, so that nothing is rounded."""
    radiance = el.synthetic.hall(128).radiance
    plain, scaled = (
        el.papers.loghin.detect(np.float32(scale) * radiance, settings=Settings(relative=True))
        for scale in (1.0, 2.0**exponent)
    )
    assert len(plain) > 0
    np.testing.assert_array_equal(scaled.direction, plain.direction)
    np.testing.assert_array_equal(scaled.flux, 2.0**exponent * plain.flux)


@pytest.mark.parametrize("pixel", [(0, 0), (0, 90), (255, 300), (128, 0), (128, 511), (40, 0)])
def test_one_lit_pixel_is_found_where_it_is(pixel):
    """On the poles, on either side of the seam and at a corner."""
    radiance = np.zeros((256, 512, 3), np.float32)
    radiance[pixel] = 9.0
    settings = Settings(move_to_maximum=True, sphere=True, window_px=40)
    found = el.papers.loghin.detect(radiance, settings=settings)
    assert len(found) == 1
    uv = [[(pixel[1] + 0.5) / 512, (pixel[0] + 0.5) / 256]]
    np.testing.assert_allclose(found.direction, kernels.uv_to_direction(uv), atol=1e-12)
    assert found.elongation.tolist() == [1.0] or found.members.light.size > 1


def test_any_number_of_threads_gives_the_same_bits():
    code = (
        "import numpy as np, envlights as el;"
        "radiance = 2 * np.random.default_rng(0).random((256, 512, 3), dtype=np.float32);"
        "settings = el.papers.loghin.Settings(blur_px=1.0, sphere=True);"
        "found = el.papers.loghin.detect(radiance, working_width=300, settings=settings);"
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
    found = el.papers.loghin.detect(radiance, settings=Settings(**options))
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
        (lambda: Settings(reduction="x"), "'bilinear'"),
        (lambda: Settings(sampling="x"), "'hammersley' or 'halton'"),
        (lambda: Settings(threshold=-1), "threshold"),
        (lambda: Settings(blur_px=None), "blur_px"),
        (lambda: Settings(merge_cap_deg=181), "merge_cap_deg must be .* to 180"),
        (
            lambda: el.papers.loghin.detect(np.ones((4, 8, 3)), settings=Settings(rise=3.0)),
            "rise cannot be set for a map",
        ),
        (
            lambda: el.detect_photograph(np.ones((4, 8, 3)), settings=Settings(sphere=True)),
            "sphere cannot be set for a photograph",
        ),
    ],
)
def test_bad_input_is_refused_by_name(call, message):
    with pytest.raises(el.EnvLightsError, match=message):
        call()


def test_lights_have_no_more_than_all_flux_of_the_map():
    """A sample at a pole has 3000 times the solid angle of its pixel."""
    radiance = np.full((48, 96, 3), 0.2, np.float32)
    radiance[0, 0] = radiance[-1, -1] = 1e4
    assert 0.5 < el.papers.loghin.detect(radiance).flux_fraction.sum() <= 1 + 1e-12


def test_lights_at_the_poles_hold_no_more_than_the_flux():
    """A bright pixel at a pole once held 994 times the flux of the map."""
    radiance = np.full((48, 96, 3), 0.2, np.float32)
    radiance[0, 0] = radiance[-1, -1] = 1e4
    found = el.papers.loghin.detect(radiance)
    assert len(found)
    assert (found.flux_fraction <= 1).all()
    assert found.flux_fraction.sum() <= 1 + 1e-6


def test_each_former_keyword_gives_the_same_and_warns():
    radiance = el.synthetic.hall(64).radiance
    with pytest.warns(DeprecationWarning, match="of detect is called") as warned:
        former = el.papers.loghin.detect(radiance, sphere=True, max_lights=2)
    assert [str(each.message) for each in warned] == [
        "max_lights= of detect is called lights= now",
        "sphere= of detect is called `sphere` of its settings now",
    ]
    assert former == el.papers.loghin.detect(radiance, lights=2, settings=Settings(sphere=True))
    with pytest.warns(DeprecationWarning, match="blur_px= of detect_photograph is called"):
        former = el.detect_photograph(radiance, blur_px=1.0)
    settings = replace(el.papers.loghin.PHOTOGRAPH, blur_px=1.0)
    assert former == el.detect_photograph(radiance, settings=settings)


def test_the_steps_are_functions_of_the_paper():
    assert el.papers.loghin.suppress is kernels.suppress
    assert el.papers.madsen.probe_residual is kernels.probe_residual
