"""`envlights export`: `envlights.export.save` on a file of a rig or of lights."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from envlights._native import EnvLightsError
from envlights.cli.options.outputs import (
    check_outputs,
    output_option,
    print_losses,
    say_written,
    stage_of,
    stage_options,
    strict_option,
)
from envlights.cli.options.standard_streams import STANDARD_INPUT
from envlights.detection.lights_file import load_lights
from envlights.environment.envmap import EnvMap
from envlights.export.saving import save
from envlights.export.targets import SUFFIXES, TARGETS


def _table() -> str:
    """List of targets for the help."""
    lines = ["\b", "Targets, and the parts of a rig that each shows:"]
    for target in TARGETS:
        lines.append(f"  {target.name}: {target.title} ({', '.join(target.suffixes)})")
        lines += [f"      {line}" for line in target.lines()]
    return "\n".join(lines)


@click.command("export", epilog=_table())
@click.argument("rig_path", metavar="RIG")
@click.argument("targets", metavar="[TARGET...]", nargs=-1)
@output_option("TARGET: a file or a name. Can be repeated.")
@click.option("--environment", metavar="MAP", help="Map that replaces the ambient term.")
@stage_options
@strict_option()
def command(
    rig_path: str,
    targets: Sequence[str],
    outputs: Sequence[str],
    environment: str | None,
    stage: dict[str, Any],
    strict: bool,
) -> None:
    """Write RIG, a file of `fit` or `detect` (.json, .csv), for other programs.

    TARGET is a file, whose suffix selects the program, or the name of a target. If TARGET is only a
    name, the file goes next to RIG. Textures go next to each file.
    """
    outputs = [_place(rig_path, target) for target in (*outputs, *targets)]
    if not outputs:
        raise EnvLightsError("there is no file to write; give -o, such as -o rig.usda or -o usd")
    inputs = {"the rig": rig_path, **({"the map": environment} if environment else {})}
    check_outputs(outputs, SUFFIXES, inputs, stage)
    rig = load_lights(rig_path)
    env = None if environment is None else EnvMap.open(environment)
    for output in outputs:
        with print_losses(strict=strict):
            save(rig, output, env, **stage_of(output, stage))
    say_written(outputs)


def _place(rig_path: str, target: str) -> str:
    """Output path for TARGET, which is a path or the name of a target."""
    suffixes = {each.name: each.suffixes[0] for each in TARGETS}
    if target not in suffixes:
        if "." not in target:
            wanted = f"a target ({', '.join(suffixes)}) or a file with a suffix"
            raise EnvLightsError(f"cannot write {target}: it must be the name of {wanted}")
        return target
    if Path(rig_path).stem == STANDARD_INPUT:
        raise EnvLightsError(f"a rig from the standard input has no name for {target}; give a file")
    if not Path(rig_path).name:
        raise EnvLightsError(
            f"cannot write {target} beside '{rig_path}', which names no file; give a file of a rig"
        )
    return str(Path(rig_path).with_suffix(suffixes[target]))
