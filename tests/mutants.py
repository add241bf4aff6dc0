"""Mutants: edits that break the package, each with a test that must fail.

`python -m tests.mutants [--rust] [WORD...]` applies each whose name holds a word (all without one)
to this checkout, runs its tests, and takes the edit back. It ends with 1 if a mutant survives. With
`--rust` those of the kernels run too: each compiles the package, which must be installed editable.
"""

import argparse
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parent.parent


class Mutant(NamedTuple):
    """An edit of one file, and the tests that notice it."""

    name: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]

    @property
    def is_rust(self):
        """True if the edit needs the compiler."""
        return self.file.endswith(".rs")


_PUBLIC = ("tests/test_public_maps.py",)


def _exporter(target, old, new, test=None):
    """Mutant of an exporter: its lights have two axes exchanged."""
    return Mutant(
        f"axes of {target}",
        f"python/envlights/export/formats/{target}.py",
        old,
        new,
        (f"tests/export/test_{test or target}.py",),
    )


def _with_axes_exchanged(target, argument="lights.direction"):
    """Mutant of an exporter that turns directions by the table of axes."""
    turned = f'AXES["{target}"].to_target({argument})'
    return _exporter(target, turned, f"{turned}[..., [2, 1, 0]]")


def _detector(name, radiance):
    """Mutant of the detector, which sees another map."""
    old = "_native.detect_tree(world.radiance,"
    file = "python/envlights/detection/detect.py"
    new = f"_native.detect_tree({radiance},"
    return Mutant(f"detector: {name}", file, old, new, _PUBLIC)


def _brighter(target, old, new):
    """Mutant of an exporter: its lights are 1 % too bright."""
    mutant = _exporter(target, old, new)
    return mutant._replace(name=f"lights of {target}: 1 % too bright")


#: Edits by name.
MUTANTS = (
    _detector("mirrored", "world.radiance[:, ::-1].copy()"),
    _detector("upside down", "world.radiance[::-1].copy()"),
    _detector("seven times as bright", "7 * world.radiance"),
    Mutant(
        "probe: 0.4 % too bright",
        "python/envlights/kernels/probe.py",
        "_native.irradiance(\n        image,",
        "_native.irradiance(\n        np.float32(1.004) * image,",
        _PUBLIC,
    ),
    _with_axes_exchanged("blender"),
    _with_axes_exchanged("gltf"),
    _with_axes_exchanged("godot"),
    _with_axes_exchanged("mujoco"),
    _with_axes_exchanged("pbrt"),
    _with_axes_exchanged("radiance"),
    _with_axes_exchanged("three", "direction"),
    _with_axes_exchanged("usd", "direction"),
    _exporter("csv", "lights.direction,", "lights.direction[:, [2, 1, 0]],"),
    _exporter(
        "engine",
        "axes.to_target(lights.direction)",
        "axes.to_target(lights.direction[:, [2, 1, 0]])",
    ),
    _exporter("mitsuba", "(0.0 - lights.direction[j])", "(0.0 - lights.direction[j][[2, 1, 0]])"),
    _brighter("usd", "*colour(irradiance)", "*colour(1.01 * irradiance)"),
    _brighter("mitsuba", "_rgb(lights.irradiance[j])", "_rgb(1.01 * lights.irradiance[j])"),
    _brighter("pbrt", "{_numbers(irradiance)}", "{_numbers(1.01 * irradiance)}"),
    _brighter("gltf", "**_strength(irradiance)", "**_strength(1.01 * irradiance)"),
    _brighter("three", "colour_of(irradiance)", "colour_of(1.01 * irradiance)"),
    Mutant(
        "rig.probe: 1 % too dark",
        "python/envlights/rigs/rig.py",
        "return values[0] if is_one else values",
        "return 0.99 * (values[0] if is_one else values)",
        ("tests/test_rig.py",),
    ),
    Mutant(
        "kernel of shadows: sign of the visibility",
        "src/kernels/fit/discs/zonal.rs",
        "probe * 0.5 * (1.0 - g / PI)",
        "probe * 0.5 * (1.0 + g / PI)",
        ("tests/fitting/test_search_on_public_maps.py", "tests/fitting/test_fit_sizes.py"),
    ),
)


def run(mutant):
    """First line that names a failed test under a mutant; empty if it survives."""
    path = ROOT / mutant.file
    source = path.read_text(encoding="utf-8")
    if source.count(mutant.old) != 1:
        raise SystemExit(f"{mutant.file} must hold {mutant.old!r} once, for {mutant.name!r}")
    path.write_text(source.replace(mutant.old, mutant.new), encoding="utf-8")
    try:
        if mutant.is_rust:
            compile_package()
        return failures(mutant.tests)
    finally:
        path.write_text(source, encoding="utf-8")


def compile_package():
    """Compile the kernels into the package, as an editable installation does."""
    subprocess.run([sys.executable, "-m", "maturin", "develop", "--release"], cwd=ROOT, check=True)


def failures(tests):
    """First line of pytest that names a failure, for some test files."""
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-x",
        "-o",
        "testpaths=tests",
        "-p",
        "no:cacheprovider",
        *tests,
    ]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    lines = done.stdout.splitlines()
    return next((line for line in lines if line.startswith(("FAILED", "ERROR"))), "")


def main():
    """Run the mutants that the command line names."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("words", nargs="*", help="parts of names; all mutants without one")
    parser.add_argument("--rust", action="store_true", help="also those that must be compiled")
    given = parser.parse_args()
    chosen = [
        mutant
        for mutant in MUTANTS
        if (given.rust or not mutant.is_rust)
        and (not given.words or any(word in mutant.name for word in given.words))
    ]
    survivors = 0
    for mutant in chosen:
        failed = run(mutant)
        survivors += not failed
        print(f"{mutant.name:44} {failed or 'SURVIVED'}", flush=True)
    if given.rust and any(mutant.is_rust for mutant in chosen):
        compile_package()
    return 1 if survivors else 0


if __name__ == "__main__":
    raise SystemExit(main())
