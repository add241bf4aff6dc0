"""Batches: maps per second on two cores, memory over many maps, and the command against a loop.

Usage: python -m benchmarks.batch [cores] [memory] [command] [--maps N]

Without names, all are measured. Two copies of a busy loop, run in the same rounds as the batches,
say what two cores of this machine give just then.
"""

import argparse
import subprocess
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from benchmarks.memory import _bytes as bytes_of
from benchmarks.memory import alone
from benchmarks.stopwatch import all_seconds

import envlights as el

LOOP = """
import sys
from pathlib import Path
import envlights as el
for path in sorted(Path(sys.argv[1]).glob("*.exr")):
    el.fit(path, lights=2).save(Path(sys.argv[2]) / f"{path.stem}.json")
"""


def main():
    parts = {"cores": cores, "memory": memory, "command": command}
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("parts", nargs="*", metavar="PART")
    parser.add_argument("--maps", type=int, help="instead of 60, 2000 and 200")
    arguments = parser.parse_args()
    for name in arguments.parts or parts:
        parts[name](**({"number": arguments.maps} if arguments.maps else {}))


def write_maps(folder, number):
    for seed in range(number):
        image = el.synthetic.plain(seed, 128).radiance
        el.EnvMap(image).save(Path(folder) / f"{seed:04}.exr")


def cores(number=60):
    """Rates of two jobs over those of one, each median over rounds that alternate."""
    with tempfile.TemporaryDirectory() as folder:
        write_maps(folder, number)
        with ProcessPoolExecutor(2, get_context("spawn")) as pool:
            list(pool.map(busy, [1, 1]))
            seconds = all_seconds(
                {
                    "busy 1": lambda: list(pool.map(busy, [6_000_000])),
                    "busy 2": lambda: list(pool.map(busy, [6_000_000] * 2)),
                    "batch 1": lambda: fit_all(folder, 1),
                    "batch 2": lambda: fit_all(folder, 2),
                },
                rounds=7,
                patience=120,
            )
    once, twice, one, two = map(np.array, seconds.values())
    print(f"\n{number} maps of 128 rows, on one core: {number / np.median(one):.1f} a second")
    print(f"two jobs, each with a core: {np.median(one / two):.2f} times as many")
    print(f"two copies of a busy loop: {np.median(2 * once / twice):.2f} times as much", flush=True)


def busy(steps):
    for _ in range(steps):
        pass


def fit_all(folder, jobs):
    before = el.threads()
    el.threads(jobs)
    try:
        el.batch(folder, lights=2, jobs=jobs)
    finally:
        el.threads(before)


def memory(number=2000):
    """Resident memory while maps are made, fitted and saved one after the other."""
    first, second = alone(resident, number)
    print(f"\n{number} maps: at most {first / 2**20:.1f} MB in the first half,", end=" ")
    print(f"{second / 2**20:.1f} MB in the second, {100 * (second / first - 1):+.1f} %", flush=True)


def resident(number):
    """Largest resident memory in the first and the second half of a batch."""
    sizes = []

    def maps():
        for seed in range(number):
            sizes.append(bytes_of("VmRSS"))
            yield f"map-{seed:05}", el.synthetic.plain(seed, 128).radiance

    with tempfile.TemporaryDirectory() as folder:
        el.batch(maps(), folder, lights=2, jobs=2)
    return max(sizes[: number // 2]), max(sizes[number // 2 :])


def command(number=200):
    """The command on a pattern against a loop in Python; both are a process of their own."""
    with tempfile.TemporaryDirectory() as folder:
        write_maps(folder, number)
        seconds = all_seconds(
            {"loop": lambda: run_loop(folder), "command": lambda: run_command(folder)},
            rounds=5,
            patience=200,
        )
    ratios = np.array(seconds["command"]) / np.array(seconds["loop"])
    print(f"\n{number} maps: the command takes {np.median(ratios):.2f} times a loop", end=" ")
    print(f"({ratios.min():.2f} to {ratios.max():.2f})", flush=True)


def run_loop(folder):
    with tempfile.TemporaryDirectory() as out:
        subprocess.run([sys.executable, "-c", LOOP, folder, out], check=True)


def run_command(folder):
    arguments = ["batch", f"{folder}/*.exr", "--set", "lights=2", "--jobs", "1"]
    with tempfile.TemporaryDirectory() as out:
        python = [sys.executable, "-m", "envlights"]
        subprocess.run([*python, *arguments, "-o", out], check=True, capture_output=True)


if __name__ == "__main__":
    main()
