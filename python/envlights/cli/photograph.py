"""`envlights photograph`: `envlights.detect_photograph` on a file."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click
import numpy as np

from envlights._common.files import PICTURES
from envlights.cli.outputs import (
    OUTPUTS,
    check_output,
    output_option,
    say_written,
    verbose_option,
)
from envlights.cli.settings import settings_from, settings_of, settings_option, with_settings
from envlights.export.targets import SUFFIXES
from envlights.papers.loghin_steps import PHOTOGRAPH, SAMPLINGS
from envlights.papers.photograph import detect_photograph
from envlights.papers.photograph_lights import PhotographLights

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
    "-n", "--lights", "--max-lights", type=int, help="Largest number of lights; others are dropped."
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
@verbose_option()
@click.option("--json", "as_json", is_flag=True, help="Print the lights as JSON.")
def command(
    path: str,
    fov: float | None,
    colour: str | None,
    part: str | None,
    lights: int | None,
    relative: bool,
    sampling: str,
    settings: Sequence[str],
    outputs: Sequence[str],
    verbose: bool,
    as_json: bool,
) -> None:
    """Find the lights of PHOTO, a plane picture of any aspect (.jpg, .png, .tif, .exr, .hdr)."""
    for output in outputs:
        check_output(output, (*SUFFIXES, *PICTURES), {"the photograph": path})
    given = settings_from(settings, "detection", _SETTINGS.__contains__)
    given |= {"relative": relative, "sampling": sampling}
    options: dict[str, Any] = {"fov": fov, "lights": lights}
    options |= with_settings(detect_photograph, given)
    detect_photograph(np.ones((8, 16, 3), np.float32), **options)  # refuses impossible options
    found = detect_photograph(path, colour=colour, part=part, **options)
    for output in outputs:
        _write(found, output)
    text = found.verbose() if verbose else str(found)
    click.echo(json.dumps(found.to_dict(), indent=2) if as_json else text)
    say_written(outputs)


def _write(lights: PhotographLights, output: str) -> None:
    if Path(output).suffix.lower() not in PICTURES:
        lights.save(output)
        return
    # Importing Matplotlib takes a second.
    from envlights import plot

    plot.save(plot.photograph(lights), output)
