"""`envlights fit`: `envlights.fit` on a file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import click

from envlights._common.files import PICTURES
from envlights.batches.work import check_options
from envlights.cli.fit_input import (
    fixed_of,
    radius_of,
    roughness_option,
    shape_options,
    start_of,
    start_options,
)
from envlights.cli.map_input import (
    MapCommand,
    MapFile,
    map_argument,
    radiance_or_name,
    unseen_option,
)
from envlights.cli.outputs import (
    OUTPUTS,
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
from envlights.cli.sun_input import sun_options
from envlights.export.targets import SUFFIXES, target_of
from envlights.fitting.fit import fit
from envlights.fitting.request import AMBIENTS, AUTO
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
    help="Light from all directions; sh2: smooth, 9 spherical harmonics; auto: the best of them."
    " Default: constant, or auto for programs that show harmonics.",
)
@click.option(
    "--target",
    "targets",
    multiple=True,
    metavar="NAME",
    help="Program that will show the lights (list: envlights export -h). Can be repeated. Default:"
    " the programs of -o.",
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
        "fixed": fixed_of(fixed),
        "fill": choice,
        "target": targets or _targets_of(outputs),
    }
    check_options("fit", options)
    # A picture of the map needs all of its pixels.
    env = map_file.open(choice) if any(map(is_picture, outputs)) else None
    rig = fit(map_file.unread(choice) if env is None else env, sun=sun, **options)
    seen = env and env.filled(choice)
    write(outputs, rig.save, lambda plot: plot.picture(seen, rig), strict=strict, stage=stage)
    print_result(rig, as_json, verbose)
    say_written(outputs)


def _targets_of(outputs: Sequence[str]) -> tuple[str, ...]:
    """Names of the programs that will show the rig; our own files limit nothing."""
    named = {target_of(output).name for output in outputs if not is_picture(output)}
    return tuple(sorted(named - {"json", "csv"}))
