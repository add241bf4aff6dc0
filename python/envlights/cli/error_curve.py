"""`envlights error-curve`: `envlights.error_curve` on a file."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from envlights.cli.fit_input import radius_of, roughness_option, shape_options
from envlights.cli.map_input import (
    MapCommand,
    MapFile,
    map_argument,
    radiance_or_name,
    unseen_option,
)
from envlights.cli.numbers import whole_numbers
from envlights.cli.outputs import check_output, output_option, say_written
from envlights.comparison.folders import TABLE_FILES, save_table
from envlights.fitting.ambient_terms import AMBIENTS, AUTO
from envlights.fitting.error_curve import ErrorCurve, error_curve
from envlights.io.files import PICTURES
from envlights.many.work import check_options


@click.command("error-curve", cls=MapCommand)
@map_argument
@click.option(
    "-n",
    "--lights",
    default="0-8",
    metavar="NUMBERS",
    help="Largest numbers of lights, such as 0-8 or 1,2,4.",
    show_default=True,
)
@shape_options
@roughness_option("the metal of the gloss error")
@click.option("--ambient", type=click.Choice([*AMBIENTS, AUTO]), help="Light from all directions.")
@unseen_option()
@output_option("File to write: a table (.csv, .json) or a picture (.png, .pdf, .svg). Repeatable.")
@click.option("--json", "as_json", is_flag=True, help="Print the curve as JSON.")
def command(
    map_file: MapFile,
    lights: str,
    sizes: bool,
    max_radius: float | None,
    objective: str,
    floor: bool,
    roughness: float,
    ambient: str | None,
    unseen: str | None,
    outputs: Sequence[str],
    as_json: bool,
) -> None:
    """Fit MAP with several numbers of lights, and compare the errors."""
    for output in outputs:
        check_output(output, (*TABLE_FILES, *PICTURES), {"the map": map_file.path})
    numbers, choice = whole_numbers("--lights", lights), radiance_or_name(unseen)
    options: dict[str, Any] = {
        "roughness": roughness,
        "sizes": sizes,
        "max_radius": radius_of(max_radius),
        "objective": objective,
        "ambient": ambient,
        "floor": floor,
        "unseen": choice,
    }
    check_options("error_curve", {"lights": numbers, **options})
    curve = error_curve(map_file.unread(choice), numbers, **options)
    for output in outputs:
        _write(curve, output)
    click.echo(json.dumps(curve.to_dict(), indent=2) if as_json else str(curve))
    say_written(outputs)


def _write(curve: ErrorCurve, output: str) -> None:
    if Path(output).suffix.lower() in PICTURES:
        # Importing Matplotlib takes a second.
        from envlights import plot

        plot.save(plot.error_curve(curve), output)
    else:
        save_table(output, curve.to_csv(), curve.to_dict())
