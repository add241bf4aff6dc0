"""Memory of learning from files, beside the size of the images.

Each line is a process of its own. Allocated: pages that only more memory can make room for. Mapped:
pages of the file that the images are kept in, which the system drops as soon as it needs them.
Linux only. Usage: python benchmarks/transfer_memory.py [PAIRS] [WIDTH]
"""

import multiprocessing
import sys
import tempfile
import threading
from pathlib import Path

import numpy as np

import envlights as el

RANK = 16


def write(folder, pairs, width):
    """Pairs of one room under many lights; its images, enlarged."""
    room = el.synthetic.room(32, width=64)
    for k in range(pairs):
        shares = np.random.default_rng(k).random(32, np.float32)
        direct, small = (
            np.einsum("k,khwc->hwc", shares, all_) for all_ in (room.direct, room.indirect)
        )
        large = small.repeat(width // 64, axis=0).repeat(width // 64, axis=1)
        el.io.write_exr(folder / f"direct_{k:04}.exr", direct)
        el.io.write_exr(folder / f"lightmap_{k:04}.exr", large)


def memory():
    """Megabytes that are allocated, and that are mapped from files."""
    lines = dict(line.split(":") for line in Path("/proc/self/status").read_text().splitlines())
    return np.array([int(lines[name].split()[0]) / 1024 for name in ("RssAnon", "RssFile")])


def learn(folder):
    pairs = el.read_pairs(folder)
    el.TransferModel.fit(pairs.direct, pairs.indirect, RANK)


def learn_in_memory(folder):
    pairs = el.read_pairs(folder)
    el.TransferModel.fit(pairs.direct, np.array(pairs.indirect), RANK)


def measure(work, folder, answers):
    """Put the peak megabytes beyond those of the start, sampled every few milliseconds."""
    el.io.read_image(next(folder.glob("lightmap*")))
    start, most, done = memory(), np.zeros(2), threading.Event()

    def look():
        while not done.wait(0.003):
            np.maximum(most, memory() - start, out=most)

    watch = threading.Thread(target=look)
    watch.start()
    work(folder)
    done.set()
    watch.join()
    answers.put(most)


def alone(work, folder):
    context = multiprocessing.get_context("spawn")
    answers = context.SimpleQueue()
    process = context.Process(target=measure, args=(work, folder, answers))
    process.start()
    process.join()
    return answers.get()


if __name__ == "__main__":
    pairs, width = (int(text) for text in (*sys.argv[1:], "64", "1024")[:2])
    images = pairs * width * width * 12 / 2**20
    basis = width * width * RANK * 4 / 2**20
    print(
        f"{pairs} images of {width}x{width}: {images:.0f} MB; basis of rank {RANK}: {basis:.0f} MB"
    )
    with tempfile.TemporaryDirectory() as name:
        write(Path(name), pairs, width)
        for work in (learn, learn_in_memory):
            allocated, mapped = alone(work, Path(name))
            print(
                f"{work.__name__:<16} allocated{allocated:>6.0f} MB,"
                f" {100 * allocated / images:.0f} % of the images   mapped{mapped:>6.0f} MB"
            )
