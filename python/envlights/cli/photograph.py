"""`envlights photograph`: `envlights.detect_photograph` on a file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import click
import numpy as np

from envlights._common.files import PICTURES
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
from envlights.cli.options.settings import (
    settings_from,
    settings_of,
    settings_option,
    with_settings,
)
from envlights.export.targets import SUFFIXES
from envlights.papers.loghin_steps import PHOTOGRAPH, SAMPLINGS
from envlights.papers.photograph import detect_photograph

#: Parameters without an option of their own.
_SETTINGS = settings_of(
    [detect_photograph], ("fov", "colour", "part", "lights", "relative", "sampling")
)


@click.command("photograph")
@click.argument("path", metavar="PHOTO")
@click.option(
    "--fov",
    type=float,
    metavar="DEGREES",
    help="Horizontal field of view, for directions; by default that of the EXIF, if there is one.",
)
@click.option(
    "--colour",
    metavar="SPACE",
    help="Colour space of PHOTO instead of what the file says: linear, srgb, p3, ...",
)
@click.option("--part", help="Part or layer of PHOTO, by name or number from 0.")
@click.option(
    "-n", "--lights", type=int, help="Largest number of lights; the others are left where they are."
)
@click.option(
    "--relative/--absolute",
    default=PHOTOGRAPH.relative,
    show_default=True,
    help="Levels from the picture's own histogram, or the fixed ones of Loghin (2021).",
)
@click.option(
    "--sampling",
    type=click.Choice(list(SAMPLINGS)),
    default=PHOTOGRAPH.sampling,
    show_default=True,
    help="Sequence of the samples.",
)
@settings_option("detection", _SETTINGS)
@output_option(OUTPUTS)
@stage_options
@verbose_option()
@json_option("lights")
def command(
    path: str,
    colour: str | None,
    part: str | None,
    lights: int | None,
    relative: bool,
    sampling: str,
    settings: Sequence[str],
    outputs: Sequence[str],
    stage: dict[str, Any],
    verbose: bool,
    as_json: bool,
    **options: Any,
) -> None:
    """Find the lights of PHOTO, a plane picture of any aspect (.jpg, .png, .tif, .exr, .hdr)."""
    check_outputs(outputs, (*SUFFIXES, *PICTURES), {"the photograph": path}, stage)
    given = settings_from(settings, "detection", _SETTINGS.__contains__)
    given |= {"relative": relative, "sampling": sampling}
    options["lights"] = lights
    options |= with_settings(detect_photograph, given)
    detect_photograph(np.ones((8, 16, 3), np.float32), **options)  # refuses impossible options
    found = detect_photograph(path, colour=colour, part=part, **options)
    write(outputs, found.save, lambda plot: plot.photograph(found), stage=stage)
    print_result(found, as_json, verbose)
    say_written(outputs)
