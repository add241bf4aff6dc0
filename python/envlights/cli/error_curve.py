"""`envlights error-curve`: `envlights.error_curve` on a file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import click

from envlights._common.files import PICTURES
from envlights.cli.options.fit_input import curve_arguments, curve_options
from envlights.cli.options.map_input import MapCommand, MapFile, map_argument
from envlights.cli.options.numbers import whole_numbers
from envlights.cli.options.outputs import (
    check_outputs,
    json_option,
    output_option,
    print_result,
    say_written,
    write,
)
from envlights.fitting.error_curve import error_curve


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
@json_option("curve")
def command(
    map_file: MapFile,
    lights: str,
    outputs: Sequence[str],
    as_json: bool,
    **options: Any,
) -> None:
    """Fit MAP with several numbers of lights, and compare the errors."""
    check_outputs(outputs, (".csv", ".json", *PICTURES), {"the map": map_file.path})
    arguments = curve_arguments(whole_numbers("--lights", lights), options)
    curve = error_curve(map_file.unread(arguments["fill"]), **arguments)
    write(
        outputs,
        curve.save,
        lambda plot: plot.error_curve(curve),
    )
    print_result(curve, as_json)
    say_written(outputs)
