"""Error of the search of `fit_probe` against the best of many random starts of a local solver.

Two such solvers: scipy's, bounded, with the analytic Jacobian; and our own from given directions,
which is 40 times as fast. On 160 cases, each third map, the best of 200 of ours was within 1.01 of
the best of 100 of scipy's in 99 %, never above 1.03, and below 0.99 in 18 %: the harder test.

Over scipy's on all 480 cases: 98.8 % within 1.01 and the worst 1.03 (2026-11).
"""

from zlib import crc32

import numpy as np
import probes
from tests.helpers import NORMALS, SOLID_ANGLES
from tests.reference.peers import Problem, by_scipy, ours, ours_from

from envlights import kernels

#: Errors below this count as equal: the working map of `fit` has no smaller one.
FLOOR = 1e-4


def best_of_scipy(problem, starts, rng):
    each = (
        by_scipy(problem, problem.random_start(rng), has_bounds=True, tolerance=1e-8)
        for _ in range(starts)
    )
    return np.sqrt(min(map(problem.share, each)))


def best_of_ours(problem, starts, rng):
    uniform = rng.uniform(size=(starts, problem.lights, 2))
    return min(ours_from(problem, kernels.uniform_sphere(uv)).error for uv in uniform)


PEERS = {"scipy": (best_of_scipy, 100), "ours": (best_of_ours, 200)}


def table(every, peer, starts=None):
    best, usual = PEERS[peer]
    starts = starts or usual
    irradiances = dict(list(probes.real_and_generated().items())[::every])
    print(f"\nerror of the search over that of the best of {starts} random starts of {peer}")
    print(f"{len(irradiances)} maps, with ambient and without; equal below {FLOOR:g}")
    print(f"{'lights':>6}{'cases':>7}{'<= 1.01':>9}{'<= 1.05':>9}{'worst':>8}  where")
    everything = {}
    for lights in range(1, 9):
        ratios = {}
        for name, irradiance in irradiances.items():
            for ambient in ("constant", "none"):
                problem = Problem(NORMALS, SOLID_ANGLES, irradiance, lights, ambient)
                rng = np.random.default_rng([crc32(name.encode()), lights])
                ratios[name, ambient] = ratio(problem, best(problem, starts, rng))
        print(row(lights, ratios), flush=True)
        everything |= {(*case, lights): value for case, value in ratios.items()}
    print(row("all", everything))


def ratio(problem, theirs):
    return max(ours(problem).error, FLOOR) / max(theirs, FLOOR)


def row(title, ratios):
    values = np.array(list(ratios.values()))
    within = "".join(f"{100 * np.mean(values <= most):>7.1f} %" for most in (1.01, 1.05))
    worst = sorted(ratios, key=ratios.get)[:-4:-1]
    where = "; ".join(f"{' '.join(map(str, case))}: {ratios[case]:.3f}" for case in worst)
    return f"{title:>6}{len(values):>7}{within}{values.max():>8.3f}  {where}"
