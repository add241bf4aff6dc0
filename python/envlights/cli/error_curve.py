"""`envlights error-curve`: `envlights.error_curve` on a file."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from envlights._common.files import PICTURES
from envlights.cli.fit_input import curve_arguments, curve_options
from envlights.cli.map_input import MapCommand, MapFile, map_argument
from envlights.cli.numbers import whole_numbers
from envlights.cli.outputs import check_output, output_option, say_written
from envlights.fitting.error_curve import ErrorCurve, error_curve


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
@curve_options
@output_option("File to write: a table (.csv, .json) or a picture (.png, .pdf, .svg). Repeatable.")
@click.option("--json", "as_json", is_flag=True, help="Print the curve as JSON.")
def command(
    map_file: MapFile,
    lights: str,
    outputs: Sequence[str],
    as_json: bool,
    **options: Any,
) -> None:
    """Fit MAP with several numbers of lights, and compare the errors."""
    for output in outputs:
        check_output(output, (".csv", ".json", *PICTURES), {"the map": map_file.path})
    arguments = curve_arguments(whole_numbers("--lights", lights), options)
    curve = error_curve(map_file.unread(arguments["fill"]), **arguments)
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
        curve.save(output)
