"""Lights that programs read from our files, in old and new versions, against the rig: a table.

Each version is installed by pip in an environment of its own; `tests/export/package.json` has the
releases of three.js. Each program reads the files itself, by the readers of `tests/export`: the
angle between lamps, and the relative RMS difference of the irradiance on all planes. If a program
is said not to show a part, its figure is followed by the loss and by the difference from the rig
with that loss.

Usage: python benchmarks/programs.py [PROGRAM...] [--environments FOLDER] [--out FILE]
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import warnings
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from shutil import which
from typing import NamedTuple

_ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(_ROOT), str(_ROOT / "python")]

#: Newest version that a registry has.
NEWEST = "newest"
#: Readers that run in a process of their own, whose Python need not have our package.
OTHERS = {name: f"ENVLIGHTS_{name.upper()}_PYTHON" for name in ("blender", "sapien", "genesis")}
#: Percent from which a difference must have a name.
NAMED = 1
TITLES = ("program", "version", "directions", "irradiance", "harmonics", "a size", "a card")


class Program(NamedTuple):
    """Program, the target of its files, its package and versions of it."""

    title: str
    target: str
    package: str
    versions: tuple[str, ...] = (NEWEST,)
    reader: str = "file"
    python: str = "python3.11"
    needs: tuple[str, ...] = ()


PROGRAMS = (
    Program("OpenUSD", "usd", "usd-core", ("24.11", NEWEST)),
    Program("Mitsuba", "mitsuba", "mitsuba", ("3.5.2", NEWEST)),
    Program("MuJoCo", "mujoco", "mujoco", ("3.2.0", "3.3.0", NEWEST), "mujoco"),
    Program("MuJoCo Warp", "mujoco", "mujoco", (NEWEST,), "warp", needs=("mujoco-warp",)),
    Program("three.js", "three", "three", ("three-150", "three-160", "three-180", "three"), "node"),
    Program("three.js, GLTFLoader", "gltf", "three", ("three",), "node"),
    Program("Blender, Cycles", "blender", "bpy", ("4.2.0", "5.0.1"), "blender"),
    Program("Blender, Cycles", "blender", "bpy", (NEWEST,), "blender", "python3.13"),
    Program("SAPIEN", "sapien", "sapien", (NEWEST,), "sapien"),
    Program("Genesis", "genesis", "genesis-world", (NEWEST,), "genesis", needs=("torch",)),
    Program("Radiance", "radiance", "pyradiance"),
)


def main():
    """Print the table, and write it to a file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("programs", nargs="*", help="targets; all by default")
    parser.add_argument("--environments", type=Path, help="folder of environments, kept and reused")
    parser.add_argument("--out", type=Path, help="file for the table")
    parser.add_argument("--measure", nargs=4, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.measure:
        sys.stdout.write("FIGURES " + json.dumps(figures(*options.measure)))
        return
    with tempfile.TemporaryDirectory() as folder:
        lines = ["| " + " | ".join(TITLES) + " |", "|" + "---|" * len(TITLES)]
        print(*lines, sep="\n", flush=True)
        for line in rows(options.programs, options.environments or Path(folder)):
            print(line, flush=True)
            lines.append(line)
    if options.out:
        options.out.write_text("\n".join(lines) + "\n", encoding="utf-8")


def rows(names, folder):
    """Row of each version of each program."""
    for program in PROGRAMS:
        for wanted in program.versions:
            if names and program.target not in names:
                continue
            try:
                python = environment(program, wanted, folder)
                cells = measure(program, wanted, python)
            except RuntimeError as reason:
                cells = [wanted, str(reason)]
            yield f"| {program.title} | {' | '.join(cells)} |"


def environment(program, wanted, folder):
    """Python with a version of a package; `folder` keeps it."""
    if program.reader == "node":
        return sys.executable
    place = folder / f"{program.package}-{wanted}"
    python = place / "bin/python"
    if not python.exists():
        base = which(program.python) or sys.executable
        each = program.package if wanted == NEWEST else f"{program.package}=={wanted}"
        call([base, "-m", "venv", place])
        packages = [each, *program.needs, "numpy", "scipy", "pytest", "setuptools"]
        call([python, "-m", "pip", "install", "--quiet", *packages])
    return python


def call(command, **options):
    """Output of a process, or a RuntimeError with its last line."""
    done = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    if done.returncode:
        raise RuntimeError((done.stderr.strip() or "no output").splitlines()[-1][:120])
    return done.stdout


def measure(program, wanted, python):
    """Cells of a row, measured in a process of its own."""
    changes = {"MUJOCO_GL": "egl", "MPLBACKEND": "Agg"}
    runner = python
    if program.reader in OTHERS:
        changes[OTHERS[program.reader]], runner = str(python), sys.executable
    command = [runner, __file__, "--measure", program.target, program.reader, wanted]
    out = call([*command, program.package], env=os.environ | changes)
    return json.loads(out.rpartition("FIGURES ")[2])


def figures(name, reader, wanted, package):
    """Version, and the cell of each part of a rig."""
    import numpy as np
    from tests.export import cards
    from tests.export.rigs import POINTS, rigs

    import envlights as el

    lamps = np.linalg.qr(np.transpose(POINTS.direction[:3]))[0].T
    parts = {
        "directions": el.Rig([0, 0, 0], el.Lights(lamps, 3 * np.eye(3)), 0.0),
        "irradiance": rigs(POINTS[:3])["constant"],
        "harmonics": rigs(POINTS[:1])["harmonics"],
        "size": el.Rig([0, 0, 0], el.Lights([[0.48, 0.8, 0.36]], [[3, 2, 1]], [0.5]), 0.0),
        "card": cards.WINDOW,
    }
    cells = [cell(part, thing, name, reader, wanted) for part, thing in parts.items()]
    return [version_of(reader, wanted, package), *cells]


def version_of(reader, wanted, package):
    """Version that was measured."""
    if reader == "node":
        path = _ROOT / "tests/export/node_modules" / wanted / "package.json"
        return json.loads(path.read_text())["version"]
    if reader in OTHERS:
        code = f"from importlib.metadata import version; print(version({package!r}))"
        return call([os.environ[OTHERS[reader]], "-c", code]).strip()
    return version(package)


def cell(part, thing, name, reader, wanted):
    """Text of a part: its difference, and where it is said to be lost, that from the loss."""
    from tests.export.rigs import relative

    if (part, name) == ("card", "gltf"):
        return "a plane that shines, not a light"
    normals, seen = irradiance_of(part, thing, name, reader, wanted)
    truth, promise, loss = expected_of(part, thing, name, normals)
    if part == "directions":
        return f"{worst_angle(normals, seen, truth):.1g}°"
    off, rest = (100 * relative(seen, there) for there in (truth, promise))
    return f"{off:.2g} %" if off < NAMED or not loss else f"{off:.2g} %: {loss}, {rest:.2g} %"


def expected_of(part, thing, name, normals):
    """Irradiance of a rig or a card, that which the target is said to show, and the loss."""
    from tests.export import cards

    from envlights.export.targets import target_named

    shows = target_named(name).shows
    if part != "card":
        losses = " and ".join(shows.losses(thing))
        return thing.probe(normals), shows.irradiance(thing, normals), losses
    truth, lights = cards.irradiance(thing, normals), thing.lights
    if not shows.cards:
        return truth, shows.irradiance(lights, normals), "a disc or a point"
    uniform = set(shows.uniform_cards) & set(thing.shape)
    promise = thing.probe(normals, uniform=shows.uniform_cards)
    return truth, promise, "in one colour" if uniform else ""


def worst_angle(normals, seen, truth):
    """Largest angle in degrees between the lamps of two irradiances, one in each channel."""
    import numpy as np
    from tests.helpers import angle_deg

    towards = []
    for each in (seen, truth):
        lit = [column > 0.1 * column.max() for column in each.T]
        pairs = zip(lit, each.T, strict=True)
        found = [np.linalg.lstsq(normals[on], column[on])[0] for on, column in pairs]
        towards.append([direction / np.linalg.norm(direction) for direction in found])
    return angle_deg(*map(np.array, towards)).max()


def irradiance_of(part, thing, name, reader, wanted):
    """Normals, and the irradiance there of a file as the program reads it."""
    import envlights as el
    from envlights.export.targets import target_named

    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        there = Path(folder).resolve()
        path = there / f"rig{target_named(name).suffixes[0]}"
        el.export.save(thing, path)
        if reader in ("mujoco", "warp"):
            return of_balls(there, reader)
        if reader in ("sapien", "genesis"):
            return of_simulator(there, reader)
        return of_file(path, part, target_named(name), wanted)


def of_file(path, part, target, wanted):
    """Irradiance at the normals of the tests, by their readers of a file."""
    from tests.export import file_errors, node
    from tests.helpers import NORMALS

    module = file_errors.readers_of(target)
    if part == "card" and target.name == "usd":
        path.rename(path.with_name("scene.usda"))
        cards = import_module("tests.export.test_cards_usd")
        return NORMALS, cards.irradiance_of_scene(path.parent, NORMALS)
    if part == "card" and target.name == "mitsuba":
        cards = import_module("tests.export.test_cards_mitsuba")
        with cards.mitsuba() as mi:
            return NORMALS, cards.irradiance_in(cards.load(path, mi), mi)
    if target.name in ("three", "gltf"):
        found = node.report("three_lights.mjs", path, wanted)
        added = ambient_of_extras(path) if target.name == "gltf" else 0
        three = import_module("tests.export.test_three")
        return NORMALS, three.irradiance(found, target.axes.to_target(NORMALS)) + added
    return NORMALS, module.irradiance_of_file(path)


def ambient_of_extras(path):
    """Irradiance of the ambient term in a glTF asset, which is to be set by hand."""
    import numpy as np

    asset = json.loads(path.read_text())
    ambient = np.array(asset["scenes"][0].get("extras", {}).get("ambient", [0, 0, 0]))
    return np.pi * (ambient if ambient.ndim == 1 else ambient[0] * 0.5 / np.sqrt(np.pi))


def of_balls(folder, reader):
    """Normals and irradiance of two pictures of a white ball in MuJoCo."""
    import mujoco
    import numpy as np
    from tests.export import test_mujoco
    from tests.export.balls import SIDES, normals_of

    images, scale = (
        test_mujoco.pictures_of_warp(folder)
        if reader == "warp"
        else test_mujoco.pictures(mujoco, folder, test_mujoco.sides())
    )
    normals, balls = zip(*map(normals_of, SIDES), strict=True)
    seen = [image[ball] / (255 * scale) for image, ball in zip(images, balls, strict=True)]
    return np.concatenate(normals), np.concatenate(seen)


def of_simulator(folder, name):
    """Normals and irradiance: of two pictures by SAPIEN, of the lights that Genesis has read."""
    import runpy

    import numpy as np
    from tests.export import test_simulators
    from tests.export.balls import SIDES, normals_of
    from tests.helpers import NORMALS

    scale = runpy.run_path(str(folder / f"rig.{name}.py"))["SCALE"]
    if name == "genesis":  # its surfaces have a gloss
        *lamps, (_, ambient) = test_simulators.images("lights", folder, name)
        there = test_simulators.AXES[name].to_target(NORMALS)
        lit = [np.maximum(there @ to, 0)[:, None] * rgb / np.pi for to, rgb in lamps]
        return NORMALS, (sum(lit) + ambient) / scale
    normals, seen = [], []
    for image, side in zip(test_simulators.images(name, folder, name), SIDES, strict=True):
        there, ball = normals_of(side)
        is_inner = there @ side[2] > test_simulators.INNER
        normals.append(there[is_inner])
        seen.append((image[ball][is_inner] / 255) ** 2.2 / scale)
    return np.concatenate(normals), np.concatenate(seen)


if __name__ == "__main__":
    main()
