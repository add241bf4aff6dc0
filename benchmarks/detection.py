"""Detectors on the families of synthetic maps with known lights.

Usage: python benchmarks/detection.py [--tuning] [--only NAME ...]

A hit lies within 2 degrees of a light, or within its angular radius where that is more; no light
is hit twice. P, R, F1: precision, recall and their harmonic mean, over all maps of a family, those
without a light included. Angles and flux errors are those of the hits. `false` counts what was
found on maps without a light. Time is the median over the maps, at 1024x512.
"""

import argparse
import time

import numpy as np
from detectors import DETECTORS

from envlights import synthetic

FAMILIES = {
    "plain": synthetic.plain,
    "hard": synthetic.hard,
    "openings": synthetic.openings,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tuning", action="store_true", help="the seeds that thresholds may see")
    parser.add_argument("--only", nargs="+", choices=DETECTORS, default=list(DETECTORS))
    options = parser.parse_args()
    seeds = synthetic.TUNING if options.tuning else synthetic.EVALUATION
    for family, make in FAMILIES.items():
        worlds = [make(seed) for seed in seeds]
        lightless = sum(not len(world.lights) for world in worlds)
        print(
            f"\n{family}, seeds {seeds.start} to {seeds.stop - 1}:"
            f" {sum(len(world.lights) for world in worlds)} lights in {len(worlds)} maps,"
            f" {lightless} of them without a light"
        )
        print(
            f"{'':<24}{'P':>6}{'R':>6}{'F1':>6}{'median':>9}{'95th pct.':>10}"
            f"{'flux error':>12}{'false':>7}{'time':>12}"
        )
        for name in options.only:
            print(row(name, worlds), flush=True)


def row(name, worlds):
    results, seconds = [], []
    for world in worlds:
        start = time.perf_counter()
        found = DETECTORS[name](world.radiance)
        seconds.append(time.perf_counter() - start)
        results.append((world, *found))
    score = synthetic.evaluate(results)
    median, high = np.percentile(score.angles_deg, [50, 95]) if len(score.angles_deg) else (90, 90)
    error = np.median(score.flux_errors) if len(score.flux_errors) else 1.0
    return (
        f"{name:<24}{score.precision:>6.2f}{score.recall:>6.2f}{score.f1:>6.2f}"
        f"{median:>8.3f}°{high:>9.2f}°{error:>12.3f}{score.false_on_lightless:>7}"
        f"{1e3 * np.median(seconds):>9.1f} ms"
    )


if __name__ == "__main__":
    main()
