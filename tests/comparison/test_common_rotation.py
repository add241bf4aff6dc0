"""Rotation that brings pairs of directions together."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from envlights.comparison.angles import rotation_degrees


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def weighted_directions(seed, count):
    rng = np.random.default_rng(seed)
    weights = rng.random(count)
    return rng, unit(rng.normal(size=(count, 3))), weights / weights.sum()


@pytest.mark.parametrize("degrees", [0.0, 1e-5, 1.0, 90.0, 179.0, 180.0])
@pytest.mark.parametrize("count", [2, 3, 50])
def test_a_rotation_is_measured_from_its_pairs(degrees, count):
    rng, before, weights = weighted_directions(count, count)
    turn = Rotation.from_rotvec(np.deg2rad(degrees) * unit(rng.normal(size=(1, 3)))[0])
    angle = rotation_degrees(before, turn.apply(before), weights)
    assert angle == pytest.approx(degrees, abs=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_pairs_that_no_rotation_joins_get_the_one_of_scipy(seed):
    rng, before, weights = weighted_directions(seed, 6)
    after = unit(Rotation.random(random_state=seed).apply(before) + 0.5 * rng.normal(size=(6, 3)))
    best, _ = Rotation.align_vectors(after, before, weights)
    expected = np.rad2deg(best.magnitude())
    assert rotation_degrees(before, after, weights) == pytest.approx(expected, abs=1e-6)


def test_a_reflection_gives_the_best_proper_rotation():
    """Mirrored in a plane: singular values need the sign of the determinant."""
    _, before, weights = weighted_directions(1, 9)
    after = before * [1, 1, -1]
    best, _ = Rotation.align_vectors(after, before, weights)
    expected = np.rad2deg(best.magnitude())
    assert rotation_degrees(before, after, weights) == pytest.approx(expected, abs=1e-6)


def test_directions_on_one_line_get_the_smallest_rotation():
    before = np.array([[0, 0, 1.0], [0, 0, -1.0]])
    turn = Rotation.from_rotvec([0.3, 0, 0]) * Rotation.from_rotvec([0, 0, 2.0])
    angle = rotation_degrees(before, turn.apply(before), np.array([0.7, 0.3]))
    assert angle == pytest.approx(np.rad2deg(0.3), abs=1e-9)


def test_directions_in_balance_have_no_best_rotation():
    before = np.array([[0, 0, 1.0], [0, 0, -1.0]])
    assert rotation_degrees(before, np.array([[1.0, 0, 0]] * 2), np.array([0.5, 0.5])) is None
