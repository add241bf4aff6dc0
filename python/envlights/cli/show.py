"""`envlights show`: one page on a map, with its lights, errors and notes."""

from __future__ import annotations

from pathlib import Path

import click

from envlights.cli.map_input import MapFile, map_argument, radiance_or_name, unseen_option
from envlights.cli.outputs import check_output, default_of, say_written
from envlights.fitting.ambient_terms import AMBIENTS, AUTO
from envlights.fitting.error_curve import error_curve
from envlights.fitting.request import LIGHTS
from envlights.io.files import write_atomically

#: Rows of the error curve, unless more lights are requested.
_CURVE = 8


@click.command("show")
@map_argument
@click.option("-n", "--lights", type=int, default=LIGHTS, show_default=True, help="Most lights.")
@click.option(
    "--sizes/--points",
    default=default_of(error_curve, "sizes"),
    show_default=True,
    help="Lights with a size, for soft shadows, or points.",
)
@click.option("--ambient", type=click.Choice([*AMBIENTS, AUTO]), help="Light from all directions.")
@click.option("--floor", is_flag=True, help="The scene has a floor, which hides light from below.")
@unseen_option()
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
    sizes: bool,
    ambient: str | None,
    floor: bool,
    unseen: str | None,
    output: str,
    title: str | None,
) -> None:
    """Write a page on MAP (.hdr, .exr, ...): pictures, lights, errors by number of lights, notes.

    The page is one file without scripts, which loads nothing from a network.
    """
    check_output(output, (".html",), {"the map": map_file.path})
    if lights < 0:
        raise click.BadParameter(f"{lights} is less than 0.", param_hint="'-n'")
    env, choice = map_file.open(), radiance_or_name(unseen)
    numbers = range(max(lights, _CURVE) + 1)
    curve = error_curve(env, numbers, sizes=sizes, ambient=ambient, floor=floor, unseen=choice)
    # Importing Matplotlib takes a second.
    from envlights.viewer.report_page import report_page

    name = title or Path(map_file.path).stem
    page = report_page(env.filled(choice), curve.rigs[lights], curve, name)
    write_atomically(output, lambda path: path.write_text(page, encoding="utf-8"))
    say_written([output])
