"""Time of an error curve to 8 lights over that of the fit with 8 lights, on one thread.

Maps are those of ENVLIGHTS_MAPS, at most 512 columns wide. Both times are the least of three runs.
The last column is the fraction of the curve's time that its 9 fits would take without lights; what
is in it depends on the map alone. It leaves out reading and reducing the map, done once.
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
    rows = []
    print(f"{'map':<32}{'fit, s':>8}{'curve, s':>10}{'ratio':>7}{'without lights':>16}")
    for name, env in islice(maps(), 9):
        fit = least(lambda env=env: el.fit(env, max(LIGHTS)))
        curve = least(lambda env=env: el.error_curve(env, LIGHTS))
        none = least(lambda env=env: el.error_curve(env, [0]).seconds[0], is_timed=True)
        rows.append((curve / fit, len(LIGHTS) * none / curve))
        print(f"{name:<32}{fit:>8.3f}{curve:>10.3f}{rows[-1][0]:>7.1f}{rows[-1][1]:>16.0%}")
    (ratio, none), (low, _), (high, _) = (f(rows, axis=0) for f in (np.median, np.min, np.max))
    print(f"median ratio {ratio:.1f}, from {low:.1f} to {high:.1f}; without lights {none:.0%}")


def least(work, runs=3, *, is_timed=False):
    """Least wall time of some runs, which return their own time if `is_timed`."""
    times = []
    for _ in range(runs):
        start = perf_counter()
        result = work()
        times.append(result if is_timed else perf_counter() - start)
    return min(times)


def maps():
    """Whole maps of the folder, in the order of their names."""
    for path in sorted(Path(os.environ["ENVLIGHTS_MAPS"]).rglob("*")):
        if path.suffix in (".hdr", ".exr"):
            try:
                env = el.EnvMap.open(path)
            except el.EnvLightsError:
                continue
            if env.seen is None:
                yield path.name, env.resized(min(env.width, WIDTH))


if __name__ == "__main__":
    main()
