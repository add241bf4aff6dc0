"""Local solvers from one start: ours, scipy's three and jaxopt's.

All start from the same directions with the best radiances for these, none negative. The peers
without bounds count where they end without a negative radiance. Below a difference of 1e-6 of the
cost, two ends are the same. "we search" is our whole search, which needs no start.
"""

from collections import defaultdict

import numpy as np
import probes
from tests.helpers import NORMALS, SOLID_ANGLES
from tests.reference.peers import PEERS, Problem, even, ours, ours_from

from envlights import kernels

#: Of the cost, as a share of what is to be explained: differences below are rounding.
ROUNDING = 1e-13
#: Angle of the starts from our own answer, in degrees.
BESIDE = (0, 1, 10)


def table(every):
    irradiances = dict(list(probes.real_and_generated().items())[::every])
    print(
        f"\ncosts from one start, {len(irradiances)} maps, 1 to 8 lights, with ambient and without"
    )
    print(
        f"{'start':<26}{'peer':<9}{'cases':>6}{'possible':>10}{'the same':>10}"
        f"{'ours lower':>12}{'theirs lower':>14}{'median, worst of these':>25}"
    )
    ratios = defaultdict(list)
    rng = np.random.default_rng(1)
    for irradiance in irradiances.values():
        for ambient in ("constant", "none"):
            for lights in range(1, 9):
                given = NORMALS, SOLID_ANGLES, irradiance
                for key, value in costs(Problem(*given, lights, ambient), rng):
                    ratios[key].append(value)
    for key in sorted(ratios):
        print(row(*key, ratios[key]))


def costs(problem, rng):
    """Yield start and peer, and our cost over theirs; None where theirs is impossible."""
    answer = ours(problem)
    problem = problem.with_lights(len(answer.lights))
    for start, directions in starts(answer.lights.direction, rng):
        mine = ours_from(problem, directions).error ** 2
        at = problem.unknowns(ours(problem, fixed=directions))
        for name, solve in PEERS.items():
            end = solve(problem, at)
            is_possible = problem.is_possible(end)
            for title, cost in ((start, mine), (f"{start}, we search", answer.error**2)):
                share = (cost + ROUNDING) / (problem.fraction(end) + ROUNDING)
                yield (title, name), share if is_possible else None


def starts(answer, rng):
    lights = len(answer)
    for degrees in BESIDE:
        moved = answer + np.deg2rad(degrees) * rng.normal(size=answer.shape) / np.sqrt(2)
        moved /= np.linalg.norm(moved, axis=1, keepdims=True)
        yield f"{degrees:>2}° from ours", moved
    yield "even", even(lights)
    yield "random", kernels.uniform_sphere(rng.uniform(size=(lights, 2)))


def row(start, peer, ratios):
    possible = np.array([value for value in ratios if value is not None])
    higher, lower = possible[possible > 1 + 1e-6], possible[possible < 1 - 1e-6]
    same = len(possible) - len(higher) - len(lower)
    numbers = f"{len(ratios):>6}{len(possible):>10}{same:>10}{len(lower):>12}{len(higher):>14}"
    worst = f"{np.median(higher):>14.6f}{higher.max():>11.4f}" if len(higher) else ""
    return f"{start:<26}{peer:<9}{numbers}{worst}"
