"""`envlights show`: one page on a map, with its lights, errors and notes."""

from __future__ import annotations

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
from envlights.cli.outputs import check_can_draw, check_output, say_written
from envlights.fitting.ambient_terms import AMBIENTS, AUTO
from envlights.fitting.error_curve import error_curve
from envlights.fitting.request import LIGHTS
from envlights.io.files import write_atomically
from envlights.many.work import check_options

#: Rows of the error curve, unless more lights are requested.
_CURVE = 8


@click.command("show", cls=MapCommand)
@map_argument
@click.option("-n", "--lights", type=int, default=LIGHTS, show_default=True, help="Most lights.")
@shape_options
@roughness_option("the metal of the gloss error")
@click.option("--ambient", type=click.Choice([*AMBIENTS, AUTO]), help="Light from all directions.")
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
    max_radius: float | None,
    objective: str,
    ambient: str | None,
    floor: bool,
    roughness: float,
    unseen: str | None,
    output: str,
    title: str | None,
) -> None:
    """Write a page on MAP (.hdr, .exr, ...): pictures, lights, errors by number of lights, notes.

    The page is one file without scripts, which loads nothing from a network.
    """
    check_output(output, (".html",), {"the map": map_file.path})
    check_can_draw(output)
    if lights < 0:
        raise click.BadParameter(f"{lights} is less than 0.", param_hint="'-n'")
    choice = radiance_or_name(unseen)
    options: dict[str, Any] = {
        "roughness": roughness,
        "sizes": sizes,
        "max_radius": radius_of(max_radius),
        "objective": objective,
        "ambient": ambient,
        "floor": floor,
        "unseen": choice,
    }
    check_options("error_curve", {"lights": [0], **options})
    env = map_file.open(choice)
    curve = error_curve(env, range(max(lights, _CURVE) + 1), **options)
    # Importing Matplotlib takes a second.
    from envlights.viewer.report_page import report_page

    name = title or Path(map_file.path).stem
    page = report_page(env.filled(choice), curve.rigs[lights], curve, name)
    write_atomically(output, lambda path: path.write_text(page, encoding="utf-8"))
    say_written([output])
