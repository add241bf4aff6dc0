"""Fits on several threads of a free-threaded Python: the GIL stays off, and the rigs are the same.

`python tests/free_threaded.py` needs envlights, NumPy, click and tqdm, and no image library, which
has no wheel for free-threaded Python.
"""

import sys
from concurrent.futures import ThreadPoolExecutor

import envlights as el

THREADS = 4


def main():
    if getattr(sys, "_is_gil_enabled", lambda: True)():
        sys.exit("the GIL is on: this Python is not free-threaded, or an extension turned it on")
    check()


def check():
    """Require the same rigs on one thread and on several."""
    maps = [el.synthetic.hall(48 + 8 * size).radiance for size in range(2 * THREADS)]
    alone = [el.fit(each, lights=3) for each in maps]
    with ThreadPoolExecutor(THREADS) as threads:
        together = list(threads.map(lambda each: el.fit(each, lights=3), maps))
    if together != alone:
        sys.exit("rigs differ between one thread and several")
    print(f"{len(maps)} rigs are the same on one thread and on {THREADS}")


if __name__ == "__main__":
    main()
