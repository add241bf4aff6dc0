"""`envlights photograph`: `envlights.detect_photograph` on a file."""

from __future__ import annotations

import json
from collections.abc import Sequence

import click

from envlights.cli.outputs import (
    check_output,
    default_of,
    output_option,
    say_written,
    verbose_option,
)
from envlights.detection.article_steps import SAMPLINGS
from envlights.detection.photograph import detect_photograph
from envlights.io.files import PICTURES


@click.command("photograph")
@click.argument("path", metavar="PHOTO")
@click.option(
    "--fov",
    type=float,
    metavar="DEGREES",
    help="Horizontal field of view, for directions; by default that of the EXIF, if there is one.",
)
@click.option("-n", "--max-lights", type=int, help="Largest number of lights; others are dropped.")
@click.option(
    "--relative/--absolute",
    default=default_of(detect_photograph, "relative"),
    show_default=True,
    help="Levels from the picture's own histogram, or the fixed ones of Loghin (2021).",
)
@click.option(
    "--sampling",
    type=click.Choice(list(SAMPLINGS)),
    default=default_of(detect_photograph, "sampling"),
    show_default=True,
    help="Sequence of the samples.",
)
@output_option("Picture to write: samples, maxima and lights (.png, .pdf, .svg). Can be repeated.")
@verbose_option()
@click.option("--json", "as_json", is_flag=True, help="Print the lights as JSON.")
def command(
    path: str,
    fov: float | None,
    max_lights: int | None,
    relative: bool,
    sampling: str,
    outputs: Sequence[str],
    verbose: bool,
    as_json: bool,
) -> None:
    """Find the lights of PHOTO, a plane picture of any aspect (.jpg, .png, .tif, .exr, .hdr)."""
    for output in outputs:
        check_output(output, PICTURES, {"the photograph": path})
    lights = detect_photograph(
        path, fov, max_lights=max_lights, relative=relative, sampling=sampling
    )
    if outputs:
        # Importing Matplotlib takes a second.
        from envlights import plot

        figure = plot.photograph(lights)
        for output in outputs:
            plot.save(figure, output)
    text = lights.verbose() if verbose else str(lights)
    click.echo(json.dumps(lights.to_dict(), indent=2) if as_json else text)
    say_written(outputs)
