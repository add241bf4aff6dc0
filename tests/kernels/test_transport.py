"""Optimal transport between weighted directions, against linear programs of SciPy."""

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment, linprog
from scipy.sparse import eye, kron, vstack

import envlights as el
from envlights.kernels import transport_plan


def directions(rng, count):
    vectors = rng.normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def angles(one, other):
    crosses = np.linalg.norm(np.cross(one[:, None], other[None]), axis=-1)
    return np.arctan2(crosses, one @ other.T)


def least_mean_angle(one, weights, other, other_weights):
    """Least mean angle by HiGHS, which solves a linear program with dense constraints."""
    cost = angles(one, other)
    n, m = cost.shape
    sums = vstack([kron(eye(n), np.ones((1, m))), kron(np.ones((1, n)), eye(m))]).tocsr()
    shares = np.concatenate([weights / weights.sum(), other_weights / other_weights.sum()])
    tight = dict.fromkeys(("primal_feasibility_tolerance", "dual_feasibility_tolerance"), 1e-10)
    # The last sum follows from the others; up to rounding, which can make the program infeasible.
    return linprog(cost.ravel(), A_eq=sums[:-1], b_eq=shares[:-1], options=tight).fun


def random_set(rng, count):
    return directions(rng, count), rng.random(count)


def set_of_equal_masses(rng, count):
    return directions(rng, count), np.ones(count)


def set_with_zeros(rng, count):
    weights = rng.integers(0, 3, count).astype(float)
    weights[rng.integers(count)] = 1.0
    return directions(rng, count), weights


def coincident_set(rng, count):
    """Lights on the six axes: several are in one direction, and many angles are equal."""
    return np.vstack([np.eye(3), -np.eye(3)])[rng.integers(6, size=count)], np.ones(count)


def clustered_set(rng, count):
    """Lights within 1e-6 of three directions."""
    centres = directions(np.random.default_rng(3), 3)[rng.integers(3, size=count)]
    vectors = centres + 1e-6 * rng.normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True), rng.random(count)


def set_of_unequal_masses(rng, count):
    """Weights over many orders of magnitude."""
    return directions(rng, count), 10.0 ** rng.uniform(-12, 12, count)


SETS = [
    random_set,
    set_of_equal_masses,
    set_with_zeros,
    coincident_set,
    clustered_set,
    set_of_unequal_masses,
]


@pytest.mark.parametrize("kind", SETS)
@pytest.mark.parametrize(("n", "m"), [(1, 1), (2, 3), (7, 7), (1, 20), (20, 20), (40, 31)])
def test_mean_angle_is_that_of_a_linear_program(kind, n, m):
    rng = np.random.default_rng(100 * n + m)
    sets = *kind(rng, n), *kind(rng, m)
    angle, pairs, shares = transport_plan(*sets)
    assert angle == pytest.approx(least_mean_angle(*sets), abs=1e-10)
    # The plan moves the shares of both sets, at that cost.
    plan = np.zeros((n, m))
    plan[tuple(pairs.T)] = shares
    assert len(shares) == len(np.unique(pairs, axis=0)) <= n + m - 1
    np.testing.assert_allclose(plan.sum(axis=1), sets[1] / sets[1].sum(), rtol=0, atol=1e-12)
    np.testing.assert_allclose(plan.sum(axis=0), sets[3] / sets[3].sum(), rtol=0, atol=1e-12)
    assert (plan * angles(sets[0], sets[2])).sum() == pytest.approx(angle, abs=1e-12)


@pytest.mark.parametrize("kind", [set_of_equal_masses, coincident_set])
def test_256_equal_masses_get_the_best_assignment(kind):
    rng = np.random.default_rng(7)
    (one, weights), (other, _) = kind(rng, 256), set_of_equal_masses(rng, 256)
    cost = angles(one, other)
    best = cost[linear_sum_assignment(cost)].mean()
    assert transport_plan(one, weights, other, weights)[0] == pytest.approx(best, abs=1e-10)


def mean_angle(one, other):
    return transport_plan(*one, *other)[0]


@pytest.mark.parametrize("seed", range(100))
def test_the_mean_angle_is_a_metric(seed):
    """Between degenerate sets too: of coincident lights, equal weights and weights of 0."""
    rng = np.random.default_rng(seed)
    a, b, c = (SETS[k](rng, rng.integers(1, 12)) for k in rng.integers(len(SETS), size=3))
    assert mean_angle(a, a) < 1e-12
    assert mean_angle(a, b) == pytest.approx(mean_angle(b, a), abs=1e-11)
    assert mean_angle(a, c) <= mean_angle(a, b) + mean_angle(b, c) + 1e-11


def test_lights_without_difference_do_not_cycle():
    """Each assignment is an optimum of 100 equal lights in one direction."""
    up, side, weights = np.tile([0.0, 1, 0], (100, 1)), np.tile([1.0, 0, 0], (100, 1)), np.ones(100)
    assert len(transport_plan(up, weights, up, weights)[1]) == 100
    assert mean_angle((up, weights), (side, 7 * weights)) == pytest.approx(np.pi / 2, abs=1e-12)


def test_extreme_weights_neither_overflow_nor_vanish():
    ends = np.array([[0.0, 0, 1], [1, 0, 0]])
    for scale in (1e308, 1e-320):
        angle = mean_angle((ends, [scale, scale]), (ends[1:], [1.0]))
        assert angle == pytest.approx(np.pi / 4, abs=1e-12)
    assert transport_plan(ends, [1e300, 1e-300], ends, [1.0, 0.0])[1].tolist() == [[0, 0]]


def test_equal_weights_in_another_order_leave_no_pairs_of_rounding():
    pairs = transport_plan(np.eye(3), np.full(3, 1.0), np.eye(3)[::-1], np.full(3, 0.1))[1]
    assert pairs.tolist() == [[0, 2], [1, 1], [2, 0]]


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("from_weights", [0.0], "from_weights must hold a number above 0; the sum is 0"),
        ("to_weights", [-1.0], "to_weights must not be negative; row 0 holds -1"),
        ("to_weights", [np.inf], "to_weights must be finite; row 0 holds inf"),
        ("to_weights", [1.0, 1.0], r"to_weights must have as many rows as to_directions \(1\)"),
        ("from_directions", [[0, 0, 2]], "from_directions 0 has length 2"),
        ("from_directions", [[0, 1]], r"from_directions must have the shape \(n, 3\)"),
        ("to_directions", np.zeros((0, 3)), "to_weights must have as many rows"),
    ],
)
def test_bad_input_is_refused_by_name(name, value, message):
    arguments = {
        "from_directions": [[0, 0, 1]],
        "from_weights": [1.0],
        "to_directions": [[0, 1, 0]],
        "to_weights": [1.0],
    }
    with pytest.raises(el.EnvLightsError, match=message):
        transport_plan(**arguments | {name: value})
