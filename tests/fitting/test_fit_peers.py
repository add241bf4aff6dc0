"""The fit against other people's solvers, against infinitely many normals, and light by light."""

from functools import cache

import numpy as np
import pytest

import envlights as el
from envlights import kernels
from tests.conftest import real_maps
from tests.helpers import EQUIRECTANGULAR, paths_of_real_maps
from tests.reference import closed_form
from tests.reference.peers import PEERS, Problem, even, ours, ours_from

NORMALS, SOLID_ANGLES = kernels.icosphere(320)
AMBIENTS = ("constant", "none")
SCIPY = ("bounded", "trf", "lm")

#: Of the cost, as a share of what is to be explained: differences below are rounding.
ROUNDING = 1e-13


def probe_of(env):
    """Its greatest irradiance 1, so that one kind of start suits all."""
    irradiance = env.probe(NORMALS)
    return irradiance / irradiance.max()


def probe_of_world(world):
    return probe_of(el.EnvMap(world.radiance))


HALL = probe_of_world(el.synthetic.hall(128))


@cache
def some_generated():
    probes = {"hall": HALL}
    for seed in el.synthetic.EVALUATION[:3]:
        probes[f"plain {seed}"] = probe_of_world(el.synthetic.plain(seed, 128))
        probes[f"hard {seed}"] = probe_of_world(el.synthetic.hard(seed, 128))
    return probes


@cache
def some_probes():
    """Probes of generated maps, and of the available real maps."""
    real = paths_of_real_maps("hdr/*.hdr")
    return some_generated() | {path.name: probe_of(el.EnvMap.open(path)) for path in real}


def problems(irradiance, counts):
    for ambient in AMBIENTS:
        for lights in counts:
            yield Problem(NORMALS, SOLID_ANGLES, irradiance, lights, ambient)


# From one start


def ratio(ours, theirs):
    """Ratio of two relative costs; 1 if both are rounding."""
    return (ours + ROUNDING) / (theirs + ROUNDING)


def lies_in_a_crease(rig):
    """True if a light lies on the horizon of a normal, where the cost has a kink."""
    return bool((np.abs(NORMALS @ rig.lights.direction.T) < 1e-6).any())


def assert_no_peer_improves(rig, problem, peers):
    problem = problem.with_lights(len(rig.lights))
    answer = problem.unknowns(rig)
    for name in peers:
        theirs = PEERS[name](problem, answer)
        if problem.is_possible(theirs):
            gain = ratio(problem.fraction(answer), problem.fraction(theirs)) - 1
            assert gain <= 1e-6, f"{name}, {problem.lights} lights, {problem.ambient}: {gain}"


def assert_no_peer_improves_our_answer(irradiance, counts, peers):
    for problem in problems(irradiance, counts):
        assert_no_peer_improves(ours(problem), problem, peers)


def test_no_solver_of_scipy_improves_our_answer_on_the_hall():
    assert_no_peer_improves_our_answer(HALL, range(1, 9), SCIPY)


@pytest.mark.slow
def test_jaxopt_does_not_improve_our_answer_on_the_hall():
    pytest.importorskip("jaxopt")
    assert_no_peer_improves_our_answer(HALL, (1, 4), ["jaxopt"])


@pytest.mark.slow
def test_an_answer_in_a_crease_is_at_the_bottom_of_it():
    """There no step across leads down, but one along it may: of a bent cost only half is known."""
    creased = 0
    for irradiance in some_generated().values():
        for problem in problems(irradiance, range(3, 9)):
            rig = ours(problem)
            if lies_in_a_crease(rig):
                assert_no_peer_improves(rig, problem, SCIPY)
                creased += 1
    assert creased >= 4


@real_maps(*EQUIRECTANGULAR)
def test_no_solver_of_scipy_improves_our_answer_on_real_maps(path):
    assert_no_peer_improves_our_answer(probe_of(el.EnvMap.open(path)), range(1, 9), SCIPY)


def a_degree_beside(directions, rng):
    moved = directions + np.deg2rad(1) * rng.normal(size=directions.shape) / np.sqrt(2)
    return moved / np.linalg.norm(moved, axis=1, keepdims=True)


@pytest.mark.slow
@pytest.mark.parametrize("peer", ["bounded", "lm"])
def test_from_a_degree_beside_the_answer_no_peer_ends_lower(peer):
    """Both start with the best radiances for the directions of the start."""
    rng = np.random.default_rng(7)
    ratios = []
    for irradiance in some_probes().values():
        for problem in problems(irradiance, range(1, 5)):
            answer = ours(problem)
            problem = problem.with_lights(len(answer.lights))
            start = a_degree_beside(answer.lights.direction, rng)
            theirs = PEERS[peer](problem, problem.unknowns(ours(problem, fixed=start)))
            if problem.is_possible(theirs):
                cost = ours_from(problem, start).error ** 2
                ratios.append(ratio(cost, problem.fraction(theirs)))
    # Between start and end lie creases, and beyond each another minimum: not all end in the same.
    assert len(ratios) > 40
    assert np.mean(np.array(ratios) <= 1 + 1e-6) >= 0.98
    assert max(ratios) <= 1.001


def assert_no_peer_ends_lower_than_the_search(irradiance, peers):
    """Many local minima surround the best one; the search must leave all of them.

    One case of a map may cost up to 3 % more, with 8 lights: a search whose starts have one more
    light than they keep would find it, in 2 of 480 cases, and is not worth its code.
    """
    gains = []
    for problem in problems(irradiance, range(1, 9)):
        cost = ours(problem).error ** 2
        start = problem.unknowns(ours(problem, fixed=even(problem.lights)))
        for name in peers:
            theirs = PEERS[name](problem, start)
            if problem.is_possible(theirs):
                gain = ratio(cost, problem.fraction(theirs)) - 1
                case = problem.lights, problem.ambient
                gains.append((gain, case, name))
    missed = {case for gain, case, _ in gains if gain > 1e-6}
    assert missed <= {(8, max(gains)[1][1])}, gains
    assert max(gains)[0] <= 0.03, max(gains)


@pytest.mark.slow
def test_from_even_starts_no_solver_of_scipy_ends_lower_than_the_search():
    for irradiance in some_generated().values():
        assert_no_peer_ends_lower_than_the_search(irradiance, SCIPY)


@pytest.mark.slow
@real_maps(*EQUIRECTANGULAR)
def test_from_even_starts_no_solver_of_scipy_ends_lower_than_the_search_on_real_maps(path):
    assert_no_peer_ends_lower_than_the_search(probe_of(el.EnvMap.open(path)), SCIPY)


@pytest.mark.slow
@real_maps("hdr/*.hdr")
def test_from_its_own_starts_jaxopt_does_not_end_lower_than_the_search_on_real_maps(path):
    """From even ones and from two that are drawn."""
    pytest.importorskip("jaxopt")
    irradiance = probe_of(el.EnvMap.open(path))
    for problem in problems(irradiance, (1, 2, 4)):
        cost = ours(problem).error ** 2
        rng = np.random.default_rng(problem.lights)
        starts = [problem.unknowns(ours(problem, fixed=even(problem.lights)))]
        starts += [problem.random_start(rng) for _ in range(2)]
        for start in starts:
            theirs = PEERS["jaxopt"](problem, start)
            if problem.is_possible(theirs):
                gain = np.sqrt(ratio(cost, problem.fraction(theirs)))
                assert gain <= 1 + 1e-6, f"{problem.lights} lights, {problem.ambient}: {gain}"


@pytest.mark.slow
def test_the_search_never_ends_higher_than_the_even_start_of_the_paper():
    for name, irradiance in some_probes().items():
        for problem in problems(irradiance, range(1, 9)):
            searched, started = ours(problem).error, ours(problem, start="even").error
            case = f"{name}, {problem.lights} lights, ambient {problem.ambient}"
            assert ratio(searched**2, started**2) <= 1 + 1e-6, case


@pytest.mark.slow
def test_the_search_ends_where_the_best_of_random_starts_does():
    ratios = {}
    for name, irradiance in some_probes().items():
        for problem in problems(irradiance, (1, 2, 4)):
            rng = np.random.default_rng(problem.lights)
            starts = [problem.random_start(rng) for _ in range(6)]
            best = min(problem.fraction(PEERS["bounded"](problem, start)) for start in starts)
            case = f"{name}, {problem.lights} lights, ambient {problem.ambient}"
            ratios[case] = np.sqrt(ratio(ours(problem).error ** 2, best))
    worst = max(ratios, key=ratios.get)
    assert ratios[worst] <= 1.05, f"{worst}: {ratios[worst]}"
    assert np.mean(np.array(list(ratios.values())) <= 1.01) >= 0.95, ratios


# At infinitely many normals


def random_world(points, seed):
    """Suns of very different strength before an even sky."""
    rng = np.random.default_rng(seed)
    towards = rng.normal(size=(points, 3))
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    irradiance = rng.gamma(0.5, size=(points, 1)) * rng.uniform(0.5, 1.0, size=(points, 3))
    return closed_form.World(towards, irradiance, rng.uniform(0.05, 0.2, size=3))


def world_of_pixels(radiance):
    """A map whose pixels are point sources."""
    height, width, _ = radiance.shape
    flux = radiance * kernels.pixel_solid_angles(height, width)[..., None]
    towards = kernels.pixel_directions(height, width).reshape(-1, 3)
    return closed_form.World(towards, flux.reshape(-1, 3).astype(float), np.zeros(3))


def test_the_closed_form_is_the_sum_over_many_normals():
    world, other = random_world(5, seed=1), random_world(3, seed=2)
    normals, solid_angles = kernels.icosphere(20480)
    summed = np.sum(solid_angles[:, None] * world.probe(normals) * other.probe(normals))
    assert closed_form.products(world, other) == pytest.approx(summed, rel=1e-5)


def test_the_closed_form_has_the_gradient_that_it_claims():
    world, at = random_world(12, seed=3), np.random.default_rng(4).normal(size=9)
    _, gradient = closed_form.cost_and_gradient(at, world)
    step = 1e-6
    for i, slope in enumerate(gradient):
        ahead, behind = (
            closed_form.cost_and_gradient(at + s * np.eye(9)[i], world)[0] for s in (step, -step)
        )
        assert (ahead - behind) / (2 * step) == pytest.approx(slope, abs=1e-9)


def assert_agrees_with_the_closed_form(world, lights):
    normals, solid_angles = kernels.icosphere(20480)
    rig = el.fit_probe(normals, world.probe(normals), lights, weights=solid_angles)
    assert len(rig.lights) == lights
    ours = closed_form.World(rig.lights.direction, rig.lights.irradiance, rig.ambient)
    best, least = closed_form.fit(world, rig.lights.direction)
    assert rig.error == pytest.approx(np.sqrt(least), abs=1e-4)
    assert closed_form.cost(ours, world) == pytest.approx(least, rel=1e-4)
    # The cost is flat at its minimum: there directions may differ by much more than it does.
    assert np.sqrt(closed_form.cost(best, ours)) < 1e-3
    rng = np.random.default_rng(lights)
    elsewhere = min(closed_form.fit(world, rng.normal(size=(lights, 3)))[1] for _ in range(3))
    assert elsewhere >= least * (1 - 1e-6)


@pytest.mark.parametrize("lights", [1, 2, 3, 4])
@pytest.mark.parametrize("points", [5, 30])
def test_twenty_thousand_normals_are_as_good_as_all_under_suns(points, lights):
    assert_agrees_with_the_closed_form(random_world(points, seed=points), lights)


@pytest.mark.parametrize("lights", [1, pytest.param(3, marks=pytest.mark.slow)])
def test_twenty_thousand_normals_are_as_good_as_all_in_the_hall(lights):
    assert_agrees_with_the_closed_form(world_of_pixels(el.synthetic.hall(16).radiance), lights)


def test_suns_that_are_as_many_as_the_lights_come_back_from_the_closed_form():
    world = random_world(3, seed=5)
    normals, solid_angles = kernels.icosphere(20480)
    rig = el.fit_probe(normals, world.probe(normals), 3, weights=solid_angles)
    best, _ = closed_form.fit(world, rig.lights.direction)
    np.testing.assert_allclose(rig.lights.direction, best.direction, atol=1e-4)
    np.testing.assert_allclose(rig.lights.irradiance, best.irradiance, rtol=1e-4)
    np.testing.assert_allclose(rig.ambient, best.ambient, rtol=1e-4)


# Light by light


@real_maps(*EQUIRECTANGULAR)
def test_one_percent_is_reached_and_not_with_one_light_less(path):
    env = el.EnvMap.open(path)
    rig = el.fit(env, error=0.01)
    assert rig.error <= 0.01
    assert rig.report.stop_reason.is_success
    if len(rig.lights):
        assert el.fit(env, lights=len(rig.lights) - 1).error > 0.01
