"""Run time and memory of the functions that read a whole map, relative to one pass over it.

Times are the least of several; only their ratios mean anything on a shared machine.
Usage: RAYON_NUM_THREADS=2 python benchmarks/probe.py
"""

import os
import resource

import numpy as np
from stopwatch import compare

import envlights as el
from envlights import kernels

NORMALS, SOLID_ANGLES = kernels.icosphere(320)


def sunny_map(height):
    """Drawn in place and in float32: a larger array before would hide what is measured after."""
    radiance = np.empty((height, 2 * height, 3), np.float32)
    np.random.default_rng(0).standard_gamma(0.5, dtype=np.float32, out=radiance)
    radiance[height // 3, height // 2] = 5e4
    return radiance


def megabytes():
    """Peak memory of this process, in megabytes."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def memory(radiance):
    """Print the memory that each call adds, beyond what the calls need on any map."""
    tiny = sunny_map(64)
    work = {
        "env.probe, 320 normals": lambda array: el.EnvMap(array).probe(NORMALS),
        "el.fit(array, lights=4)": lambda array: el.fit(array, lights=4),
        "a copy of the map": np.copy,
    }
    for piece in work.values():
        piece(tiny)
    print(f"\nmemory beside a map of {radiance.nbytes / 2**20:.0f} MB")
    for name, piece in work.items():
        before = megabytes()
        piece(radiance)
        print(f"  {name:<52}{megabytes() - before:>9.1f} MB")


def times(radiance):
    env = el.EnvMap(radiance)
    work = {
        "array.max()": radiance.max,
        "EnvMap(array): look for unusable samples": lambda: el.EnvMap(radiance),
        "env.probe, 320 normals (target: 3 x)": lambda: env.probe(NORMALS),
        "working map, 320 normals": lambda: kernels.working_irradiance(radiance, NORMALS),
        "el.fit(array, lights=4) (target: 4 x)": lambda: el.fit(radiance, lights=4),
    }
    threads = os.environ.get("RAYON_NUM_THREADS", os.cpu_count())
    compare(f"4096x2048 float32, {threads} threads", work)
    working, _ = kernels.working_irradiance(radiance, NORMALS)
    error = kernels.relative_rms(working, env.probe(NORMALS), SOLID_ANGLES)
    print(f"  the working map is {error:.1e} from env.probe")


if __name__ == "__main__":
    large = sunny_map(2048)
    memory(large)
    times(large)
