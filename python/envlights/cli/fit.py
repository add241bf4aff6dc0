"""`envlights fit`: `envlights.fit` on a file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
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
    check_output,
    output_option,
    print_losses,
    print_rig,
    say_written,
    strict_option,
    verbose_option,
)
from envlights.cli.sun_input import sun_options
from envlights.environment.envmap import EnvMap
from envlights.export.targets import SUFFIXES, target_of
from envlights.fitting.ambient_terms import AMBIENTS, AUTO
from envlights.fitting.fit import fit
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
@strict_option()
@verbose_option()
@click.option("--json", "as_json", is_flag=True, help="Print the rig as JSON.")
def command(
    map_file: MapFile,
    lights: int | None,
    error: float | None,
    shadow_error: float | None,
    gloss_error: float | None,
    roughness: float,
    sizes: bool,
    max_radius: float | None,
    objective: str,
    ambient: str | None,
    targets: Sequence[str],
    floor: bool,
    start: str,
    fixed: Sequence[str],
    fill: str | None,
    outputs: Sequence[str],
    strict: bool,
    verbose: bool,
    as_json: bool,
    sun: AnySun | None,
) -> None:
    """Fit an ambient term and a few lights to MAP (.hdr, .exr, .png, .jpg, .tif)."""
    for output in outputs:
        check_output(output, (*SUFFIXES, *PICTURES), {"the map": map_file.path})
    choice = radiance_or_name(fill)
    options: dict[str, Any] = {
        "lights": lights,
        "error": error,
        "shadow_error": shadow_error,
        "gloss_error": gloss_error,
        "roughness": roughness,
        "sizes": sizes,
        "max_radius": radius_of(max_radius),
        "objective": objective,
        "ambient": ambient,
        "start": start_of(start),
        "fixed": fixed_of(fixed),
        "floor": floor,
        "fill": choice,
        "target": targets or _targets_of(outputs),
    }
    check_options("fit", options)
    # A picture of the map needs all of its pixels.
    env = map_file.open(choice) if any(map(_is_picture, outputs)) else None
    rig = fit(map_file.unread(choice) if env is None else env, sun=sun, **options)
    for output in outputs:
        _write(env and env.filled(choice), rig, output, strict)
    print_rig(rig, as_json, verbose)
    say_written(outputs)


def _is_picture(output: str) -> bool:
    return Path(output).suffix.lower() in PICTURES


def _targets_of(outputs: Sequence[str]) -> tuple[str, ...]:
    """Names of the programs that will show the rig; our own files limit nothing."""
    named = {target_of(output).name for output in outputs if not _is_picture(output)}
    return tuple(sorted(named - {"json", "csv"}))


def _write(env: EnvMap | None, rig: Rig, output: str, strict: bool) -> None:
    if env is None or not _is_picture(output):
        with print_losses(strict=strict):
            rig.save(output)
        return
    # Importing Matplotlib takes a second.
    from envlights import plot

    plot.save(plot.picture(env, rig), output)
