"""Run time of probe and fit against what they are compared with, in one run.

Times are the least of several; only their ratios mean anything on a shared machine. Errors stand
beside the times. Usage: RAYON_NUM_THREADS=2 python benchmarks/probe_and_fit.py
"""

import os
import resource
import sys
import time
from pathlib import Path

import numpy as np

import envlights as el
from envlights import kernels

sys.path.insert(0, str(Path(__file__).parents[1]))
from tests.twins.madsen import Problem


def seconds(work, repeats=7):
    work()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


def sunny_map(height):
    rng = np.random.default_rng(0)
    radiance = rng.gamma(0.5, 1.0, size=(height, 2 * height, 3)).astype(np.float32)
    radiance[height // 3, height // 2] = 5e4
    return radiance


def peak_megabytes():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def row(name, value, base, note=""):
    print(f"{name:<48}{1e3 * value:>9.2f} ms{value / base:>8.2f} x  {note}")


def large_map():
    """Everything in units of one look at every sample."""
    radiance = sunny_map(2048)
    normals, solid_angles = kernels.icosphere(320)
    print(f"4096x2048 float32, {os.environ.get('RAYON_NUM_THREADS', os.cpu_count())} threads")
    base = seconds(radiance.max)
    row("array.max()", base, base)
    row("EnvMap(array): look for unusable samples", seconds(lambda: el.EnvMap(radiance)), base)
    env = el.EnvMap(radiance)
    before = peak_megabytes()
    row("env.probe, 320 normals", seconds(lambda: env.probe(normals)), base, "target 3 x")
    row("el.fit(array, lights=4)", seconds(lambda: el.fit(radiance, lights=4)), base)
    grown = peak_megabytes() - before
    print(f"memory grew by {grown:.1f} MB while the map holds {radiance.nbytes / 2**20:.0f} MB")
    working, _ = kernels.working_irradiance(radiance, normals)
    error = kernels.relative_rms(working, env.probe(normals), solid_angles)
    row(
        "working map, 320 normals",
        seconds(lambda: kernels.working_irradiance(radiance, normals)),
        base,
        f"error {error:.1e}",
    )


def small_map():
    """The fit beside scipy's bounded one from one start."""
    radiance = np.ascontiguousarray(el.synthetic.hall(512).radiance)
    normals, solid_angles = kernels.icosphere(320)
    irradiance = el.EnvMap(radiance).probe(normals)
    print("\n1024x512 float32, the demo hall")
    base = seconds(lambda: el.fit(radiance, lights=4))
    row("el.fit(array, lights=4)", base, base, "target 10 ms")
    for lights in (1, 2, 4, 8):
        ours = seconds(lambda m=lights: el.fit_probe(normals, irradiance, m, weights=solid_angles))
        error = el.fit_probe(normals, irradiance, lights, weights=solid_angles).error
        row(f"fit_probe, {lights} lights", ours, base, f"error {100 * error:.3f} %")
        problem = Problem(normals, solid_angles, irradiance, lights)
        start = problem.random_start(np.random.default_rng(1))
        theirs = seconds(lambda p=problem, s=start: p.solve(s), repeats=3)
        energy = np.sum(solid_angles[:, None] * irradiance**2)
        error = np.sqrt(2 * problem.solve(start).cost / energy)
        row(
            f"scipy, bounded, one start, {lights} lights",
            theirs,
            base,
            f"error {100 * error:.3f} %",
        )


if __name__ == "__main__":
    large_map()
    small_map()
