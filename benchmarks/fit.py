"""Error, run time and stability of the fit, beside SciPy and JAXopt, in one run.

Usage: python benchmarks/fit.py [tradeoff] [starts] [search] [speed] [stability]
           [--every N] [--starts N] [--scipy N] [--before PYTHON]

With `ENVLIGHTS_MAPS` set to a folder of maps, on those as well. `search --every 1 --scipy 100` is
the whole comparison with wider searches, and takes hours.
"""

import argparse
import os
import sys
from pathlib import Path

# Before numpy is imported: the peers' matrices are too small to share among threads.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parents[1]))

import fit_search
import fit_speed
import fit_stability
import fit_starts
import fit_tradeoff

PARTS = {
    "tradeoff": lambda options: fit_tradeoff.table(options.every),
    "starts": lambda options: fit_starts.table(options.every),
    "search": lambda options: fit_search.table(options.every, options.starts, options.scipy),
    "speed": lambda options: fit_speed.tables(options.every, options.before),
    "stability": lambda options: fit_stability.table(),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("parts", nargs="*", metavar="part", help=f"of {', '.join(PARTS)}")
    parser.add_argument("--every", type=int, default=3, help="take each n-th map; 1 is all")
    parser.add_argument("--starts", type=int, default=100, help="random starts of fit in `search`")
    parser.add_argument("--scipy", type=int, default=5, help="random starts of scipy in `search`")
    parser.add_argument("--before", help="a Python that has another build, for `speed`")
    options = parser.parse_args()
    threads = os.environ.get("RAYON_NUM_THREADS", os.cpu_count())
    print(f"{threads} threads for the fit, {os.environ['OPENBLAS_NUM_THREADS']} for BLAS")
    for part in options.parts or PARTS:
        PARTS[part](options)


if __name__ == "__main__":
    main()
