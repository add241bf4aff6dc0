"""Error of `fit` against the lowest that wide searches find, evaluated at 20480 normals.

The wide searches: `fit` from random directions; `fit_probe` on 5120 normals, afresh and from the
answer of `fit`; scipy's bounded solver from random starts on 1280 normals, the best of them
refined by `fit_probe` on 5120. The lowest error of all counts.
"""

from collections import defaultdict
from zlib import crc32

import numpy as np
import probes
from tests.reference import peers

import envlights as el
from envlights import kernels

LIGHTS = range(1, 9)
AMBIENTS = ("constant", "none", "sh2")
#: Errors below this count as equal: the working map of `fit` has no smaller one.
FLOOR = 1e-4
#: Normals of scipy's problem, of the descents to the bottom, and of the errors.
ROUGH, DENSE, EVALUATION = (kernels.icosphere(count) for count in (1280, 5120, 20480))


def table(every, starts, scipy_starts):
    maps = dict(list(probes.maps().items())[::every])
    title = f"error of fit over the lowest of {starts} random starts of it"
    print(f"\n{title}, fit_probe on 5120 normals, {scipy_starts} random starts of scipy")
    print(f"{len(maps)} maps, each ambient term; equal below {FLOOR:g}")
    print(f"{'lights':>6}{'cases':>7}{'<= 1.002':>11}{'<= 1.005':>11}{'worst':>8}  where; won by")
    everything = {}
    for lights in LIGHTS:
        cases = {}
        for name, env in maps.items():
            for ambient in AMBIENTS:
                rng = np.random.default_rng([crc32(name.encode()), lights])
                case = Case(env, lights, ambient)
                cases[name, ambient, lights] = case.compared(rng, starts, scipy_starts)
        print(row(lights, cases), flush=True)
        everything |= cases
    print(row("all", everything))


class Case:
    """Fits of some lights and one ambient term to one map."""

    def __init__(self, env, lights, ambient):
        self.env, self.lights, self.ambient = env, lights, ambient
        self.dense, self.irradiance = env.probe(DENSE[0]), env.probe(EVALUATION[0])

    def compared(self, rng, starts, scipy_starts):
        """Ratio of our error to the lowest, and the search that found it."""
        ours = el.fit(self.env, self.lights, ambient=self.ambient, sizes=False)
        rigs = {"fit": [ours], "fit_probe": [self.on_dense(), self.on_dense(ours)]}
        rigs["random"] = [
            el.fit(self.env, self.lights, ambient=self.ambient, start=self.random(rng), sizes=False)
            for _ in range(starts)
        ]
        if self.ambient != "sh2":  # has no place in the peers' equations
            rigs["scipy"] = [self.on_dense(self.best_of_scipy(rng, scipy_starts))]
        errors = {who: min(map(self.error, some)) for who, some in rigs.items() if some}
        least = min(errors, key=errors.get)
        return max(errors["fit"], FLOOR) / max(errors[least], FLOOR), least

    def on_dense(self, start="greedy"):
        """The fit to 5120 normals."""
        given = {"weights": DENSE[1], "ambient": self.ambient, "start": start}
        return el.fit_probe(DENSE[0], self.dense, self.lights, **given)

    def random(self, rng):
        """Lights in random directions."""
        return directions(kernels.uniform_sphere(rng.uniform(size=(self.lights, 2))))

    def best_of_scipy(self, rng, starts):
        """Directions of the best of random starts."""
        irradiance = self.env.probe(ROUGH[0])
        problem = peers.Problem(*ROUGH, irradiance / irradiance.max(), self.lights, self.ambient)
        ends = [
            peers.by_scipy(problem, problem.random_start(rng), has_bounds=True, tolerance=1e-8)
            for _ in range(starts)
        ]
        _, towards, _ = kernels.unpack_lights(problem.whole(min(ends, key=problem.fraction)))
        return directions(towards)

    def error(self, rig):
        """Relative error at the evaluation normals."""
        return kernels.relative_rms(rig.probe(EVALUATION[0]), self.irradiance, EVALUATION[1])


def directions(towards):
    return el.Lights(towards, np.ones((len(towards), 3)))


def row(title, cases):
    ratios = np.array([ratio for ratio, _ in cases.values()])
    within = "".join(f"{100 * np.mean(ratios <= most):>9.1f} %" for most in (1.002, 1.005))
    worst = sorted(cases, key=lambda case: cases[case][0])[:-3:-1]
    where = "; ".join(f"{' '.join(map(str, case))}: {cases[case][0]:.4f}" for case in worst)
    won = defaultdict(int)
    for ratio, who in cases.values():
        won[who if ratio > 1 + 1e-6 else "fit"] += 1
    return f"{title:>6}{len(ratios):>7}{within}{ratios.max():>8.4f}  {where}; {dict(won)}"
