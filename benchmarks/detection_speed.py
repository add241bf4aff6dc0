"""Run time of detection beside that of simpler work, in one run, at equal thread counts.

Measurements take turns and the least of many counts; only their ratios mean anything on a shared
machine. Usage: python benchmarks/detection_speed.py
"""

import argparse
import os
import subprocess
import sys

import cv2
import numpy as np
from stopwatch import compare

import envlights as el
from envlights import synthetic

#: Seed of the usual map: two windows and two pixel suns, glare and lit walls.
_USUAL = 10
_THREADS = "RAYON_NUM_THREADS"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--threads", type=int, help="measure in this process")
    threads = parser.parse_args().threads
    if threads is None:
        # The kernels' threads are counted once, when a process first uses them.
        for threads in (1, 2):
            command = [sys.executable, __file__, "--threads", str(threads)]
            subprocess.run(command, env={**os.environ, _THREADS: str(threads)}, check=True)
        return
    cv2.setNumThreads(threads)
    usual = synthetic.hard(_USUAL).radiance
    print(f"\n{threads} thread{'s' if threads > 1 else ''}")
    whole_way(enlarge(usual, 4))
    if threads == 1:
        methods(usual)
        worst_cases(usual)
    scenes(usual)


def whole_way(radiance):
    """From a large map in memory to lights, beside the reduction of the map alone."""
    height, width, _ = radiance.shape
    compare(
        f"{width}x{height} float32",
        {
            "cv2.resize to 1024x512, INTER_AREA": lambda: cv2.resize(
                radiance, (1024, 512), interpolation=cv2.INTER_AREA
            ),
            "el.detect(array)": lambda: el.detect(radiance),
            "array.max()": lambda: radiance.max(),
        },
        rounds=100,  # two threads that nothing disturbs are rarer than one
    )


def methods(radiance):
    compare(
        "a usual map, 1024x512",
        {
            "loghin": lambda: el.papers.loghin.detect(radiance),
            "tree": lambda: el.detect(radiance),
        },
    )


def worst_cases(usual):
    rng = np.random.default_rng(0)
    maps = {
        "a usual map": usual,
        "white noise": rng.random(usual.shape, dtype=np.float32),
        "heavy-tailed noise": rng.gamma(0.1, size=usual.shape).astype(np.float32),
        "all bright": np.ones_like(usual),
        "all black": np.zeros_like(usual),
    }
    for method, detect in {"tree": el.detect, "loghin": el.papers.loghin.detect}.items():
        compare(
            f"worst cases, 1024x512, {method}",
            {name: lambda r=r, d=detect: d(r) for name, r in maps.items()},
        )


def scenes(usual):
    """Compare scenes of little and much light; print what the report says was skipped."""
    dark = synthetic.scene(
        512, background=[0.01] * 3, shapes=[synthetic.PixelSun((1, 1, 0), [1e3] * 3)]
    ).radiance
    maps = {"dark": dark, "usual": usual, "cluttered": canopy()}
    maps = {name: enlarge(radiance, 4) for name, radiance in maps.items()}
    compare(
        "scenes, 4096x2048",
        {name: lambda r=radiance: el.detect(r) for name, radiance in maps.items()},
        base="usual",
    )
    for name, radiance in maps.items():
        lights = el.detect(radiance)
        print(f"{name}: {len(lights)} lights; skipped: {'; '.join(lights.report.skipped)}")


def canopy():
    """A sky through leaves: thousands of bright gaps of a few pixels, over half of the sphere."""
    rng = np.random.default_rng(0)
    gaps = rng.random((256, 512)) ** 40
    gaps[128:] = 0
    level = np.float32(0.05) + 20 * gaps.repeat(2, axis=0).repeat(2, axis=1).astype(np.float32)
    return np.repeat(level[..., None], 3, axis=2)


def enlarge(radiance, factor):
    return np.ascontiguousarray(radiance.repeat(factor, axis=0).repeat(factor, axis=1))


if __name__ == "__main__":
    main()
