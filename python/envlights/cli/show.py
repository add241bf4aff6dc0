"""`envlights show`: one page on a map, with its lights, errors and notes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from envlights._common.files import write_atomically
from envlights.cli.options.fit_input import curve_arguments, curve_options
from envlights.cli.options.map_input import MapCommand, MapFile, map_argument
from envlights.cli.options.outputs import check_can_draw, check_output, say_written
from envlights.fitting.error_curve import error_curve
from envlights.fitting.request import LIGHTS

#: Rows of the error curve, unless more are requested.
_CURVE = 8


@click.command("show", cls=MapCommand)
@map_argument
@click.option("-n", "--lights", type=int, default=LIGHTS, show_default=True, help="Most lights.")
@curve_options
@click.option(
    "-o",
    "--output",
    default="report.html",
    show_default=True,
    metavar="PAGE",
    help="Page to write.",
)
@click.option("--title", metavar="TEXT", help="Title of the page. Default: the file's name.")
def command(
    map_file: MapFile,
    lights: int,
    output: str,
    title: str | None,
    **options: Any,
) -> None:
    """Write a page on MAP (.hdr, .exr, ...): pictures, lights, errors by number of lights, notes.

    The page is one file without scripts, which loads nothing from a network.
    """
    check_output(output, (".html",), {"the map": map_file.path})
    check_can_draw(output)
    if lights < 0:
        raise click.BadParameter(f"{lights} is less than 0.", param_hint="'-n'")
    arguments = curve_arguments(range(max(lights, _CURVE) + 1), options)
    env = map_file.open(arguments["fill"])
    curve = error_curve(env, **arguments)
    # Import late, because Matplotlib takes a second.
    from envlights.viewer.report_page import report_page

    name = title or Path(map_file.path).stem
    page = report_page(env.filled(arguments["fill"]), curve.rigs[lights], curve, name)
    write_atomically(output, lambda path: path.write_text(page, encoding="utf-8"))
    say_written([output])
