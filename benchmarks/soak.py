"""Long runs: no row is lost, nothing hangs, memory stays flat. Linux only.

Usage: python benchmarks/soak.py [--maps N] [--minutes M] PART ...

- thread, process, dask: a batch of small maps into a folder. A tenth are damaged files or raise an
  error when they are read; another tenth are black or have NaN.
- follow: a stream of small frames.
- starts: processes by fork, spawn and forkserver after the kernels ran in the parent, 16 threads.
- page: a page of `el.view` in Chromium, where a light is dragged each second.

Memory is the resident size of the parent and of the largest worker, from a twentieth on.
Dask needs distributed; the page needs ``npm install --prefix tests/viewer``.
"""

import argparse
import contextlib
import multiprocessing
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import psutil

import envlights as el

#: Runs of each start method, and seconds until one counts as hung.
RUNS, PATIENCE, STARTS = 20, 120, ("fork", "spawn", "forkserver")
VIEWER = Path(__file__).parents[1] / "tests" / "viewer"


class FailingFile:
    """File whose device fails."""

    def read(self, size=-1):
        """No bytes: the device is gone."""
        raise OSError("the device is gone")


def maps(number, memory):
    """Named maps of 16 x 8 pixels with a lamp; one of five is broken, black or has NaN."""
    rng = np.random.default_rng(0)
    for k in range(number):
        lamp = np.full((8, 16, 3), 0.2, np.float32)
        lamp[rng.integers(8), rng.integers(16)] = 50
        hole = np.where(rng.random((8, 16, 1)) < 0.1, np.nan, lamp)
        faults = [b"v/1\x01" + rng.bytes(40), FailingFile(), hole, 0 * lamp]
        kind = rng.integers(20)
        memory.failures += kind < 2
        yield f"map-{k:06}", faults[kind] if kind < 4 else lamp
        memory.note(k)


class Memory:
    """Resident size of this process and of the largest of those that it started, in MB."""

    def __init__(self, number):
        self.number, self.sizes, self.failures = number, [], 0

    def note(self, k):
        """Measure after each hundredth of the maps, from a twentieth on."""
        if k >= self.number // 20 and k % (self.number // 100) == 0:
            own = psutil.Process()
            workers = [each.memory_info().rss for each in own.children(recursive=True)]
            self.sizes.append((own.memory_info().rss / 1e6, max(workers, default=0) / 1e6))

    def __str__(self):
        sizes = np.array(self.sizes)
        growth = ", ".join(f"{each:.1f}" for each in np.ptp(sizes, axis=0))
        return f"MB {sizes[0].round(1)} to {sizes[-1].round(1)}, growth at most {growth}"


def batch(executor, number):
    """Rows of a batch: as many as maps, each name once, and the failures that were put in."""
    memory = Memory(number)
    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as stack:
        if executor == "dask":
            import distributed

            options = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
            executor = stack.enter_context(distributed.Client(**options))
        options = {"what": "detect", "suffix": None, "progress": False, "jobs": 2}
        result = el.batch(maps(number, memory), folder, executor=executor, **options)
        names = [row["name"] for row in result.rows()]
        assert len(names) == len(set(names)) == number
        assert len(result.failures) == memory.failures
        print(f"{number} rows, {memory.failures} failures; {memory}")


def follow(number):
    """Rigs of a stream, one for each frame."""
    memory = Memory(number)

    def frames():
        for k in range(number):
            direction = [[0.8 * np.cos(0.002 * k), 0.6, 0.8 * np.sin(0.002 * k)]]
            yield el.Lights(direction, [[2, 2, 2]], [0.1]).to_map(8)
            memory.note(k)

    assert [rig.frame for rig in el.follow(frames(), 1)] == list(range(number))
    print(f"{number} rigs; {memory}")


def start(method):
    """Work in processes of one start method, after the kernels ran here."""
    image = el.synthetic.hall(64).radiance
    rig = el.fit(image)
    with multiprocessing.get_context(method).Pool(2) as pool:
        assert pool.map(el.fit, [image] * 4) == [rig] * 4


def starts():
    """Run each start method many times, each time in a new process."""
    environment = os.environ | {"RAYON_NUM_THREADS": "16"}
    for method in STARTS * RUNS:
        command = [sys.executable, __file__, "--start", method]
        subprocess.run(command, env=environment, timeout=PATIENCE, check=True)
    print(f"{RUNS} runs each")


def page(minutes):
    """Drag a light of a page each second; print the heap after garbage collection."""
    with tempfile.TemporaryDirectory() as folder:
        path, world = Path(folder, "page.html"), el.synthetic.hall(64)
        el.view(world, el.fit(world, lights=2)).save(path)
        command = ["node", VIEWER / "drags.mjs", shutil.which("chromium"), path.as_uri()]
        subprocess.run([*command, str(minutes)], check=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("parts", nargs="*", metavar="PART")
    parser.add_argument("--maps", type=int, default=20_000)
    parser.add_argument("--minutes", type=float, default=15)
    parser.add_argument("--start", choices=STARTS, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.start:
        start(given.start)
    special = {"follow": (follow, given.maps), "page": (page, given.minutes), "starts": (starts,)}
    for part in given.parts:
        print(f"{part}:", end=" ", flush=True)
        work, *arguments = special.get(part, (batch, part, given.maps))
        work(*arguments)


if __name__ == "__main__":
    main()
