"""Families of maps with known lights, and the score of detectors on them."""

from functools import cache

import numpy as np
import pytest

import envlights as el
from envlights import synthetic
from envlights.kernels.image import LUMINANCE
from tests.helpers import flux

FAMILIES = pytest.mark.parametrize("family", [synthetic.plain, synthetic.hard])
# Enough to see each first kind of light on each backdrop, in the smallest maps that hold them all.
SEEDS = range(35)
HEIGHT = 128


@cache
def world_of(family, seed):
    return family(seed, HEIGHT)


def contrast(world):
    """Contrast of each light to its background."""
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
    assert not set(synthetic.TUNING) & set(synthetic.EVALUATION)


def test_the_families_share_no_map():
    assert not np.array_equal(
        synthetic.plain(0, HEIGHT).radiance, synthetic.hard(0, HEIGHT).radiance
    )


@pytest.mark.parametrize(("family", "period"), [(synthetic.plain, 10), (synthetic.hard, 8)])
def test_some_maps_have_no_light(family, period):
    for seed in SEEDS:
        world = world_of(family, seed)
        assert (len(world.lights) == 0) == (seed % period == period - 1), world.note
        assert world.note.startswith("no light") == (len(world.lights) == 0)
        assert len(world.solid_angle) == len(world.irradiance_with_background) == len(world.lights)


@FAMILIES
def test_lights_stand_out_and_stand_apart(family):
    for seed in SEEDS:
        world = world_of(family, seed)
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
    even = [
        world for world in (world_of(synthetic.plain, s) for s in SEEDS) if "even" in world.note
    ]
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
        world = world_of(family, seed)
        lit = world.irradiance_with_background.sum(axis=0)
        assert (world.lights.irradiance.sum(axis=0) <= lit).all()
        assert (lit <= flux(world.radiance) * (1 + 1e-6)).all()


@FAMILIES
def test_maps_that_are_too_small_for_the_smallest_lights_are_refused(family):
    with pytest.raises(el.EnvLightsError, match="height must be a whole number, 128 or more"):
        family(0, 127)
