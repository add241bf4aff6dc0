"""`envlights view`: `envlights.view` on a file."""

from __future__ import annotations

from pathlib import Path

import click

from envlights._native import EnvLightsError
from envlights.cli.options.map_input import MapCommand, MapFile, map_argument, radiance_or_name
from envlights.cli.options.outputs import check_output, say_written
from envlights.rigs.rig import Rig
from envlights.viewer.model import Model
from envlights.viewer.page import SUFFIXES, view


@click.command("view", cls=MapCommand)
@map_argument
@click.option("--rig", metavar="RIG", help="Lights of the page: a rig that `envlights fit` wrote.")
@click.option(
    "-o",
    "--output",
    default="page.html",
    metavar="PAGE",
    help="File to write.",
    show_default=True,
)
@click.option("--title", metavar="TEXT", help="Text above the controls. Default: the file's name.")
@click.option(
    "--fill",
    metavar="CHOICE",
    help="Radiance where MAP shows nothing (alpha, a crop): black, harmonic, ground, a number, or"
    " R,G,B.",
)
@click.option("--model", metavar="FILE", help="Model: .glb, .gltf, .obj, .off, .ply or .stl.")
@click.option(
    "--scale", type=float, default=1.0, show_default=True, help="Metres per unit of the model."
)
@click.option(
    "--up", type=click.Choice(["y", "z"]), default="y", show_default=True, help="Its axis up."
)
@click.option(
    "--truth", is_flag=True, help="Add a path-traced picture of the start to compare (Mitsuba)."
)
def command(
    map_file: MapFile,
    rig: str | None,
    output: str,
    title: str | None,
    fill: str | None,
    model: str | None,
    scale: float,
    up: str,
    truth: bool,
) -> None:
    """Make a page that shows a ball and a box in MAP (.hdr, .exr, ...), lit by a few lights.

    MAP may be a rig (.json): it is shown in the map of its own lights.
    """
    check_output(output, SUFFIXES, {"the map": map_file.path})
    lights = None if rig is None else Rig.load(rig)
    shown = None if model is None else Model.open(model, scale=scale, up=up)
    is_rig = Path(map_file.path).suffix.lower() == ".json"
    title = title or Path(map_file.path).stem
    if is_rig and (map_file.reading or fill is not None):
        raise EnvLightsError(
            f"{map_file.path} is a rig; leave out --fill and the options on how a map is read"
        )
    if is_rig:
        page = view(Rig.load(map_file.path), lights, title=title, model=shown, truth=truth)
    else:
        filling = radiance_or_name(fill)
        page = view(
            map_file.open(filling), lights, title=title, fill=filling, model=shown, truth=truth
        )
    page.save(output)
    say_written([output])
