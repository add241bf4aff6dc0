"""Run time and memory by the number of pixels, lights, normals and images.

All maps repeat the pixels of the generated hall. The fits and the probes of many normals use
1024x512 pixels. The images are pairs of the generated room at rank 16. One pass of NumPy over the
same map is measured as well. Memory is the peak of a process beyond its memory before the call, on
Linux, from 2048x1024 on.
"""

import sys
from functools import partial

import memory
import numpy as np
from curves.results import point, run_times

import envlights as el
from envlights import kernels

TITLE = "Run time and memory by size"
READ = ""
#: Of the tables.
SAID = (
    "The exponent of a power law is a line through the three largest; the bandwidth is that of"
    " `array.max()` on the largest map."
)
ERRORS = {}
#: Errors that are none but measured, in megabytes.
MEMORY = ("memory",)
OURS = (
    "EnvMap(array)",
    "env.probe, 320 normals",
    "detect",
    "fit, 4 lights",
    "fit",
    "fit, points",
    "env.probe",
    "working map",
    "TransferModel.fit",
)
#: Up to 16384 columns, and of a quick run; those whose memory is measured.
HEIGHTS, FEW_HEIGHTS = (256, 512, 1024, 2048, 4096, 8192), (256, 512, 1024)
MEASURED = (1024, 4096, 8192)
LIGHTS = (1, 2, 4, 8, 16, 32, 64)
#: Of icospheres.
NORMALS = (20, 80, 320, 1280, 5120)
IMAGES = (12, 24, 48, 96)

METHODS = {
    "array.max()": lambda radiance: radiance.max(),
    "array.copy()": lambda radiance: radiance.copy(),
    "EnvMap(array)": el.EnvMap,
    "env.probe, 320 normals": lambda radiance: kernels.irradiance(
        radiance, kernels.icosphere(320)[0]
    ),
    "detect": el.detect,
    "fit, 4 lights": lambda radiance: el.fit(radiance, lights=4),
}


def are_comparable(our, their):
    """On a map of the same size."""
    return our.setting == their.setting


def points(_, effort):
    """Yield a point for each method and size; the case is what grows."""
    half = effort._replace(seconds=effort.seconds / 2)
    has_memory = effort.is_judged and not effort.is_quick and sys.platform == "linux"
    for case, size, work in _all(effort.is_quick):
        is_told = case == "pixels" and has_memory and size in {2 * height**2 for height in MEASURED}
        peaks = {method: {"memory": peak(method, size)} for method in work if is_told}
        for run in work.values():
            run()
        for method, seconds in run_times(work, half).items():
            yield point("scale", case, method, size, peaks.get(method, {}), call=[seconds])


def _all(is_quick):
    """Cases: the quantity that grows, its size, and the calls of the methods."""
    few = 4 if is_quick else None
    for height in FEW_HEIGHTS if is_quick else HEIGHTS:
        radiance = hall(height)
        yield (
            "pixels",
            2 * height**2,
            {name: partial(run, radiance) for name, run in METHODS.items()},
        )
    radiance = hall(512)
    for count in LIGHTS[:few]:
        points = partial(el.fit, radiance, count, sizes=False)
        yield "lights", count, {"fit": partial(el.fit, radiance, count), "fit, points": points}
    for count in NORMALS[:few]:
        kinds = {"env.probe": kernels.irradiance, "working map": kernels.working_irradiance}
        normals, _ = kernels.icosphere(count)
        yield "normals", count, {name: partial(f, radiance, normals) for name, f in kinds.items()}
    room = el.synthetic.room(IMAGES[-1], width=64)
    for count in IMAGES[:few]:
        pairs = room.direct[:count], room.indirect[:count]
        yield "images", count, {"TransferModel.fit": partial(el.TransferModel.fit, *pairs, 16)}


def hall(height):
    """The hall of the demo, each pixel repeated."""
    small = el.synthetic.hall(256).radiance.astype(np.float32)
    times = height // 256
    return np.ascontiguousarray(small.repeat(times, axis=0).repeat(times, axis=1))


def peak(method, pixels):
    """Peak megabytes of a call, beyond those of its process before it."""
    return memory.alone(_memory_growth, method, pixels) / 2**20


def _memory_growth(method, pixels):
    radiance = hall(int((pixels / 2) ** 0.5))
    METHODS[method](hall(256))  # What the first call of all makes is no part of it.
    return memory.peak(partial(METHODS[method], radiance))
