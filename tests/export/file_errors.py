"""Stated error of rigs, and their error in files, by the reader or renderer of each target.

`python -m tests.export.file_errors MAP...` prints both for every target and map: of the default
fit, with the figure of the warning, and of the fit for the target.
"""

import importlib
import json
import os
import sys
import tempfile
import warnings
from pathlib import Path

import numpy as np

import envlights as el
from envlights.export import AXES, TARGETS
from envlights.kernels import relative_rms
from tests.helpers import NORMALS, SOLID_ANGLES


def gltf(path):
    """Lights by the specification, and the ambient term that is to be set by hand."""
    reader = importlib.import_module("tests.export.test_gltf")
    asset = json.loads(path.read_text())
    ambient = asset["scenes"][0].get("extras", {"ambient": [0, 0, 0]})["ambient"]
    return reader.irradiance(*reader.read(asset)) + np.pi * np.array(ambient)


def three(path):
    """Lights that the loader of three.js reads, summed as its shaders do."""
    reader = importlib.import_module("tests.export.test_three")
    found = reader.node.report("three_lights.mjs", path)
    return reader.irradiance(found, AXES["three"].to_target(NORMALS))


def radiance(path):
    """Irradiance that `rtrace` measures in 64 runs of few rays; it starts in the file's folder."""
    reader = importlib.import_module("tests.export.test_radiance")
    options = ["-ab", "1", "-ad", "4096", "-as", "0", "-aa", "0", "-lw", "1e-9", "-dj", "1"]
    here = Path.cwd()
    os.chdir(path.parent)
    try:
        return reader.irradiance(path, options, repeats=16)
    finally:
        os.chdir(here)


def pbrt(path):
    """Irradiance by the formulas of pbrt's book."""
    book = importlib.import_module("tests.reference.pbrt")
    return book.irradiance(path, AXES["pbrt"].to_target(NORMALS))


def engine(path):
    """Points, and harmonics or a map, of an engine."""
    reader = importlib.import_module("tests.export.test_engine")
    scene = json.loads(path.read_text())
    rig = reader.rig_of(scene)
    axes = AXES[path.suffixes[-2][1:]]
    points = el.Lights(rig.lights.direction, rig.lights.irradiance)
    there = NORMALS @ np.transpose(axes.matrix)
    around = scene.get("map") if "harmonics" not in scene else None
    if around:
        points_alone = el.Rig([0, 0, 0], points, 0.0).probe(there)
        return points_alone + el.EnvMap.open(path.parent / around).probe(NORMALS)
    return el.Rig(rig.ambient, points, 0.0).probe(there)


def blender(path):
    """Irradiance that Cycles renders."""
    reader = importlib.import_module("tests.export.test_blender")
    np.save(path.parent / "normals.npy", AXES["blender"].to_target(NORMALS))
    reader.run("irradiance", path.parent / "normals.npy", path)
    return np.load(path.with_suffix(".npy"))


def mujoco(path):
    """Irradiance by the formula of OpenGL's lights, which MuJoCo's renderer uses."""
    reader = importlib.import_module("tests.export.test_mujoco")
    return reader.by_formula(path.read_text())[0]


def godot(path):
    """Irradiance by the formulas of the shaders of Godot's renderer Forward+."""
    return importlib.import_module("tests.export.test_godot").irradiance_of_file(path)


def own(path):
    """Irradiance of a file of ours."""
    return el.Rig.load(path).probe(NORMALS)


#: Function that reads the irradiance at `NORMALS` from a file, by the name of its target.
READERS = {
    "json": own,
    "csv": own,
    "gltf": gltf,
    "three": three,
    "usd": lambda path: importlib.import_module("tests.export.test_usd").irradiance_in(path),
    "mitsuba": lambda path: importlib.import_module("tests.export.test_mitsuba").irradiance_of_file(
        path
    ),
    "blender": blender,
    "radiance": radiance,
    "pbrt": pbrt,
    "mujoco": mujoco,
    "godot": godot,
    "unity": engine,
    "unreal": engine,
}


def irradiance_of_file(rig, target):
    """Irradiance at `NORMALS` from the file of a rig."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        path = Path(folder).resolve() / f"rig{target.suffixes[0]}"
        rig.save(path)
        return READERS[target.name](path)


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
