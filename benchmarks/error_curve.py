"""Time of an error curve to 8 lights over that of the fit with 8 lights, on one thread.

Maps are those of ENVLIGHTS_MAPS, at most 512 columns wide. Both times are the least of three runs.
"""

import os
from itertools import islice
from pathlib import Path
from time import perf_counter

import numpy as np

import envlights as el

LIGHTS = range(9)
WIDTH = 512


def main():
    el.threads(1)
    ratios = []
    print(f"{'map':<32}{'fit, s':>8}{'curve, s':>10}{'ratio':>7}")
    for name, env in islice(maps(), 9):
        fit = least(lambda env=env: el.fit(env, max(LIGHTS)))
        curve = least(lambda env=env: el.error_curve(env, LIGHTS))
        ratios.append(curve / fit)
        print(f"{name:<32}{fit:>8.3f}{curve:>10.3f}{ratios[-1]:>7.1f}")
    print(f"median ratio {np.median(ratios):.1f}, from {min(ratios):.1f} to {max(ratios):.1f}")


def least(work, runs=3):
    """Least wall time of some runs."""
    times = []
    for _ in range(runs):
        start = perf_counter()
        work()
        times.append(perf_counter() - start)
    return min(times)


def maps():
    """Whole maps of the folder, in the order of their names."""
    for path in sorted(Path(os.environ["ENVLIGHTS_MAPS"]).rglob("*")):
        if path.suffix in (".hdr", ".exr"):
            try:
                env = el.EnvMap.open(path)
            except el.EnvLightsError:
                continue
            if env.coverage is None:
                yield path.name, env.resized(min(env.width, WIDTH))


if __name__ == "__main__":
    main()
