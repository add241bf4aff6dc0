"""Stated error of rigs, and their error in files, by the reader or renderer of each target.

The reader is `irradiance_of_file` in the test of the target, such as `test_gltf.py`.

`python -m tests.export.file_errors MAP...` prints both for every target and map: of the default
fit, with the figure of the warning, and of the fit for the target.
"""

import importlib
import os
import sys
import tempfile
import warnings
from pathlib import Path

import envlights as el
from envlights.export import TARGETS
from envlights.kernels import relative_rms
from tests.helpers import NORMALS, SOLID_ANGLES


def readers_of(target):
    """Module of the tests of a target, with its readers."""
    return importlib.import_module(f"tests.export.test_{target.file or target.name}")


def irradiance_of_file(rig, target):
    """Irradiance at `NORMALS` from the file of a rig, as the tests of the target read it."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        path = Path(folder).resolve() / f"rig{target.suffixes[0]}"
        rig.save(path)
        return readers_of(target).irradiance_of_file(path)


def error_of_file(rig, target, truth):
    """Relative RMS error, against irradiance at `NORMALS`, of the file of a rig."""
    return relative_rms(irradiance_of_file(rig, target), truth, SOLID_ANGLES)


def figures(env, target, truth):
    """Errors of the default fit: stated, in the warning, in the file; the same of a fit for it."""
    usual, made = el.fit(env), el.fit(env, target=target.name)
    return (
        usual.error,
        usual.error_in(target.name),
        error_of_file(usual, target, truth),
        made.error,
        error_of_file(made, target, truth),
    )


def main(paths):
    """Print a row for each map and target."""
    print(
        f"{'map':<28}{'target':<10}{'stated':>8}{'warned':>8}{'file':>8}{'fitted':>10}{'file':>8}"
    )
    for path in paths:
        env = el.EnvMap.open(path)
        truth = env.probe(NORMALS)
        for target in TARGETS:
            try:
                row = figures(env, target, truth)
            except BaseException as reason:  # a skip is no Exception
                print(f"{Path(path).stem[:26]:<28}{target.name:<10}{str(reason)[:60]}")
                continue
            first, last = (
                "".join(f"{100 * x:>7.3g}%" for x in part) for part in (row[:3], row[3:])
            )
            print(f"{Path(path).stem[:26]:<28}{target.name:<10}{first}  {last}", flush=True)


if __name__ == "__main__":
    os.environ.setdefault("MPLBACKEND", "Agg")
    main(sys.argv[1:])
