"""`envlights demo`: the functions of `cli.demonstration`; Matplotlib is imported when it runs."""

from __future__ import annotations

import json
from pathlib import Path

import click

from envlights._common.files import NO_MATPLOTLIB, PICTURES, can_draw
from envlights.cli.options.outputs import print_result, say_written, verbose_option


@click.command("demo")
@click.argument("what", type=click.Choice(["map", "transfer"]), default="map")
@click.option(
    "-o",
    "--output",
    "folder",
    default=".",
    metavar="FOLDER",
    help="Folder to write the files to.",
    show_default=True,
)
@verbose_option()
@click.option("--json", "as_json", is_flag=True, help="Print the rig, or the report, as JSON.")
def command(what: str, folder: str, verbose: bool, as_json: bool) -> None:
    """Make example files, and draw the result.

    map: fit lights to a hall with three bright windows. transfer: learn the indirect light in a
    room from 64 lamps, and predict it for a new lamp.
    """
    from envlights.cli.demonstration import demo, demo_transfer

    if what == "map":
        print_result(demo(folder), as_json, verbose)
        names = [f"hall.{suffix}" for suffix in ("exr", "json", "png")]
    else:
        model = demo_transfer(folder, progress=True)
        text = model.report.verbose() if verbose else str(model)
        click.echo(json.dumps(model.report.to_dict(), indent=2) if as_json else text)
        names = ["room", "room.npz", "room_direct.exr", "room_lightmap.exr"]
        names += ["room.png", "room_parts.png"]
    if not can_draw():
        click.echo(f"no picture: it {NO_MATPLOTLIB}", err=True)
        names = [name for name in names if Path(name).suffix not in PICTURES]
    say_written([str(Path(folder) / name) for name in names])
