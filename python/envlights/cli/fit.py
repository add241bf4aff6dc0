"""`envlights fit`: `envlights.fit` on a file."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import partial
from typing import Any

import click

from envlights._common.files import PICTURES
from envlights._common.printable import printable
from envlights.batches.work import check_options
from envlights.cli.options.fit_input import (
    fixed_of,
    radius_of,
    roughness_option,
    shape_options,
    start_of,
    start_options,
)
from envlights.cli.options.map_input import (
    MapCommand,
    MapFile,
    map_argument,
    radiance_or_name,
    unseen_option,
)
from envlights.cli.options.outputs import (
    OUTPUTS,
    as_dict,
    check_outputs,
    is_picture,
    json_option,
    output_option,
    print_result,
    say_written,
    stage_options,
    strict_option,
    verbose_option,
    write,
)
from envlights.cli.options.sun_input import sun_options
from envlights.environment.envmap import EnvMap
from envlights.export.capabilities import Capabilities
from envlights.export.targets import SUFFIXES, shown_by, target_of
from envlights.fitting.fit import fit
from envlights.fitting.request import AMBIENTS, AUTO
from envlights.rigs.rig import Rig
from envlights.sun.choice import AnySun


@click.command("fit", cls=MapCommand)
@map_argument
@click.option("-n", "--lights", type=int, help="Largest number of lights; 4 by default.")
@click.option(
    "--error",
    type=float,
    help="Largest error, such as 0.01 for 1 %; the fewest lights that reach it are used.",
)
@click.option(
    "--shadow-error",
    type=float,
    help="Largest error with shadows, such as 0.05; the fewest lights that reach it are used.",
)
@click.option(
    "--gloss-error",
    type=float,
    help="Largest error on shiny metal, such as 0.1; the fewest lights that reach it are used.",
)
@roughness_option("that metal")
@shape_options
@click.option(
    "--ambient",
    type=click.Choice([*AMBIENTS, AUTO]),
    help="Light from all directions; sh2: 9 harmonics; auto: the best. Default: constant, or auto"
    " for programs that show harmonics.",
)
@click.option(
    "--target",
    "targets",
    multiple=True,
    metavar="NAME",
    help="Program that will show the lights; default: the program of each output. Can be repeated.",
)
@click.option(
    "--one-rig",
    is_flag=True,
    help="Fit one rig for all output files instead of one for each program.",
)
@start_options
@sun_options
@unseen_option()
@output_option(OUTPUTS)
@stage_options
@strict_option()
@verbose_option()
@json_option("rig")
def command(
    map_file: MapFile,
    max_radius: float | None,
    targets: Sequence[str],
    one_rig: bool,
    start: str,
    fixed: Sequence[str],
    fill: str | None,
    outputs: Sequence[str],
    stage: dict[str, Any],
    strict: bool,
    verbose: bool,
    as_json: bool,
    sun: AnySun | None,
    **options: Any,
) -> None:
    """Fit an ambient term and a few lights to MAP (.hdr, .exr, .png, .jpg, .tif)."""
    check_outputs(outputs, (*SUFFIXES, *PICTURES), {"the map": map_file.path}, stage)
    choice = radiance_or_name(fill)
    options |= {
        "max_radius": radius_of(max_radius),
        "start": start_of(start),
        "fixed": fixed_of(fixed, map_file.frame),
        "fill": choice,
    }
    check_options("fit", {**options, "target": targets})
    groups = {_targets_of(outputs): list(outputs)} if one_rig else _groups(outputs)
    if targets:
        groups = {tuple(targets): list(outputs)}
    # Read the map once if a picture needs all its pixels, or if there are several fits.
    is_read = any(map(is_picture, outputs)) or len(groups) > 1
    env = map_file.open(choice) if is_read else None
    world, seen = (map_file.unread(choice), None) if env is None else (env, env.filled(choice))
    rigs = {names: fit(world, sun=sun, target=names, **options) for names in groups}
    for names, files in groups.items():
        picture = partial(_picture, seen, rigs[names])
        write(files, rigs[names].save, picture, strict=strict, stage=stage)
    _print(rigs, groups, as_json, verbose, map_file.frame)
    say_written(outputs)


def _picture(env: EnvMap | None, rig: Rig, plot: Any) -> Any:
    return plot.picture(env, rig)


def _groups(outputs: Sequence[str]) -> dict[tuple[str, ...], list[str]]:
    """Output files grouped by the target programs of their fit.

    Programs that show the same share one. Pictures and our own files, which show everything, join
    the only program, or have a fit of their own beside several.
    """
    found: dict[Capabilities | None, list[str]] = {}
    for output in outputs:
        names = _targets_of([output])
        found.setdefault(shown_by(names) if names else None, []).append(output)
    if len(found) == 2 and None in found:
        return {_targets_of(outputs): list(outputs)}
    return {_targets_of(files): files for files in found.values()} or {(): []}


def _print(
    rigs: dict[tuple[str, ...], Rig],
    groups: dict[tuple[str, ...], list[str]],
    as_json: bool,
    verbose: bool,
    frame: str | None,
) -> None:
    """Print a single rig, or each rig below the names of its files."""
    if len(rigs) == 1:
        print_result(next(iter(rigs.values())), as_json, verbose, frame)
    elif as_json:
        each = {file: as_dict(rigs[n], frame) for n, files in groups.items() for file in files}
        click.echo(json.dumps(each, indent=2))
    else:
        for names, rig in rigs.items():
            click.echo(f"{printable(', '.join(groups[names]))}:")
            print_result(rig, False, verbose, frame)
            click.echo()


def _targets_of(outputs: Sequence[str]) -> tuple[str, ...]:
    """Names of the programs that will show the rig; native formats impose no limits."""
    named = {target_of(output).name for output in outputs if not is_picture(output)}
    return tuple(sorted(named - {"json", "csv"}))
