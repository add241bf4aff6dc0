"""Run time against the number of pixels, beside one pass of NumPy over the same map."""

from functools import partial

import numpy as np
from curves.results import Point, timed

import envlights as el
from envlights import kernels

TITLE = "Run time by size of the map"
READ = ""
ERRORS = {}
OURS = ("EnvMap(array)", "env.probe, 320 normals", "detect", "fit, 4 lights")
HEIGHTS = (256, 512, 1024, 2048, 4096)
NORMALS, _ = kernels.icosphere(320)

METHODS = {
    "array.max()": lambda radiance: radiance.max(),
    "array.copy()": lambda radiance: radiance.copy(),
    "EnvMap(array)": el.EnvMap,
    "env.probe, 320 normals": lambda radiance: kernels.irradiance(radiance, NORMALS),
    "detect": el.detect,
    "fit, 4 lights": lambda radiance: el.fit(radiance, lights=4),
}


def points(_, effort):
    """Yield a point for each method and height of a map with a sun; the setting is its pixels."""
    small = el.synthetic.hall(HEIGHTS[0]).radiance
    for height in HEIGHTS:
        times = height // HEIGHTS[0]
        radiance = np.ascontiguousarray(small.repeat(times, axis=0).repeat(times, axis=1))
        work = {method: partial(run, radiance) for method, run in METHODS.items()}
        for run in work.values():
            run()
        for method, (seconds, spread) in timed(work, effort).items():
            yield Point("scale", "hall", method, 2 * height**2, seconds, spread, {})
