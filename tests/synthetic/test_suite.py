"""The families of maps with known lights, and the score of what is found in them."""

import numpy as np
import pytest

import envlights as el
from envlights import synthetic
from envlights.kernels.image import LUMINANCE
from envlights.synthetic import Disc, PixelSun, Rectangle
from tests.helpers import flux

FAMILIES = pytest.mark.parametrize("family", [synthetic.plain, synthetic.hard])
# Enough to see each first kind of light on each backdrop, in the smallest maps that hold them all.
SEEDS = range(35)
HEIGHT = 128


def contrast(world):
    """Of each light, over what is behind it."""
    whole = world.irradiance_with_background @ LUMINANCE
    return whole / (whole - world.lights.irradiance @ LUMINANCE)


@FAMILIES
def test_a_seed_gives_one_map(family):
    once, again, other = family(5, HEIGHT), family(5, HEIGHT), family(6, HEIGHT)
    np.testing.assert_array_equal(once.radiance, again.radiance)
    np.testing.assert_array_equal(once.lights.direction, again.lights.direction)
    assert once.note == again.note
    assert not np.array_equal(once.radiance, other.radiance)


def test_no_seed_is_for_tuning_and_for_judging():
    assert not set(synthetic.TUNING) & set(synthetic.JUDGING)


def test_the_families_share_no_map():
    assert not np.array_equal(
        synthetic.plain(0, HEIGHT).radiance, synthetic.hard(0, HEIGHT).radiance
    )


@pytest.mark.parametrize(("family", "period"), [(synthetic.plain, 10), (synthetic.hard, 8)])
def test_some_maps_have_no_light(family, period):
    for seed in SEEDS:
        world = family(seed, HEIGHT)
        assert (len(world.lights) == 0) == (seed % period == period - 1), world.note
        assert world.note.startswith("no light") == (len(world.lights) == 0)
        assert len(world.solid_angle) == len(world.irradiance_with_background) == len(world.lights)


@FAMILIES
def test_lights_stand_out_and_stand_apart(family):
    for seed in SEEDS:
        world = family(seed, HEIGHT)
        is_clipped = "linear" not in world.note
        # Glare of the neighbours may halve the 20 of the hard family.
        assert (contrast(world) > (2.4 if is_clipped else 7.5)).all(), (seed, contrast(world))
        assert world.radiance.max() <= 1 or not is_clipped
        cosines = world.lights.direction @ world.lights.direction.T
        assert (
            np.rad2deg(np.arccos(np.clip(cosines, -1, 1))) + 90 * np.eye(len(cosines)) > 2
        ).all()


def test_lights_add_what_the_stored_map_has_beyond_an_even_background():
    """Clipped, in 8 bits or whole: no flux is lost and none counts twice."""
    even = [world for world in (synthetic.plain(s, HEIGHT) for s in SEEDS) if "even" in world.note]
    assert len(even) >= 5
    for world in even:
        background = np.median(world.radiance, axis=(0, 1))
        np.testing.assert_allclose(
            world.lights.irradiance.sum(axis=0), flux(world.radiance - background), rtol=1e-4
        )
        behind = background * world.solid_angle[:, None]
        np.testing.assert_allclose(
            world.irradiance_with_background - world.lights.irradiance, behind, rtol=1e-5
        )


@FAMILIES
def test_no_light_has_more_flux_than_the_map(family):
    for seed in SEEDS:
        world = family(seed, HEIGHT)
        lit = world.irradiance_with_background.sum(axis=0)
        assert (world.lights.irradiance.sum(axis=0) <= lit).all()
        assert (lit <= flux(world.radiance) * (1 + 1e-6)).all()


@pytest.mark.parametrize("level", [1.0, 1e-3, 1e3])
def test_irradiance_with_background_is_the_map_summed_over_the_light(level):
    """A pixel sun and a disc before a gradient, against a sum over the stored pixels."""
    height = 256
    up = el.kernels.pixel_directions(height, 2 * height)[..., 1:2]
    sky = level * (1.2 + up) * [0.9, 1.0, 1.1]
    shapes = [
        PixelSun((0, 0.3, -1), level * np.full(3, 1e5)),
        Disc((1, 0, 0), 8, level * np.full(3, 30)),
    ]
    world = synthetic.scene(height, background=sky, shapes=shapes)
    is_sun = world.radiance[..., :1] > 1e4 * level
    is_disc = shapes[1].coverage(height)[..., None] > 0
    assert is_sun.sum() == 1
    seen = [flux(world.radiance * is_sun), flux(world.radiance * is_disc)]
    np.testing.assert_allclose(world.irradiance_with_background[0], seen[0], rtol=1e-6)
    # The sum over whole pixels has the background of those at the rim as well: 30 to 1 in
    # radiance, and half of a ring one pixel wide of a disc of 11 pixels in radius.
    np.testing.assert_allclose(world.irradiance_with_background[1], seen[1], rtol=5e-3)
    assert (world.irradiance_with_background[1] < seen[1]).all()


def test_what_a_camera_clips_is_no_flux():
    lamp = Disc((1, 0, 0), 10, (50, 50, 50))
    world = synthetic.scene(
        128, background=(0.2,) * 3, shapes=[lamp], camera=lambda radiance: np.minimum(radiance, 1)
    )
    added = 0.8 * (lamp.coverage(128)[..., None] > 0) * np.ones(3)
    np.testing.assert_allclose(world.lights.irradiance[0], flux(added), rtol=1e-6)


def test_a_pixel_sun_is_seen_at_the_centre_of_its_pixel():
    centres = el.kernels.pixel_directions(64, 128)
    for row, column in [(0, 5), (20, 0), (33, 127), (63, 64)]:
        beside = centres[row, column] + [1e-5, 0, 1e-5]
        world = synthetic.scene(64, background=(1, 1, 1), shapes=[PixelSun(beside, (1e5,) * 3)])
        np.testing.assert_allclose(world.lights.direction[0], centres[row, column], atol=1e-12)


@pytest.mark.parametrize("radius", [2.0, 8.0])
@pytest.mark.parametrize("direction", [(0, 0, -1), (0, 1, 0), (0.05, -1, 0), (0.01, 0.5, -1)])
def test_lights_on_the_seam_and_the_poles_are_as_strong_as_elsewhere(direction, radius):
    def lamp(towards):
        return synthetic.scene(256, shapes=[Disc(towards, radius, (3, 3, 3))])

    here, elsewhere = lamp(direction), lamp((0.8, 0.1, 0.5))
    # The rim is known to half a sample of 180 / 256 / 4 = 0.18 degrees: where it lies along a row
    # of samples, as around a pole, all of it may be off by that much.
    np.testing.assert_allclose(
        here.lights.irradiance, elsewhere.lights.irradiance, rtol=2 * 0.09 / radius
    )
    assert here.angular_radius_deg[0] == pytest.approx(radius, abs=0.09)
    towards = np.array(direction) / np.linalg.norm(direction)
    assert np.rad2deg(np.linalg.norm(here.lights.direction[0] - towards)) < 0.02


def test_a_window_with_bars_is_one_light_without_the_bars():
    glass = Rectangle((1, 0, 0), 20, 12, (9, 9, 9))
    barred = Rectangle((1, 0, 0), 20, 12, (9, 9, 9), panes=(2, 3), bar_deg=0.4)
    whole, divided = (synthetic.scene(512, shapes=[window]) for window in (glass, barred))
    assert len(divided.lights) == 1
    # One bar upright and two across, less where they cross.
    bars = (0.4 / 20 + 2 * 0.4 / 12) - 2 * (0.4 / 20) * (0.4 / 12)
    assert divided.solid_angle[0] / whole.solid_angle[0] == pytest.approx(1 - bars, abs=2e-3)


def test_a_turn_by_90_degrees_swaps_the_sides():
    upright = Rectangle((1, 0.3, 0), 30, 5, (1, 1, 1)).coverage(128)
    turned = Rectangle((1, 0.3, 0), 5, 30, (1, 1, 1), tilt_deg=90).coverage(128)
    np.testing.assert_allclose(turned, upright, atol=0.26)  # a row of samples on an edge
    assert turned.sum() == pytest.approx(upright.sum(), rel=1e-3)


def two_lamps():
    shapes = [Disc((1, 0, 0), 5, (4, 4, 4)), Disc((0, 0, 1), 1, (9, 9, 9))]
    return synthetic.scene(128, shapes=shapes)


def empty():
    return synthetic.scene(16, background=(1, 1, 1))


def test_the_truth_scores_1():
    world = two_lamps()
    score = synthetic.judge([(world, world.lights.direction, world.irradiance_with_background)])
    assert (score.precision, score.recall, score.f1) == (1, 1, 1)
    np.testing.assert_allclose(score.angles_deg, 0, atol=1e-12)
    np.testing.assert_allclose(score.flux_errors, 0, atol=1e-12)


def test_the_order_of_what_is_found_does_not_matter():
    world = two_lamps()
    swapped = world.lights.direction[::-1], world.irradiance_with_background[::-1]
    score = synthetic.judge([(world, *swapped)])
    assert score.f1 == 1
    np.testing.assert_allclose(score.flux_errors, 0, atol=1e-12)


def test_a_missed_and_a_false_light_are_counted():
    world = two_lamps()
    direction, irradiance = world.lights.direction, world.irradiance_with_background
    missed = synthetic.judge([(world, direction[:1], irradiance[:1])])
    assert (missed.precision, missed.recall) == (1, 0.5)
    more = np.vstack([direction, [[0, 1, 0]]]), np.vstack([irradiance, [[1, 1, 1]]])
    false = synthetic.judge([(world, *more)])
    assert (false.precision, false.recall) == (pytest.approx(2 / 3), 1)
    assert false.f1 == pytest.approx(0.8)


def test_a_light_is_hit_once_and_by_the_closest():
    world = two_lamps()
    i = int(np.argmax(world.lights.direction[:, 0]))
    near, nearer = ([np.cos(np.deg2rad(off)), np.sin(np.deg2rad(off)), 0.0] for off in (3.0, 1.0))
    ((known, found, angle),) = synthetic.match(world, [near, nearer])
    assert (known, found) == (i, 1)
    assert angle == pytest.approx(1, abs=0.01)


@pytest.mark.parametrize(("off_deg", "hits"), [(1.9, 2), (2.1, 1), (4.9, 1), (5.1, 0)])
def test_a_hit_lies_within_2_degrees_or_the_radius(off_deg, hits):
    """The lamps have radii of 5 degrees and 1 degree."""
    cos, sin = np.cos(np.deg2rad(off_deg)), np.sin(np.deg2rad(off_deg))
    assert len(synthetic.match(two_lamps(), [[cos, sin, 0], [0, sin, cos]])) == hits


def test_nothing_found_where_nothing_is_is_right():
    nothing = np.zeros((0, 3))
    score = synthetic.judge([(empty(), nothing, nothing)])
    assert (score.precision, score.recall, score.f1, score.false_on_lightless) == (1, 1, 1, 0)
    score = synthetic.judge([(empty(), [[0, 1, 0]], [[1, 1, 1]]), (two_lamps(), nothing, nothing)])
    assert (score.precision, score.recall, score.f1, score.false_on_lightless) == (0, 0, 0, 1)


@FAMILIES
def test_maps_that_are_too_small_for_the_smallest_lights_are_refused(family):
    with pytest.raises(el.EnvLightsError, match="height must be a whole number, 128 or more"):
        family(0, 127)
