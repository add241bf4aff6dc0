"""Seconds until long calls end after Ctrl-C, each in a process of its own.

    python benchmarks/signals.py [NAME ...]

Each call is made once as a whole, and then interrupted after a quarter, a half and three quarters
of that time. Stated is the slowest of the three, by the clock and by the processors: on a machine
that others use the second is the smaller.
"""

import multiprocessing
import os
import signal
import sys
import tempfile
import threading
from functools import cache
from itertools import starmap
from pathlib import Path
from time import perf_counter, process_time, sleep

import numpy as np

import envlights as el
from envlights import kernels, synthetic

TURN = [[0.36, 0.48, -0.8], [-0.8, 0.6, 0], [0.48, 0.64, 0.6]]
RNG = np.random.default_rng(0)


@cache
def large(height):
    """A generated map, each of its pixels repeated."""
    times = height // 512
    return np.repeat(np.repeat(synthetic.hard(3, 512).radiance, times, 0), times, 1)


@cache
def unit(count):
    vectors = RNG.normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


@cache
def pairs(count, direct, indirect):
    return tuple(
        RNG.random((count, side, side, 3), dtype=np.float32) for side in (direct, indirect)
    )


@cache
def model():
    return el.TransferModel.fit(*pairs(128, 32, 512), rank=64)


@cache
def rig():
    return el.fit(large(512), 8)


@cache
def env(height, **options):
    return el.EnvMap(large(height), **options)


@cache
def saved_map(suffix):
    """A file of 16384x8192 pixels."""
    path = Path(tempfile.mkdtemp(), "map").with_suffix(suffix)
    if suffix in (".exr", ".hdr"):
        env(8192).save(path)
    else:
        import OpenImageIO as oiio  # noqa: N813, its own name for itself

        image = oiio.ImageBuf(oiio.ImageSpec(16384, 8192, 3, "uint8"))
        image.set_pixels(oiio.ROI(), np.minimum(large(8192), 1))
        image.write(str(path))
    return path


def to_file(thing, suffix):
    with tempfile.TemporaryDirectory() as folder:
        thing.save(Path(folder, "saved").with_suffix(suffix))


def _x(count):
    """Unknowns of the paper's equations."""
    return np.r_[np.ones(3), np.tile([1, 1, 1, 0.5, 0.5], count)]


BORDER = el.io.Layout(registration="border-sampled")
#: What is made before, and what is interrupted.
CALLS = {
    "EnvMap(array)": (lambda: large(8192), el.EnvMap),
    "EnvMap(bytes)": (lambda: np.uint8(255 * np.minimum(large(8192), 1)), el.EnvMap),
    "EnvMap.open .exr": (lambda: saved_map(".exr"), el.EnvMap.open),
    "EnvMap.open .hdr": (lambda: saved_map(".hdr"), el.EnvMap.open),
    "EnvMap.open .png": (lambda: saved_map(".png"), el.EnvMap.open),
    "EnvMap.open .jpg": (lambda: saved_map(".jpg"), el.EnvMap.open),
    "EnvMap.save .exr": (lambda: env(4096), lambda e: to_file(e, ".exr")),
    "EnvMap.save .hdr": (lambda: env(4096), lambda e: to_file(e, ".hdr")),
    "EnvMap.save tiles": (
        lambda: env(4096, layout=BORDER),
        lambda e: to_file(e, ".exr"),
    ),
    "EnvMap.from_exposures": (
        lambda: [np.minimum(large(2048) * t, 1) for t in (0.1, 0.5, 2)],
        lambda pictures: el.EnvMap.from_exposures(pictures, (0.1, 0.5, 2)),
    ),
    "EnvMap.probe": (lambda: env(512), lambda e: e.probe(unit(50_000))),
    "EnvMap.rotated": (lambda: env(2048), lambda e: e.rotated(TURN)),
    "EnvMap.cells": (lambda: env(2048, layout=BORDER), lambda e: e.cells()),
    "EnvMap.repaired": (
        lambda: el.EnvMap(np.minimum(large(8192), 3), clip_level=3.0),
        lambda e: e.repaired(),
    ),
    "EnvMap ==": (
        lambda: (env(8192), el.EnvMap(large(8192).copy())),
        lambda both: both[0] == both[1],
    ),
    "str(EnvMap)": (lambda: env(8192), str),
    "EnvMap in HTML": (lambda: env(8192), lambda e: e._repr_html_()),
    "detect": (lambda: env(8192), el.detect),
    "detect, article": (lambda: env(8192), lambda e: el.papers.loghin.detect(e)),
    "split": (lambda: env(8192), el.split),
    "fit": (lambda: env(512), lambda e: el.fit(e, 32, ambient="sh2")),
    "fit, a large map": (lambda: env(8192), lambda e: el.fit(e, 4)),
    "fit_probe": (lambda: unit(81_920), lambda n: el.fit_probe(n, np.abs(n), 30)),
    "fit_paper": (lambda: env(512), lambda e: el.papers.madsen.fit(e, 190, max_steps=10)),
    "Rig.probe": (rig, lambda r: r.probe(unit(8_000_000))),
    "Rig.to_map": (rig, lambda r: r.to_map(4096)),
    "TransferModel.fit": (
        lambda: pairs(1024, 32, 64),
        lambda p: el.TransferModel.fit(*p, rank=512),
    ),
    "TransferModel.add": (model, lambda m: m.add(*pairs(256, 32, 512))),
    "TransferModel.predict": (model, lambda m: m.predict(np.repeat(pairs(128, 32, 512)[0], 8, 0))),
    "TransferModel.project": (model, lambda m: m.project(pairs(256, 32, 512)[1])),
    "TransferModel.compressed": (model, lambda m: m.compressed(0.01)),
    "TransferModel.save": (model, lambda m: to_file(m, ".npz")),
    "plot.picture": (lambda: (env(8192), rig()), lambda both: el.plot.picture(*both)),
    "synthetic.hall": (lambda: 4096, synthetic.hall),
    "synthetic.plain": (lambda: 4096, lambda height: synthetic.plain(2, height)),
    "synthetic.hard": (lambda: 4096, lambda height: synthetic.hard(1, height)),
    "synthetic.openings": (lambda: 4096, lambda height: synthetic.openings(3, height)),
    "synthetic.room": (lambda: 512, lambda width: synthetic.room(64, width)),
    "kernels.blur": (lambda: large(4096)[..., 0].copy(), lambda g: kernels.blur(g, 50)),
    "kernels.disc_map": (
        lambda: unit(400),
        lambda d: kernels.disc_map(2048, d, np.abs(d), np.full(len(d), 0.3)),
    ),
    "kernels.face_radiance": (lambda: large(8192), lambda m: kernels.face_radiance(m, 81_920)),
    "kernels.halton": (lambda: 50_000_000, kernels.halton),
    "kernels.hammersley": (lambda: 50_000_000, kernels.hammersley),
    "kernels.harmonic_irradiance": (lambda: unit(8_000_000), kernels.harmonic_irradiance),
    "kernels.icosphere": (lambda: 20 * 4**8, kernels.icosphere),
    "kernels.irradiance": (lambda: large(512), lambda m: kernels.irradiance(m, unit(50_000))),
    "kernels.luminance": (lambda: large(8192), kernels.luminance),
    "kernels.neighbour_maximum": (
        lambda: large(4096)[..., 0].copy(),
        lambda g: kernels.neighbour_maximum(g, np.argwhere(g > np.quantile(g, 0.99)), 1500),
    ),
    "kernels.pixel_directions": (lambda: 8192, lambda side: kernels.pixel_directions(side, side)),
    "kernels.pixel_solid_angles": (
        lambda: 16384,
        lambda side: kernels.pixel_solid_angles(side, 2 * side),
    ),
    "kernels.probe_jacobian": (
        lambda: unit(2_000_000),
        lambda n: kernels.probe_jacobian(_x(4), n, np.abs(n)),
    ),
    "kernels.probe_model": (lambda: unit(4_000_000), lambda n: kernels.probe_model(_x(20), n)),
    "kernels.probe_residual": (
        lambda: unit(4_000_000),
        lambda n: kernels.probe_residual(_x(20), n, np.abs(n)),
    ),
    "kernels.relative_rms": (
        lambda: unit(8_000_000),
        lambda n: kernels.relative_rms(n, n + 1, np.abs(n[:, 0])),
    ),
    "kernels.resize_bilinear": (
        lambda: large(2048)[..., 0].copy(),
        lambda g: kernels.resize_bilinear(g, 16384, 32768),
    ),
    "kernels.suppress": (
        lambda: RNG.random((1_000_000, 3)),
        lambda points: kernels.suppress(points, 1e-5),
    ),
    "kernels.sum_over_sources": (
        lambda: unit(200_000),
        lambda n: kernels.sum_over_sources(n, n[:5000], np.abs(n[:5000]), np.abs(n[:5000, 0])),
    ),
    "kernels.uniform_sphere": (lambda: RNG.random((10_000_000, 2)), kernels.uniform_sphere),
    "kernels.uv_to_direction": (lambda: RNG.random((10_000_000, 2)), kernels.uv_to_direction),
    "kernels.direction_to_uv": (lambda: unit(8_000_000), kernels.direction_to_uv),
}
#: A shorter call is over before a person has pressed anything.
SHORT = 0.2


def measure(name):
    """The name of a call, its seconds, and the slowest ends by the clock and by the processors."""
    # A shell lets programs in the background ignore it.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    prepare, call = CALLS[name]
    given = prepare()
    start = perf_counter()
    call(given)
    whole = perf_counter() - start
    if whole < SHORT:
        return name, whole, []
    ends = [_interrupt(call, given, share * whole) for share in (0.25, 0.5, 0.75)]
    return name, whole, [end for end in ends if end]


def _interrupt(call, given, seconds):
    """Seconds between the signal and KeyboardInterrupt; None if the call ended earlier."""
    sent, is_over = [], False

    def send():
        sent[:] = perf_counter(), process_time()
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(seconds, send)
    try:
        timer.start()
        call(given)
        is_over = True
        sleep(2 * seconds)
    except KeyboardInterrupt:
        return None if is_over else (perf_counter() - sent[0], process_time() - sent[1])
    raise RuntimeError("no signal came")


def row(name, whole, ends):
    if not ends:
        return f"| {name} | {whole:.2f} s | | |"
    clock, processors = map(max, zip(*ends, strict=True))
    return f"| {name} | {whole:.1f} s | {clock:.2f} s | {processors:.2f} s |"


def main():
    print("| call | run time | after Ctrl-C, clock | processor time |\n|---|---|---|---|")
    spawn = multiprocessing.get_context("spawn")
    with spawn.Pool(1, maxtasksperchild=1) as pool:
        found = pool.imap(measure, sys.argv[1:] or CALLS, chunksize=1)
        for line in starmap(row, found):
            print(line, flush=True)


if __name__ == "__main__":
    main()
