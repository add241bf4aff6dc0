"""Lights merged or dropped to a smaller number."""

import numpy as np
import pytest

import envlights as el
from envlights.kernels.image import LUMINANCE
from tests.detection.worlds import members, one_pixel_suns
from tests.reference import ward


@pytest.mark.parametrize("seed", range(8))
def test_the_reference_merges_lights_of_equal_flux_as_scipy_does(seed):
    """On a small part of the sphere: scipy's centres of clusters lie inside of it, ours on it."""
    hierarchy = pytest.importorskip("scipy.cluster.hierarchy")
    offsets = np.random.default_rng(seed).uniform(-0.02, 0.02, (20, 2))
    directions = np.concatenate([offsets, np.ones((20, 1))], axis=1)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    tree = hierarchy.ward(directions)
    for most in (15, 8, 3):
        labels = hierarchy.fcluster(tree, most, criterion="maxclust")
        theirs = {frozenset(np.flatnonzero(labels == label)) for label in set(labels)}
        assert set(map(frozenset, ward.clusters(np.ones(20), directions, most))) == theirs


@pytest.mark.parametrize("seed", range(8))
def test_merging_is_wards_with_the_flux_as_weight(seed):
    radiance = one_pixel_suns(30, seed)
    points = el.detect(radiance)
    assert len(points) == 30
    pixels = np.array([next(iter(each)) for each in members(points)])
    flux = points.flux @ LUMINANCE
    for most in (20, 10, 5, 2):
        lights = el.detect(radiance, max_lights=most)
        wanted = ward.clusters(flux, points.direction, most)
        groups = {frozenset(map(tuple, pixels[sorted(group)].tolist())) for group in wanted}
        assert set(map(frozenset, members(lights))) == groups, most


def test_the_report_counts_what_was_dropped_and_what_was_merged():
    radiance = one_pixel_suns(12, 0)
    whole = el.detect(radiance)
    share = whole.flux_fraction
    kept = el.detect(radiance, min_flux_fraction=0.5 * (share[9] + share[8]))
    np.testing.assert_array_equal(kept.direction, whole[:9].direction)
    lights = el.detect(radiance, min_flux_fraction=0.5 * (share[9] + share[8]), max_lights=4)
    assert len(lights) == 4
    np.testing.assert_allclose(lights.flux_fraction.sum(), share[:9].sum(), rtol=1e-9)
    report = str(lights.report)
    assert "3 lights are too weak" in report
    assert "5 lights were merged into neighbours" in report


def test_where_all_lights_are_too_dim_the_report_says_no_other_reason():
    lights = el.detect(one_pixel_suns(3, 1), min_flux_fraction=1.0)
    assert len(lights) == 0
    assert "3 lights are too weak" in str(lights.report)
    assert "the whole map" not in str(lights.report)
