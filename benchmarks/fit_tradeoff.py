"""Run time and error of several methods on the same maps, evaluated at 20480 normals.

`fit` is timed from the map on; all others get the probe at 320 normals. The error is infinite
where a method returns a negative radiance.
"""

import time
from zlib import crc32

import numpy as np
import probes
from fit_search import EVALUATION, FLOOR
from stopwatch import least_seconds
from tests.helpers import NORMALS, SOLID_ANGLES
from tests.reference import peers

import envlights as el
from envlights import kernels

LIGHTS = (4, 8)
#: Random starts of scipy; the best counts.
STARTS = (1, 10, 100)


def table(every):
    maps = dict(list(probes.maps().items())[::every])
    for lights in LIGHTS:
        cases = [Case(name, env, lights).measure() for name, env in maps.items()]
        errors = {method: np.array([case[method][0] for case in cases]) for method in cases[0]}
        seconds = {method: np.median([case[method][1] for case in cases]) for method in cases[0]}
        title = f"{lights} lights and ambient, {len(cases)} maps"
        print(f"\n{title}; errors relative to the lowest of all methods")
        print(f"{'':<40}{'time':>11}{'<= 1.01':>10}{'median':>8}{'worst':>8}")
        least = np.maximum(np.min(list(errors.values()), axis=0), FLOOR)
        for method, error in errors.items():
            print(row(method, seconds[method], np.maximum(error, FLOOR) / least), flush=True)


def row(method, seconds, ratios):
    within = f"{100 * np.mean(ratios <= 1.01):>8.0f} %{np.median(ratios):>8.3f}"
    return f"{method:<40}{1e3 * seconds:>8.1f} ms{within}{ratios.max():>8.2f}"


class Case:
    """Fits of some lights to one map by all methods."""

    def __init__(self, name, env, lights):
        self.env, self.lights = env, lights
        self.scale = env.probe(NORMALS).max()
        self.irradiance = env.probe(EVALUATION[0])
        self.problem = peers.Problem(NORMALS, SOLID_ANGLES, probes.probe(env), lights)
        self.rng = np.random.default_rng([crc32(name.encode()), lights])

    def measure(self):
        """Error and seconds of each method."""
        problem = self.problem
        even = problem.unknowns(peers.ours(problem, fixed=peers.even(self.lights)))
        with peers.jax_in_float64():
            jaxopt = peers.compiled_jaxopt(problem, even, tolerance=1e-8)
            methods = {
                "fit, from the map on": lambda: el.fit(self.env, self.lights, sizes=False),
                "fit_probe": lambda: peers.ours(problem),
                "jaxopt, even start": lambda: np.asarray(jaxopt()),
                "scipy, bounded, even start": lambda: by_scipy(problem, even),
            }
            answers = {method: solve() for method, solve in methods.items()}  # jaxopt compiles
            seconds = least_seconds(methods, rounds=3)
        first, second, *unknowns = answers
        errors = {
            first: self.error(answers[first].probe(EVALUATION[0])),
            second: self.error(self.scale * answers[second].probe(EVALUATION[0])),
            **{method: self.error_of_unknowns(answers[method]) for method in unknowns},
        }
        return {method: (errors[method], seconds[method]) for method in methods} | self.by_random()

    def by_random(self):
        """Error and seconds of scipy, for the best of some random starts at its normals."""
        problem, best, results = self.problem, None, {}
        begun = time.perf_counter()
        for done in range(1, max(STARTS) + 1):
            end = by_scipy(problem, problem.random_start(self.rng))
            best = end if best is None else min(best, end, key=problem.fraction)
            if done in STARTS:
                seconds = time.perf_counter() - begun
                method = f"scipy, bounded, best of {done} random starts"
                results[method] = self.error_of_unknowns(best), seconds
        return results

    def error_of_unknowns(self, x):
        """Relative error; infinite where a radiance is negative."""
        if not self.problem.is_possible(x):
            return np.inf
        return self.error(self.scale * kernels.probe_model(self.problem.whole(x), EVALUATION[0]))

    def error(self, irradiance):
        """Relative error of the irradiance at the evaluation normals."""
        return kernels.relative_rms(irradiance, self.irradiance, EVALUATION[1])


def by_scipy(problem, start):
    return peers.by_scipy(problem, start, has_bounds=True, tolerance=1e-8)
