"""Detection on clipped maps with generated lights."""

import numpy as np
import pytest

import envlights as el
from envlights import kernels
from envlights._common.srgb import encode_srgb
from envlights.fitting import wording
from envlights.papers.loghin import Settings
from envlights.synthetic import Disc, Rectangle, evaluate, scene, suite
from tests.helpers import DETECTORS, angle_deg, printed_by_threads


def eight_bits(radiance):
    return np.round(255 * encode_srgb(radiance)).astype(np.uint8)


def unit(vector):
    return np.array(vector) / np.linalg.norm(vector)


def glow(height, direction, radius_deg, background=0.2):
    """A sun whose radiance falls with the square of the angle: at white up to `radius_deg`."""
    angle = angle_deg(kernels.pixel_directions(height, 2 * height), direction)
    sun = background + (1 - background) * (radius_deg / np.maximum(angle, 0.25)) ** 2
    return np.repeat(sun[..., None], 3, axis=2)


def horizon(height, top_deg=4.0):
    """A white band from the horizon up, over a dark floor."""
    elevation = 90 - (np.arange(height) + 0.5) * 180 / height
    band = (elevation > 0) & (elevation < top_deg)
    return np.where(band, 2.0, 0.1)[:, None, None] * np.ones((1, 2 * height, 3))


# Suns and lamps behind white


@pytest.mark.parametrize("radius_deg", [1.0, 2.0, 3.5])
@pytest.mark.parametrize("direction", [(0.3, 0.5, 1.0), (0.02, 0.3, -1.0), (0.1, 1.0, 0.1)])
def test_a_sun_behind_a_small_plateau_is_found_within_0_3_degrees(radius_deg, direction):
    direction = unit(direction)
    picture = eight_bits(glow(512, direction, radius_deg))
    lights = el.detect(picture)
    assert angle_deg(lights.direction[0], direction) < 0.3
    assert lights.is_clipped[0]
    assert angle_deg(lights.direction[0], direction) <= np.rad2deg(lights.direction_uncertainty[0])


def test_the_direction_of_a_disc_is_its_centre_and_its_uncertainty_grows_with_its_plateau():
    uncertainties = []
    for radius_deg in (1.5, 5.0, 15.0):
        disc = Disc((1, 0.4, 0.3), radius_deg, (50, 40, 30))
        lights = el.detect(eight_bits(scene(256, background=[0.1] * 3, shapes=[disc]).radiance))
        assert len(lights) == 1
        assert angle_deg(lights.direction[0], unit(disc.direction)) < 0.25
        uncertainties.append(lights.direction_uncertainty[0])
    assert uncertainties == sorted(uncertainties)
    # 0.7 (R + 0.2 degrees), to a pixel.
    np.testing.assert_allclose(np.rad2deg(uncertainties[-1]), 0.7 * 15.2, atol=0.5)


def at_elevation(degrees):
    across, up = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    return np.array([across * np.cos(0.3), up, across * np.sin(0.3)])


def test_a_sun_that_runs_into_a_white_horizon_is_found_as_if_it_were_alone():
    direction = at_elevation(14)
    picture = eight_bits(np.maximum(glow(512, direction, 8.0, 0.15), horizon(512, 7.0)))
    assert angle_deg(el.detect(picture).direction, direction).min() < 2.5
    # The centroid of all that is white is far from it.
    white = (picture > 253).all(axis=2)[..., None] * kernels.pixel_directions(512, 1024)
    whole = (white * kernels.pixel_solid_angles(512, 1024)[..., None]).sum(axis=(0, 1))
    assert angle_deg(unit(whole), direction) > 30


@pytest.mark.parametrize(("apart_deg", "count"), [(9.0, 1), (12.8, 2)])
def test_a_neck_of_less_than_half_the_depth_divides_two_lamps(apart_deg, count):
    """Discs of 6 degrees: overlapping by 3, and with a gap of 0.8 that is closed as a bar."""
    shapes = [Disc(at_elevation(elevation), 6, (9, 9, 9)) for elevation in (30, 30 + apart_deg)]
    maps = [scene(512, background=[0.1] * 3, shapes=[shape]).radiance for shape in shapes]
    lights = el.detect(eight_bits(np.maximum(*maps)))
    assert len(lights) == count
    if count == 2:
        for shape in shapes:
            assert angle_deg(lights.direction, shape.direction).min() < 1.5


def test_a_window_with_bars_is_one_light():
    window = Rectangle((1, 0.2, 0.3), 20, 14, (9, 9, 9), panes=(3, 2), bar_deg=0.6)
    lights = el.detect(eight_bits(scene(512, background=[0.1] * 3, shapes=[window]).radiance))
    assert len(lights) == 1
    assert angle_deg(lights.direction[0], unit(window.direction)) < 0.3


@pytest.mark.parametrize(("between", "count"), [(0.1, 1), (0.5, 1), (0.9, 6)])
def test_panes_behind_wide_bars_are_one_light_and_clouds_before_a_pale_sky_are_not(between, count):
    window = Rectangle((1, 0.2, 0.3), 30, 20, (9, 9, 9), panes=(3, 2), bar_deg=2.0)
    picture = eight_bits(scene(512, background=[between] * 3, shapes=[window]).radiance)
    lights, panes = el.detect(picture), el.detect(picture, gap_deg=0)
    assert (len(lights), len(panes)) == (count, 6)
    np.testing.assert_allclose(lights.flux.sum(axis=0), panes.flux.sum(axis=0))
    assert lights.weight.sum() == pytest.approx(panes.weight.sum(), rel=1e-3)
    assert ("joined from 6 panes" in str(lights.report)) == (count == 1)
    if count == 1:
        off = angle_deg(lights.direction[0], unit(window.direction))
        assert off < 0.3 < np.rad2deg(lights.direction_uncertainty[0])


def test_a_lamp_that_is_smaller_than_a_working_pixel_is_found():
    lamp = Disc((1, 0.4, 0.3), 0.25, (50, 50, 50))
    lights = el.detect(eight_bits(scene(1024, background=[0.2] * 3, shapes=[lamp]).radiance))
    assert len(lights) == 1
    assert angle_deg(lights.direction[0], unit(lamp.direction)) < 0.3


@pytest.mark.parametrize("name", ["plain", "hard"])
def test_known_lights_are_found_in_pictures_of_eight_bits(name):
    worlds = [getattr(suite, name)(seed, 256) for seed in suite.EVALUATION[::2]]
    worlds = [world for world in worlds if "clipped" in world.note or "8 bit" in world.note]
    found = [(world, el.detect(eight_bits(world.radiance))) for world in worlds]
    score = evaluate([(world, lights.direction, lights.flux) for world, lights in found])
    assert score.recall >= 0.85
    assert score.precision >= 0.7
    assert score.false_on_lightless == 0
    assert np.median(score.angles_deg) < 0.2


# Order, floors, and maps without lights


def test_an_overexposed_picture_is_searched_in_fewer_pixels():
    sun = unit((0.3, 0.5, 1.0))
    radiance = glow(512, sun, 3.0)
    lower = kernels.pixel_directions(512, 1024)[..., 1] < -0.3
    few, many = (eight_bits(np.where(lower[..., None], floor, radiance)) for floor in (0.1, 1.0))
    assert el.detect(few).report.working_size == (256, 512)
    lights = el.detect(many)
    assert lights.report.working_size == (128, 256)  # a third of the sphere is white
    # Those are of 1.4 degrees: the sun is where it is to a third of one.
    assert angle_deg(lights.direction, sun).min() < 1.4 / 3


def test_of_two_plateaus_the_higher_and_smaller_one_comes_first():
    shapes = [Disc((1, 1, 0), 3, (9, 9, 9)), Disc((0, 0.1, 1), 9, (9, 9, 9))]
    lights = el.detect(eight_bits(scene(256, background=[0.1] * 3, shapes=shapes).radiance))
    assert len(lights) == 2
    assert angle_deg(lights.direction[0], unit(shapes[0].direction)) < 1
    assert lights.flux[0].sum() < lights.flux[1].sum(), "not the order of flux"
    assert (np.diff(lights.weight) <= 0).all()
    assert lights[1:].weight.tolist() == lights.weight[1:].tolist()


def test_a_white_floor_is_no_light_beside_a_lamp():
    shapes = [Disc((0, -1, 0.1), 40, (9, 9, 9)), Disc((0, 0.5, 1), 3, (9, 9, 9))]
    picture = eight_bits(scene(256, background=[0.1] * 3, shapes=shapes).radiance)
    lights = el.detect(picture)
    assert len(lights) == 1
    assert angle_deg(lights.direction[0], unit(shapes[1].direction)) < 1
    assert not lights.is_broad.any()
    alone = el.detect(eight_bits(scene(256, background=[0.1] * 3, shapes=shapes[:1]).radiance))
    assert len(alone) == 1, "alone it is all that there is"
    assert alone.is_broad.tolist() == [True]


@pytest.mark.parametrize("code", [0, 60, 254, 255])
def test_an_even_picture_has_no_light(code):
    assert len(el.detect(np.full((64, 128, 3), code, np.uint8))) == 0


@pytest.mark.parametrize("seed", range(9, 60, 10))
def test_pictures_of_eight_bits_without_lights_stay_without(seed):
    world = suite.plain(seed, 256)
    assert not len(world.lights)
    assert not len(el.detect(eight_bits(world.radiance)))


# The white, and what the report says


def test_a_white_that_is_given_counts_as_that_of_integers():
    radiance = np.minimum(glow(128, np.array([0, 0.6, 0.8]), 3.0), 1).astype(np.float32)
    given = el.detect(radiance, clip_level=1.0)
    held = el.detect(el.EnvMap(radiance, clip_level=1.0))
    scaled = el.detect(el.EnvMap(7 * radiance, clip_level=7.0))
    assert len(given) == 1
    assert given.to_dict() == held.to_dict()
    np.testing.assert_allclose(scaled.direction, given.direction, atol=1e-6)
    np.testing.assert_allclose(scaled.flux, 7 * given.flux, rtol=1e-5)
    np.testing.assert_allclose(scaled.report.threshold, 7 * given.report.threshold, rtol=1e-5)
    sixteen = np.round(65535 * encode_srgb(radiance)).astype(np.uint16)
    assert angle_deg(el.detect(sixteen).direction, given.direction).max() < 0.01


def test_without_a_white_nothing_changes():
    radiance = glow(128, np.array([0, 0.6, 0.8]), 3.0)
    lights = el.detect(radiance)
    assert lights.weight is None
    assert lights.direction_uncertainty is None
    assert "weight" not in lights.to_dict()
    assert lights.report.clip_level is None


@pytest.mark.parametrize(
    ("largest", "words"),
    [
        (9.0, "the map is clipped at 1;"),
        (0.9, "the map is clipped at 0.9, below its largest possible value;"),
        (0.4, None),
    ],
)
def test_the_report_says_at_which_level_the_map_is_clipped(largest, words):
    radiance = glow(128, np.array([0, 0.6, 0.8]), 1.0)
    radiance *= largest / radiance.max()
    report = el.detect(np.minimum(radiance, 1), clip_level=1.0).report
    assert (report.clip_level is None) == (words is None)
    assert ("clipped map: lights are separated by" in str(report)) == (words is not None)
    assert words is None or any(detail.startswith(words) for detail in report.details)
    assert report.threshold < 1


def test_lights_are_merged_to_a_budget():
    shapes = [Disc((1, 1, 0), 3, (9, 9, 9)), Disc((0, 0.1, 1), 5, (9, 9, 9))]
    picture = eight_bits(scene(256, background=[0.1] * 3, shapes=shapes).radiance)
    both, one = el.detect(picture), el.detect(picture, max_lights=1)
    assert len(one) == 1
    np.testing.assert_allclose(one.flux[0], both.flux.sum(axis=0), rtol=1e-6)
    np.testing.assert_allclose(one.weight.sum(), both.weight.sum())
    apart = angle_deg(both.direction, one.direction[0])
    assert np.rad2deg(one.direction_uncertainty[0]) >= apart.max() - 1e-6


@pytest.mark.parametrize(("white", "seen"), [(0, "got 0"), (-1, "got -1"), (np.inf, "got inf")])
def test_a_white_that_none_can_be_is_refused(white, seen):
    radiance = np.ones((8, 16, 3), np.float32)
    for refused in (
        lambda: el.EnvMap(radiance, clip_level=white),
        lambda: el.detect(radiance, clip_level=white),
    ):
        with pytest.raises(el.EnvLightsError, match=f"clip_level must be .*{seen}"):
            refused()


def test_samples_that_are_no_radiance_are_cleaned_before_detection():
    radiance = np.minimum(glow(64, np.array([0, 0.6, 0.8]), 5.0), 1).astype(np.float32)
    clean = el.detect(radiance, clip_level=1.0)
    radiance[60, 3] = np.nan
    lights = el.detect(radiance, clip_level=1.0)
    assert angle_deg(lights.direction, clean.direction).max() < 0.1
    assert any("NaN" in note for note in lights.report.notes)


def test_any_number_of_threads_gives_the_same_bits():
    code = """
import hashlib, numpy as np, envlights as el
from envlights._common.srgb import encode_srgb
world = el.synthetic.hard(8, 256)
lights = el.detect(np.round(255 * encode_srgb(world.radiance)).astype(np.uint8))
arrays = lights.direction, lights.flux, lights.weight, lights.direction_uncertainty
print(len(lights), hashlib.sha256(b"".join(each.tobytes() for each in arrays)).hexdigest())
"""
    assert len(printed_by_threads(code)) == 1


# Clipping


def test_the_brightest_pixel_of_an_evenly_lit_window_is_not_clipped():
    window = Rectangle((1, 0.2, 0.3), 20, 14, (9, 9, 9))
    radiance = scene(256, background=[0.1] * 3, shapes=[window]).radiance
    radiance = radiance * np.random.default_rng(1).normal(1, 0.002, radiance.shape[:2])[..., None]
    for method in DETECTORS:
        assert not DETECTORS[method](radiance).is_clipped.any(), method
    assert el.EnvMap(radiance).clipped_fraction == 0


@pytest.mark.parametrize("ceiling", [1.0, 4096, 32000, 65025, 65504])
def test_a_flat_top_at_a_ceiling_is_clipped(ceiling):
    radiance = np.minimum(ceiling * glow(256, np.array([0, 0.6, 0.8]), 6.0, 1e-3), ceiling)
    for method in DETECTORS:
        options = {"settings": Settings(relative=True)} if method == "loghin" else {}
        assert DETECTORS[method](radiance, **options).is_clipped[0], method
    share = (1 - np.cos(np.deg2rad(6.0))) / 2
    np.testing.assert_allclose(el.EnvMap(radiance).clipped_fraction, share, rtol=0.05)


@pytest.mark.parametrize("colour", [(50, 50, 50), (7, 3, 2)])
def test_a_lamp_of_one_radiance_is_not_clipped(colour):
    lamp = el.synthetic.Disc((0, 0.6, 0.8), 6.0, colour)
    radiance = scene(256, background=[0.1] * 3, shapes=[lamp]).radiance
    assert el.EnvMap(radiance).clipped_fraction == 0
    assert not el.detect(radiance).is_clipped.any()
    assert "no pixel is clipped" in el.EnvMap(radiance).repaired().notes[-1]


def test_a_sun_with_two_channels_at_the_ceiling_is_clipped():
    radiance = glow(256, np.array([0, 0.6, 0.8]), 6.0, 1e-3) * (1.2, 1.1, 0.3)
    radiance = np.minimum(radiance, 4)
    assert el.detect(radiance).is_clipped.tolist() == [True]


def test_the_map_knows_its_clipped_fraction():
    radiance = np.full((64, 128, 3), 0.25)
    radiance[:16] = 3.0
    share = (1 - np.cos(np.pi / 4)) / 2
    for env in (
        el.EnvMap(np.minimum(radiance, 1), clip_level=1.0),
        el.EnvMap(eight_bits(radiance)),
    ):
        np.testing.assert_allclose(env.clipped_fraction, share, rtol=1e-6)
        wanted = share / (share + env.radiance[40, 0, 0] * (1 - share))
        np.testing.assert_allclose(env.clipped_flux_fraction, wanted, rtol=1e-6)
        assert f"{100 * share:.2g} % of the sphere is clipped" in repr(env)
    assert "%" not in repr(el.EnvMap(radiance))


def test_what_a_rig_rests_on_is_a_sentence():
    radiance = np.full((64, 128, 3), 0.25)
    assert el.fit(radiance, lights=0).notes == ()
    radiance[:32] = 1
    (note,) = el.fit(el.EnvMap(radiance, clip_level=1.0), lights=0).notes
    assert wording.clipping(0.8) == (note,)
    assert note == (
        "clipped pixels hold 80 % of the map's flux, so the lights there are a lower bound"
    )


def test_the_article_says_where_its_threshold_lies_in_a_file():
    picture = eight_bits(glow(64, np.array([0, 0.6, 0.8]), 5.0))
    report = el.papers.loghin.detect(picture).report
    assert "80 % of the clip level, code 231 of 255" in report.reason
    linear = picture.astype(np.float32) * 1.01  # whole numbers would be codes
    assert "code" not in el.papers.loghin.detect(linear).report.reason
