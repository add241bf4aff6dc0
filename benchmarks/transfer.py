"""Fit and predict against the notebook's mathematics and scikit-learn, in one run.

Times and memory on images without meaning, K = 128, 16x16 -> 512x512, rank 64, with one thread and
with two; each fit runs in a process of its own, so that its memory can be seen, and the three take
turns. Then frames of compressed models, and errors on lights that were not seen.
Usage: python benchmarks/transfer.py [FOLDER of pairs]
"""

import multiprocessing
import os
import resource
import sys
import time
from pathlib import Path

import numpy as np
from curves.peers_of_transfer import notebook, scikit

import envlights as el

PAIRS, SIZE, RANK = 128, 512, 64


def images():
    """Pairs whose energy falls with the rank as that of real ones."""
    rng = np.random.default_rng(0)
    direct = rng.random((PAIRS, 16, 16, 3), np.float32)
    indirect = np.zeros((PAIRS, SIZE, SIZE, 3), np.float32)
    shares = rng.random((PAIRS, 3, 96)) / np.sqrt(np.arange(1, 97))
    for row in range(SIZE):
        texels = rng.random((96, SIZE), np.float32)
        indirect[:, row] = np.moveaxis(shares.astype(np.float32) @ texels, 1, -1)
    return direct, indirect


def ours(direct, indirect, rank):
    return el.TransferModel.fit(direct, indirect, rank).predict


def measure(fit, answers):
    """Seconds of a fit, seconds of a frame, megabytes beside the images."""
    direct, indirect = images()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start = time.perf_counter()
    predict = fit(direct, indirect, RANK)
    fitted = time.perf_counter() - start
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
    frames = []
    for k in range(8):
        start = time.perf_counter()
        predict(direct[k])
        frames.append(time.perf_counter() - start)
    answers.put((fitted, min(frames), grown, indirect.nbytes / 2**20))


def alone(measured, *arguments):
    """Return what a function puts into its queue in a fresh process."""
    context = multiprocessing.get_context("spawn")
    answers = context.SimpleQueue()
    process = context.Process(target=measured, args=(*arguments, answers))
    process.start()
    process.join()
    return answers.get()


def speed(threads, repeats=3):
    """Print run time and memory of each method, the least of several runs."""
    print(f"\nK = {PAIRS}, 16x16 -> {SIZE}x{SIZE}, rank {RANK}, threads: {threads}")
    fits = {"notebook": notebook, "scikit-learn": scikit, "TransferModel": ours}
    found = {name: [] for name in fits}
    for _ in range(repeats):
        for name, fit in fits.items():
            found[name].append(alone(measure, fit))
    least = {name: np.min(runs, axis=0) for name, runs in found.items()}
    for name, (fitted, frame, grown, whole) in least.items():
        theirs = [least[peer][0] / fitted for peer in ("notebook", "scikit-learn")]
        print(
            f"{name:<14} fit{fitted:>7.2f} s, {theirs[0]:>4.1f} x notebook, {theirs[1]:>4.1f} x"
            f" scikit-learn   frame{1e3 * frame:>7.2f} ms, {least['notebook'][1] / frame:>4.1f} x"
            f"   {grown:>5.0f} MB, {100 * grown / whole:.0f} % of the images"
        )


def frames(answers):
    """Put the milliseconds of frames, for each form of the basis and each kind of request."""
    direct, indirect = images()
    model = el.TransferModel.fit(direct, indirect, RANK)
    models = {"float32": model, "float16": model.compressed(0.001), "int8": model.compressed(0.005)}
    asked = {
        "one": lambda each: each.predict(direct[0]),
        "error 5 %": lambda each: each.predict(direct[0], error=0.05),
        "region 128x128": lambda each: each.predict(direct[0], region=(slice(99, 227),) * 2),
        "of a batch of 8": lambda each: each.predict(direct[:8]),
        "of a batch of 32": lambda each: each.predict(direct[:32]),
    }
    counts = {"of a batch of 8": 8, "of a batch of 32": 32}
    found = {
        (name, what): least(lambda f=f, each=each: f(each)) / counts.get(what, 1)
        for what, f in asked.items()
        for name, each in models.items()
    }
    notes = {name: each.report.notes[-1:] for name, each in models.items()}
    answers.put((found, tuple(asked), notes))


def least(call, repeats=12):
    """Least milliseconds of a call, after the threads of a BLAS that was used before went idle."""
    time.sleep(0.5)
    return min(milliseconds(call) for _ in range(repeats))


def milliseconds(call):
    start = time.perf_counter()
    call()
    return 1e3 * (time.perf_counter() - start)


def compressed_frames(threads):
    found, asked, notes = alone(frames)
    print(f"\nmilliseconds of a frame, threads: {threads}")
    for what in asked:
        times = {name: found[name, what] for name in notes}
        row = "".join(f"   {name}{each:>7.2f}" for name, each in times.items())
        print(f"{what:<16}{row}   float32 / int8 {times['float32'] / times['int8']:.1f} x")
    for name, (note,) in ((name, note) for name, note in notes.items() if note):
        print(f"{name}: {note}")


def errors(name, direct, indirect, learnt, rank):
    """Relative errors of the pairs after the first `learnt`, and the errors in the report."""
    print(f"\n{name}: {learnt} pairs, rank {rank}, {len(direct) - learnt} unseen")
    new = slice(learnt, None)
    truth = np.linalg.norm(indirect[new].reshape(len(direct) - learnt, -1), axis=1)
    for is_notebook in (True, False):
        for ridge in (1e-3, "loo"):
            model = el.TransferModel.fit(
                direct[:learnt], indirect[:learnt], rank, ridge, notebook=is_notebook
            )
            wrong = (model.predict(direct[new]) - indirect[new]).reshape(len(truth), -1)
            median, high = 100 * np.percentile(np.linalg.norm(wrong, axis=1) / truth, [50, 90])
            print(
                f"{'notebook' if is_notebook else 'default':<9} ridge {ridge!s:<6}"
                f" median{median:>6.1f} %  90th{high:>6.1f} %"
                f"   leave-one-out{100 * model.report.error:>6.1f} %"
            )


if __name__ == "__main__":
    for threads in ("1", "2"):
        os.environ |= {"OPENBLAS_NUM_THREADS": threads, "RAYON_NUM_THREADS": threads}
        speed(threads)
        compressed_frames(threads)
    room = el.synthetic.room(512, width=64)
    errors("noise-free room", room.direct, room.indirect, 128, 64)
    folder = sys.argv[1] if sys.argv[1:] else os.environ.get("ENVLIGHTS_TRANSFER_DB")
    if folder:
        pairs = el.read_pairs(Path(folder))
        errors(folder, pairs.direct, pairs.indirect, 48, 32)
