"""Fits on several threads of a free-threaded Python: the GIL stays off, and the rigs are the same.

`python tests/free_threaded.py` needs envlights, NumPy, click and tqdm.
"""

import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import envlights as el

THREADS = 4


def main():
    if getattr(sys, "_is_gil_enabled", lambda: True)():
        sys.exit("the GIL is on: this Python is not free-threaded, or an extension turned it on")
    maps = [el.EnvMap(el.synthetic.hall(48 + 8 * size).radiance) for size in range(2 * THREADS)]
    check(maps)
    with tempfile.TemporaryDirectory() as folder:
        check([save(each, Path(folder), number) for number, each in enumerate(maps)])


def save(env, folder, number):
    """Path of a map in a file; OpenEXR and Radiance take turns."""
    path = folder / f"{number}{('.exr', '.hdr')[number % 2]}"
    env.save(path)
    return path


def check(maps):
    """Require the same rigs on one thread and on several."""
    alone = [el.fit(each, lights=3) for each in maps]
    with ThreadPoolExecutor(THREADS) as threads:
        together = list(threads.map(lambda each: el.fit(each, lights=3), maps))
    if together != alone:
        sys.exit("rigs differ between one thread and several")
    print(f"{len(maps)} rigs are the same on one thread and on {THREADS}")


if __name__ == "__main__":
    main()
