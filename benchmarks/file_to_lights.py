"""From a file to four lights: processor time and errors of `fit` and of peers, on one thread.

The peers read the file with OpenImageIO, and end with an ambient term and refitted radiances. Times
are the least of the rounds, all methods in turn; errors are those of a white probe and of shadows.
Usage: python benchmarks/file_to_lights.py MAP...
"""

import argparse
import os
import sys
import time
from functools import partial
from pathlib import Path

# Before NumPy is imported, which reads them once.
os.environ |= dict.fromkeys(("RAYON_NUM_THREADS", "OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"), "1")
sys.path.insert(0, str(Path(__file__).parents[1]))

import OpenImageIO as oiio  # noqa: N813, its own name for itself
from curves import peers_refitted as peers
from curves.errors_of_rigs import Evaluation
from stopwatch import all_seconds

import envlights as el

LIGHTS = 4
#: Rounds, and seconds of rounds of each method.
_ROUNDS, _PATIENCE = 5, 10.0


def read(path):
    """Linear radiance, as OpenImageIO reads it."""
    return oiio.ImageBuf(str(path)).get_pixels(oiio.FLOAT)[..., :3]


METHODS = {
    "`fit(path)`": lambda path: el.fit(path, lights=LIGHTS),
    "OpenImageIO, k-means + NNLS": lambda path: peers.k_means_refitted(read(path), LIGHTS),
    "OpenImageIO, median cut + NNLS": lambda path: peers.median_cut_refitted(read(path), LIGHTS),
    "OpenImageIO, discs by SciPy": lambda path: peers.discs_by_scipy(read(path), LIGHTS),
    "OpenImageIO alone": read,
}


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("maps", nargs="+", type=Path)
    paths = parser.parse_args().maps
    oiio.attribute("threads", 1)
    print("| map | method | time | white probe | shadows |\n|---|---|---|---|---|")
    for path in paths:
        evaluation = Evaluation(el.EnvMap.open(path))
        work = {name: partial(method, path) for name, method in METHODS.items()}
        answers = {name: piece() for name, piece in work.items()}
        seconds = all_seconds(work, _ROUNDS, _PATIENCE, time.process_time, fewest=1)
        for name, rig in answers.items():
            errors = " | "
            if name != "OpenImageIO alone":
                errors = f"{evaluation.probe_error(rig):.2g} | {evaluation.shadow_error(rig):.2g}"
            print(f"| {path.name} | {name} | {1e3 * min(seconds[name]):.3g} ms | {errors} |")


if __name__ == "__main__":
    main()
