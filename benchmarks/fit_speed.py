"""Run time of the fit: beside scipy's and jaxopt's descents, and as its input grows.

The search is timed on a map of 256 columns. "All" is the reduction of the map, its field, the
search, and the evaluation at 5120 normals. "Search" is the difference to a fit of no lights.
"Field" is the energy of a map without the reduction. For the peers compare processor times on one
thread.
"""

import functools
import json
import os
import subprocess
import sys
import time
from collections import defaultdict

import numpy as np
import probes
from stopwatch import all_seconds, compare
from tests.helpers import NORMALS, SOLID_ANGLES
from tests.reference import peers

import envlights as el
from envlights import _native, kernels
from envlights.fitting.request import FitOptions

LIGHTS = (1, 2, 4, 8, 16, 32)
NORMAL_COUNTS = (80, 320, 1280, 5120, 20480)
HEIGHTS = (64, 256, 512, 1024, 2048)

#: How maps are reduced: samples in the middles of cells, columns, and the least share of a point.
REDUCED = (False, 256, 5e-3)
NOWHERE = np.zeros((0, 3))

#: The fit within 1 % of each of some maps from scratch; takes their paths and prints seconds.
WITHIN_ONE_PERCENT = """
import inspect, json, sys, time
import envlights as el

# Builds that know no sizes fit points.
points = {"sizes": False} if "sizes" in inspect.signature(el.fit).parameters else {}

def seconds(env):
    start = time.perf_counter()
    el.fit(env, error=0.01, **points)
    return time.perf_counter() - start

maps = {path: el.EnvMap.open(path) for path in sys.argv[1:]}
print(json.dumps({path: min(seconds(env) for _ in range(3)) for path, env in maps.items()}))
"""

#: Fits of ever more lights, "points" or with "sizes"; prints seconds.
BY_LIGHTS = """
import json, sys, time
import envlights as el

def seconds(lights):
    start = time.perf_counter()
    el.fit(radiance, lights, sizes=sys.argv[1] == "sizes")
    return time.perf_counter() - start

radiance = el.synthetic.hall(512).radiance
counts = map(int, sys.argv[2:])
print(json.dumps({m: min(seconds(m) for _ in range(9)) for m in counts}))
"""


def tables(every, before=None):
    maps = dict(list(probes.maps().items())[::every])
    for lights in (4, 8):
        beside_peers(maps, lights)
    by_lights()
    growth(probes.generated_maps()["hall"])
    for size in ((512, 1024), (2048, 4096)):
        beside_one_pass(*size)
    within_one_percent(before)
    next_frame()


#: What the peers are compared with.
BASES = ("all", "search with field", "search")


def beside_peers(maps, lights):
    """Even starts with the best radiances for them; each peer stops where it does by default."""
    seconds = defaultdict(list)
    for env in maps.values():
        for name, value in of_search_and_peers(env, lights).items():
            seconds[name].append(value)
    print(f"\n{lights} lights and ambient, {len(maps)} maps, medians; peers from one even start")
    print(f"{'':<36}{'time':>8}" + "".join(f"{f'over {base}':>25}" for base in BASES))
    for name, values in seconds.items():
        over = [np.divide(values, seconds[base]) for base in BASES]
        ratios = "".join(f"{np.median(r):>10.1f} x, least{r.min():>5.1f} x" for r in over)
        print(f"{name:<36}{1e3 * np.median(values):>5.2f} ms{ratios}", flush=True)


def of_search_and_peers(env, lights):
    """Least seconds of each on one map."""
    small = block_means(env.radiance)
    problem = peers.Problem(NORMALS, SOLID_ANGLES, probes.probe(env), lights)
    start = problem.unknowns(peers.ours(problem, fixed=peers.even(lights)))
    with peers.jax_in_float64():
        jaxopt = peers.compiled_jaxopt(problem, start, tolerance=1e-8)
        jaxopt()  # compiles
        by_scipy = {"has_bounds": True, "tolerance": 1e-8}
        work = {
            "all": lambda: kernel(small, lights),
            "no lights": lambda: kernel(small, 0),
            "reduction and field": lambda: _native.map_energy(small, *REDUCED),
            "reduction": lambda: _native.working_irradiance(small, NOWHERE, *REDUCED),
            "fit_probe, 320 normals": lambda: peers.ours(problem),
            "scipy, bounded, analytic Jacobian": lambda: peers.by_scipy(problem, start, **by_scipy),
            "jaxopt, compiled": jaxopt,
        }
        seconds = all_seconds(work, rounds=15, patience=4.0, clock=time.process_time)
    least = {name: min(found) for name, found in seconds.items()}
    search = least["all"] - least.pop("no lights")
    field = least.pop("reduction and field") - least.pop("reduction")
    return {"search with field": search + field, "search": search, **least}


def kernel(radiance, lights):
    """The whole search for lights and a constant ambient term, and the probe that measures it."""
    options = FitOptions(1, NOWHERE, 0, lights, error_floor=1e-4)
    return _native.fit_reduced(_native.reduce_map(radiance, *REDUCED, False), options, [lights])


def block_means(radiance, columns=256):
    """Means of equal blocks of pixels, in at most that many columns."""
    size = -(-radiance.shape[1] // columns)
    height = radiance.shape[0] // size
    blocks = radiance[: height * size, : 2 * height * size]
    return blocks.reshape(height, size, 2 * height, size, 3).mean(axis=(1, 3))


def by_lights():
    """Time of `fit` by the number of lights, as points and with sizes, on one thread and on two."""
    runs = {(kind, threads): [] for kind in ("points", "sizes") for threads in (1, 2)}
    for _ in range(3):
        for (kind, threads), seconds in runs.items():
            lights = (kind, *LIGHTS)
            seconds.append(run(sys.executable, BY_LIGHTS, lights, RAYON_NUM_THREADS=threads))
    columns = "".join(f"{kind:>9}, {threads}" for kind, threads in runs)
    print(
        f"\nfit(array, lights) of 1024x512, the hall, by kind and threads\n{'lights':>8}{columns}"
    )
    for lights in map(str, LIGHTS):
        times = "".join(f"{1e3 * least(seconds)[lights]:>9.2f} ms" for seconds in runs.values())
        print(f"{lights:>8}{times}")


def run(python, code, arguments, **environment):
    """Run `code` in a new process; return its JSON output."""
    environment = os.environ | {name: str(value) for name, value in environment.items()}
    command = [python, "-c", code, *map(str, arguments)]
    return json.loads(subprocess.check_output(command, env=environment, text=True))


def least(runs):
    return {name: min(run[name] for run in runs) for name in runs[0]}


def growth(hall):
    work = {}
    for count in NORMAL_COUNTS:
        normals, weights = kernels.icosphere(count)
        probe = normals, hall.probe(normals)
        work[f"{count} normals"] = lambda p=probe, w=weights: el.fit_probe(*p, 4, weights=w)
    compare("fit_probe, 4 lights, by the number of normals", work, base="320 normals")
    maps = {f"{2 * h}x{h}": el.synthetic.hall(h).radiance for h in HEIGHTS}
    compare(
        "fit(array, lights=4, sizes=False), by the size of the map",
        {size: lambda r=radiance: el.fit(r, 4, sizes=False) for size, radiance in maps.items()},
        base="1024x512",
    )


def beside_one_pass(height, width):
    """Compare the fit with one pass over the map."""
    rng = np.random.default_rng(0)
    radiance = rng.gamma(0.5, size=(height, width, 3)).astype(np.float32)
    radiance[height // 3, width // 4] = 5e4
    hall = el.synthetic.hall(height).radiance
    for name, array in {"noise and a sun": radiance, "the hall": hall}.items():
        work = {
            "array.max()": array.max,
            "4 points": lambda a=array: el.fit(a, 4, sizes=False),
            "4 lights with a size": lambda a=array: el.fit(a, 4),
            "8 points": lambda a=array: el.fit(a, 8, sizes=False),
            "8 lights with a size": lambda a=array: el.fit(a, 8),
        }
        compare(f"fit of {width}x{height} float32, {name}", work)


def within_one_percent(before):
    """Time of `fit(env, error=0.01)`, points, for all real maps; beside the build of `before`."""
    paths = probes.paths()
    if not paths:
        return
    now = functools.partial(run, sys.executable, WITHIN_ONE_PERCENT, paths)
    runs = [now()]
    title = f"\nfit(env, error=0.01), {len(paths)} real maps in turn"
    if before is None:
        print(f"{title}: {1e3 * sum(runs[0].values()):.0f} ms")
        return
    # Without its path, that Python finds its own build.
    theirs = [run(before, WITHIN_ONE_PERCENT, paths, PYTHONPATH="")]
    runs.append(now())
    ours, theirs = least(runs), least(theirs)
    ratios = np.array([ours[path] / theirs[path] for path in ours])
    totals = sum(ours.values()), sum(theirs.values())
    print(f"{title}: {1e3 * totals[0]:.0f} ms, before {1e3 * totals[1]:.0f} ms")
    by_map = f"by map {np.median(ratios):.3f}, at most {ratios.max():.3f}"
    print(f"  share of the time before: {totals[0] / totals[1]:.3f}; {by_map}")


def next_frame():
    """Two suns and a room; one sun moves by a degree."""

    def frame(angle):
        suns = [(0.6 * np.cos(angle), 0.8, 0.6 * np.sin(angle)), (-0.5, 0.6, 0.6)]
        discs = [el.synthetic.Disc(sun, 3, (90, 80, 70)) for sun in suns]
        room = el.synthetic.hall(256).radiance
        return el.EnvMap(room + el.synthetic.scene(256, background=[0] * 3, shapes=discs).radiance)

    before, after = el.fit(frame(0.0), 4), frame(np.deg2rad(1) / 0.6)
    work = {
        "afresh": lambda: el.fit(after, 4),
        "start=rig": lambda: el.fit(after, 4, start=before),
    }
    compare("a frame later, 4 lights, 512x256", work)
    errors = ", ".join(f"{name} {100 * fit().error:.4f} %" for name, fit in work.items())
    print(f"  errors: {errors}")
