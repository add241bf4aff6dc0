"""Helpers of tests and benchmarks; none needs pytest."""

import contextlib
import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np

import envlights as el
from envlights import io, kernels, synthetic
from envlights.synthetic.room import Room

#: Real maps that are equirectangular, by folder.
EQUIRECTANGULAR = ("hdr/*.hdr", "exr/*.exr", "openexr_envmaps/*LatLong.exr", "ldr/*.png")

#: The probe that a fit uses: unit normals and their solid angles.
NORMALS, SOLID_ANGLES = kernels.icosphere(320)


def cases(*, short, long):
    """Number of generated cases of a test: `long` if `ENVLIGHTS_FUZZ` is set."""
    return long if os.environ.get("ENVLIGHTS_FUZZ") else short


def paths_of_real_maps(*patterns):
    """Return the maps that match in the folder `ENVLIGHTS_MAPS`; none without that folder."""
    folder = os.environ.get("ENVLIGHTS_MAPS")
    if not folder:
        return []
    return sorted(path for pattern in patterns for path in Path(folder).glob(pattern))


def angle_deg(one, other):
    """Angle between unit vectors, from the chord: the arc cosine is blind below 1e-6 degrees."""
    chord = np.linalg.norm(np.asarray(one) - other, axis=-1)
    return np.rad2deg(2 * np.arcsin(np.clip(chord / 2, 0, 1)))


def flux(radiance):
    """RGB integral of a map over the sphere."""
    height, width, _ = radiance.shape
    return (radiance * kernels.pixel_solid_angles(height, width)[..., None]).sum(axis=(0, 1))


def relative_errors(images, truth):
    """Norm of the difference over the norm of the truth, for each image of a stack."""
    rows = np.reshape(truth, (len(truth), -1)).astype(float)
    difference = np.reshape(images, rows.shape) - rows
    return np.linalg.norm(difference, axis=1) / np.linalg.norm(rows, axis=1)


@cache
def room(width):
    """80 pairs of the generated room with `width` columns, made once for all tests; read-only."""
    made = synthetic.room(80, width=width)
    for images in (made.direct, made.indirect):
        images.flags.writeable = False
    return made


def pairs_of_room(count, width):
    """Return the first `count` pairs of `room`."""
    return Room(room(width).direct[:count], room(width).indirect[:count])


def oblong(images=12, dtype=np.float64, seed=0):
    """Pairs of direct and indirect images of odd sizes, without any structure."""
    rng = np.random.default_rng(seed)
    return rng.gamma(1, 3, (images, 3, 5, 3)).astype(dtype), rng.gamma(1, 9, (images, 7, 11, 3))


def printed_by_threads(code, counts=(1, 2, 5)):
    """Run `code` in a new process for each number of threads; return the set of what they print.

    The threads of the kernels are counted once, when a process first uses them.
    """
    printed = set()
    for count in counts:
        environment = os.environ | {"RAYON_NUM_THREADS": str(count), "OPENBLAS_NUM_THREADS": "1"}
        command = [sys.executable, "-c", code]
        printed.add(subprocess.check_output(command, env=environment, text=True))
    return printed


def write_pairs(folder, direct, indirect):
    """Write each pair of images as files of a new folder."""
    folder.mkdir()
    for k, pair in enumerate(zip(direct, indirect, strict=True)):
        for kind, image in zip(("direct", "lightmap"), pair, strict=True):
            io.write_exr(folder / f"{kind}_{k:04}.exr", image.astype(np.float32))
    return folder


@contextlib.contextmanager
def disk_that_is_full_after(size):
    """No file can grow beyond `size` bytes: a write fails as on a full disk, with EFBIG."""
    import resource

    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@contextlib.contextmanager
def limited_memory(size):
    """No more memory for this process than it has, and `size` bytes."""
    import resource

    before = resource.getrlimit(resource.RLIMIT_AS)
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)


def cuts(size, step=29):
    """Sizes at which a file of `size` bytes is cut: the start, the middle, and close to the end."""
    return sorted({0, 1, size // 2, *range(max(size - 600, 2), size, step), size - 1})


#: Detectors by the name of their method.
DETECTORS = {"tree": el.detect, "loghin": el.papers.loghin.detect}
