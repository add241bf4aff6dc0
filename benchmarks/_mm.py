"""Peak memory of opening, detecting, fitting and splitting a large map, by format of its file.

In multiples of the float pixels, 12 bytes each: 1.00 is the map alone. Linux only.
Usage: python benchmarks/map_memory.py [--height ROWS]
"""

import argparse
import tempfile
from functools import partial
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813, its own name for itself
from memory import alone, peak

import envlights as el

#: Names of the files, by format.
FILES = ("8.png", "16.png", "float.tif")
#: What each column does with a file.
WORK = {
    "open": el.EnvMap.open,
    "detect": el.detect,
    "fit": lambda path: el.fit(path, 4),
    "split": el.split,
}


def write_map(path, height):
    """Write a map of that many rows: the hard family, its pixels repeated."""
    small = el.synthetic.hard(3, 512).radiance
    times = height // len(small)
    radiance = small.repeat(times, axis=0).repeat(times, axis=1)
    if path.suffix in (".exr", ".hdr"):
        el.EnvMap(radiance).save(path)
        return
    kinds = {"map.jpg": np.uint8, "8.png": np.uint8, "16.png": np.uint16}
    dtype = kinds.get(path.name, np.float32)
    if dtype != np.float32:
        radiance = np.clip(radiance, 0, 1)
        radiance *= np.iinfo(dtype).max
    file = oiio.ImageOutput.create(str(path))
    file.open(str(path), oiio.ImageSpec(2 * height, height, 3, oiio.TypeDesc(np.dtype(dtype).name)))
    file.write_image(radiance.astype(dtype))
    file.close()


def growth(path, work):
    """Largest number of bytes by which a call grows a process."""
    with tempfile.TemporaryDirectory() as folder:
        tiny = Path(folder) / path.name
        write_map(tiny, 512)
        WORK[work](tiny)  # What the first call of all makes is no part of it.
    return peak(partial(WORK[work], path))


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--height", type=int, default=8192, help="rows: a multiple of 512")
    height = parser.parse_args().height
    if height < 512 or height % 512:
        parser.error(f"--height must be a multiple of 512; got {height}")
    print(f"| {2 * height}x{height} | {' | '.join(WORK)} |\n|---|{'---|' * len(WORK)}")
    with tempfile.TemporaryDirectory() as folder:
        for name in FILES:
            path = Path(folder) / name
            alone(write_map, path, height)
            cells = []
            for work in WORK:
                cells.append(f"{alone(growth, path, work) / (24 * height**2):.2f}")
            print(f"| {name} | {' | '.join(cells)} |", flush=True)
            path.unlink()


if __name__ == "__main__":
    main()
