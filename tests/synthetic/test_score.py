"""Score of a detector on maps with known lights."""

import numpy as np
import pytest

from envlights import synthetic
from envlights.synthetic import Disc


def two_lamps():
    shapes = [Disc((1, 0, 0), 5, (4, 4, 4)), Disc((0, 0, 1), 1, (9, 9, 9))]
    return synthetic.scene(128, shapes=shapes)


def empty():
    return synthetic.scene(16, background=(1, 1, 1))


def test_the_truth_scores_1():
    world = two_lamps()
    score = synthetic.evaluate([(world, world.lights.direction, world.irradiance_with_background)])
    assert (score.precision, score.recall, score.f1) == (1, 1, 1)
    np.testing.assert_allclose(score.angles_deg, 0, atol=1e-12)
    np.testing.assert_allclose(score.flux_errors, 0, atol=1e-12)


def test_the_order_of_what_is_found_does_not_matter():
    world = two_lamps()
    swapped = world.lights.direction[::-1], world.irradiance_with_background[::-1]
    score = synthetic.evaluate([(world, *swapped)])
    assert score.f1 == 1
    np.testing.assert_allclose(score.flux_errors, 0, atol=1e-12)


def test_a_missed_and_a_false_light_are_counted():
    world = two_lamps()
    direction, irradiance = world.lights.direction, world.irradiance_with_background
    missed = synthetic.evaluate([(world, direction[:1], irradiance[:1])])
    assert (missed.precision, missed.recall) == (1, 0.5)
    more = np.vstack([direction, [[0, 1, 0]]]), np.vstack([irradiance, [[1, 1, 1]]])
    false = synthetic.evaluate([(world, *more)])
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
    score = synthetic.evaluate([(empty(), nothing, nothing)])
    assert (score.precision, score.recall, score.f1, score.false_on_lightless) == (1, 1, 1, 0)
    score = synthetic.evaluate(
        [(empty(), [[0, 1, 0]], [[1, 1, 1]]), (two_lamps(), nothing, nothing)]
    )
    assert (score.precision, score.recall, score.f1, score.false_on_lightless) == (0, 0, 0, 1)
