"""Time and memory from a file to a rig, by format, as ratios to `fit` of an array.

A map of 4096x2048 pixels is written in each format. `open + fit` reads the whole map; `fit(path)`
reduces its rows. Ratios are of processor time, all in one process. Memory is the growth of a
process of its own by `fit(path)`, on Linux only. Notes after a format show a difference of lights.
Usage: python benchmarks/files.py [--height ROWS] [--threads 1 2] [--formats NAME ...]
"""

import argparse
import os
import tempfile
import time
from functools import partial
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813, its own name for itself
from memory import alone, peak
from stopwatch import all_seconds

import envlights as el

#: File, sample type and attributes of each format.
FORMATS = {
    ".hdr": ("map.hdr", "float", {}),
    "JPEG baseline": ("map.jpg", "uint8", {"compression": "jpeg:95"}),
    "JPEG progressive": ("prog.jpg", "uint8", {"compression": "jpeg:95", "jpeg:progressive": 1}),
    "EXR half ZIP": ("zip.exr", "half", {"compression": "zip"}),
    "EXR half ZIPS": ("zips.exr", "half", {"compression": "zips"}),
    "EXR half DWAB": ("dwab.exr", "half", {"compression": "dwab"}),
    "EXR half PIZ": ("piz.exr", "half", {"compression": "piz"}),
    "EXR half raw": ("raw.exr", "half", {"compression": "none"}),
    "EXR float ZIP": ("float.exr", "float", {"compression": "zip"}),
    "PNG 8": ("8.png", "uint8", {}),
    "PNG 16": ("16.png", "uint16", {}),
    "TIFF float raw": ("raw.tif", "float", {"compression": "none"}),
}
#: Map of a folder of maps from which the files are made.
REAL_MAP = "exr/san_giuseppe_bridge_2k.exr"


def radiance_of(height):
    """A real map with noise, so that it packs like a photograph; a generated one without maps."""
    folder = os.environ.get("ENVLIGHTS_MAPS")
    small = el.EnvMap.open(Path(folder) / REAL_MAP) if folder else el.synthetic.hard(3, 1024)
    times = height // len(small.radiance)
    large = small.radiance.repeat(times, axis=0).repeat(times, axis=1)
    noise = np.random.default_rng(7).normal(1.0, 0.004, large.shape).astype(np.float32)
    return large * noise


def write_map(folder, name, height):
    """Write one file, and return its path."""
    file_name, kind, attributes = FORMATS[name]
    path = Path(folder) / file_name
    radiance = radiance_of(height)
    if kind.startswith("uint"):
        exposed = radiance / np.quantile(radiance, 0.97)
        largest = np.iinfo(kind).max
        radiance = np.rint(largest * exposed.clip(0, 1) ** (1 / 2.2)).astype(kind)
    spec = oiio.ImageSpec(2 * height, height, 3, kind)
    for key, value in attributes.items():
        spec.attribute(key, value)
    file = oiio.ImageOutput.create(str(path))
    file.open(str(path), spec)
    file.write_image(radiance)
    file.close()
    return path


def difference(path):
    """Largest relative difference of the lights of `fit(path)` and of the opened map."""
    rows, whole = el.fit(path), el.fit(el.EnvMap.open(path))
    pairs = [
        (rows.lights.direction, whole.lights.direction),
        (rows.lights.irradiance, whole.lights.irradiance),
        (np.asarray(rows.ambient), np.asarray(whole.ambient)),
    ]
    if any(a.shape != b.shape for a, b in pairs):
        return np.inf
    return max(np.abs(a - b).max(initial=0) / np.abs(b).max(initial=1e-30) for a, b in pairs)


def ratios(path, array, threads):
    """Ratios of processor time to the fit of an array: of `open` and fit, and of `fit(path)`."""
    oiio.attribute("threads", threads)
    oiio.attribute("exr_threads", threads if threads > 1 else -1)
    el.threads(threads)
    clock = time.process_time if threads == 1 else time.perf_counter
    work = {
        "array": lambda: el.fit(array),
        "open + fit": lambda: el.fit(el.EnvMap.open(path)),
        "fit(path)": lambda: el.fit(path),
    }
    seconds = {name: min(found) for name, found in all_seconds(work, 9, 20.0, clock).items()}
    return seconds["array"], [seconds[name] / seconds["array"] for name in list(work)[1:]]


def growth(path):
    """Bytes by which `fit(path)` grows a process that has fitted a small file of this kind."""
    with tempfile.TemporaryDirectory() as folder:
        name = next(name for name, (file, *_) in FORMATS.items() if file == path.name)
        el.fit(write_map(folder, name, 1024))
    return peak(partial(el.fit, path))


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--height", type=int, default=2048, help="rows: a multiple of 1024")
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--formats", nargs="+", default=list(FORMATS), choices=list(FORMATS))
    options = parser.parse_args()
    array = radiance_of(options.height)
    columns = [f"{what}, {n}" for n in options.threads for what in ("open + fit", "fit(path)")]
    print(f"| {2 * options.height}x{options.height}, threads | {' | '.join(columns)} ", end="")
    print(f"| MB | file MB | difference |\n|---|{'---|' * (len(columns) + 3)}")
    with tempfile.TemporaryDirectory() as folder:
        for name in options.formats:
            path = alone(write_map, folder, name, options.height)
            cells = []
            for threads in options.threads:
                _, found = ratios(path, array, threads)
                cells += [f"{ratio:.2f}" for ratio in found]
            memory, size = alone(growth, path) / 1e6, path.stat().st_size / 1e6
            cells += [f"{memory:.0f}", f"{size:.0f}", f"{difference(path):.1g}"]
            print(f"| {name} | {' | '.join(cells)} |", flush=True)
            path.unlink()


if __name__ == "__main__":
    main()
