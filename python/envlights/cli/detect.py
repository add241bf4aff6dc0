"""`envlights detect`: `envlights.detect` on a file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import click

from envlights._common.files import PICTURES
from envlights._native import EnvLightsError
from envlights.batches.work import check_options
from envlights.cli.options.detection_input import METHODS, SETTINGS, detection_settings
from envlights.cli.options.map_input import MapCommand, MapFile, map_argument
from envlights.cli.options.outputs import (
    OUTPUTS,
    check_outputs,
    json_option,
    output_option,
    print_result,
    say_written,
    stage_options,
    verbose_option,
    write,
)
from envlights.cli.options.settings import settings_option, with_settings
from envlights.export.targets import SUFFIXES
from envlights.papers.loghin_steps import SAMPLINGS


@click.command("detect", cls=MapCommand)
@map_argument
@click.option(
    "-n", "--lights", type=int, help="Largest number of lights; the others are left where they are."
)
@click.option(
    "--max-lights", type=int, help="Largest number of lights by merging neighbours (method tree)."
)
@click.option(
    "--method",
    type=click.Choice(list(METHODS)),
    default="tree",
    show_default=True,
    help="Method of detection; loghin: the steps of Loghin (2021).",
)
@click.option(
    "--sampling",
    type=click.Choice(list(SAMPLINGS)),
    help="Sequence of the samples of --method loghin; hammersley by default.",
)
@settings_option("method", SETTINGS)
@output_option(OUTPUTS)
@stage_options
@verbose_option()
@json_option("lights")
def command(
    map_file: MapFile,
    lights: int | None,
    max_lights: int | None,
    method: str,
    sampling: str | None,
    settings: Sequence[str],
    outputs: Sequence[str],
    stage: dict[str, Any],
    verbose: bool,
    as_json: bool,
) -> None:
    """Find the lights of MAP (.hdr, .exr, .png, .jpg, .tif)."""
    check_outputs(outputs, (*SUFFIXES, *PICTURES), {"the map": map_file.path}, stage)
    if sampling is not None and method != "loghin":
        raise EnvLightsError(f"--sampling is an option of --method loghin; got {method}")
    options = detection_settings(settings, method)
    options |= {} if sampling is None else {"sampling": sampling}
    options = with_settings(METHODS[method], options)
    options["lights"] = lights
    if max_lights is not None:
        if method != "tree":
            raise EnvLightsError(f"--max-lights is an option of --method tree; got {method}")
        options["max_lights"] = max_lights
    check_options("detect", options, METHODS[method])
    env = map_file.open()
    found = METHODS[method](env, **options)
    write(outputs, found.save, lambda plot: plot.detection_picture(env, found), stage=stage)
    print_result(found, as_json, verbose, map_file.frame)
    say_written(outputs)
