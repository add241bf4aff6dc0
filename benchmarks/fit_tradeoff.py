"""Run time and error of several methods that fit the same probes.

The error is infinite where a method returns a negative radiance.
"""

import time
from zlib import crc32

import numpy as np
import probes
from fit_search import FLOOR
from stopwatch import least_seconds
from tests.helpers import NORMALS, SOLID_ANGLES
from tests.reference import peers

LIGHTS = (4, 8)
#: Random starts of scipy, of which the best counts.
STARTS = (1, 10, 100)


def table(every):
    irradiances = dict(list(probes.real_and_generated().items())[::every])
    for lights in LIGHTS:
        cases = [measured(name, probe, lights) for name, probe in irradiances.items()]
        errors = {method: np.array([case[method][0] for case in cases]) for method in cases[0]}
        seconds = {method: np.median([case[method][1] for case in cases]) for method in cases[0]}
        title = f"{lights} lights and ambient, {len(cases)} maps"
        print(f"\n{title}; errors relative to the lowest of all methods")
        print(f"{'':<40}{'time':>11}{'<= 1.01':>10}{'median':>8}{'worst':>8}")
        least = np.maximum(np.min(list(errors.values()), axis=0), FLOOR)
        for method, error in errors.items():
            print(row(method, seconds[method], np.maximum(error, FLOOR) / least))


def row(method, seconds, ratios):
    within = f"{100 * np.mean(ratios <= 1.01):>8.0f} %{np.median(ratios):>8.3f}"
    return f"{method:<40}{1e3 * seconds:>8.1f} ms{within}{ratios.max():>8.2f}"


def measured(name, irradiance, lights):
    """Error and seconds of each method on one probe."""
    problem = peers.Problem(NORMALS, SOLID_ANGLES, irradiance, lights)
    even = problem.unknowns(peers.ours(problem, fixed=peers.even(lights)))
    rng = np.random.default_rng([crc32(name.encode()), lights])
    with peers.jax_in_float64():
        jaxopt = peers.compiled_jaxopt(problem, even, tolerance=1e-8)
        methods = {
            "fit_probe": lambda: peers.ours(problem).error,
            'fit_probe, start="even"': lambda: peers.ours(problem, start="even").error,
            "jaxopt, even start": lambda: error(problem, np.asarray(jaxopt())),
            "scipy, bounded, even start": lambda: by_scipy(problem, even),
        }
        errors = {method: solve() for method, solve in methods.items()}  # jaxopt compiles
        seconds = least_seconds(methods, rounds=3)
    results = {method: (errors[method], seconds[method]) for method in methods}
    return results | best_of_random(problem, rng)


def error(problem, x):
    """Relative error of the unknowns; infinite where a radiance is negative."""
    return np.sqrt(problem.share(x)) if problem.is_possible(x) else np.inf


def by_scipy(problem, start):
    return error(problem, peers.by_scipy(problem, start, has_bounds=True, tolerance=1e-8))


def best_of_random(problem, rng):
    """Error and seconds of scipy, for the best of some random starts."""
    starts = [problem.random_start(rng) for _ in range(max(STARTS))]
    begun = time.perf_counter()
    ends = [(by_scipy(problem, start), time.perf_counter()) for start in starts]
    errors, times = np.transpose(ends)
    errors, seconds = np.minimum.accumulate(errors), times - begun
    return {
        f"scipy, bounded, best of {n} random starts": (errors[n - 1], seconds[n - 1])
        for n in STARTS
    }
