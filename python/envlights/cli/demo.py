"""`envlights demo`: those of `envlights.demo`, which imports Matplotlib only when it runs."""

from __future__ import annotations

import json
from pathlib import Path

import click

from envlights.cli.outputs import print_rig, say_written


@click.command("demo")
@click.argument("what", type=click.Choice(["map", "transfer"]), default="map")
@click.option(
    "-o",
    "--output",
    "folder",
    default=".",
    metavar="FOLDER",
    help="Where the files go.",
    show_default=True,
)
@click.option("--json", "as_json", is_flag=True, help="Print the rig, or the report, as JSON.")
def command(what: str, folder: str, as_json: bool) -> None:
    """Make something to try, and draw the result.

    map: a hall with three bright windows, fitted. transfer: a room under many lamps, whose indirect
    light is learnt and predicted under lamps that the model has not seen.
    """
    from envlights.demo import demo, demo_transfer

    if what == "map":
        print_rig(demo(folder), as_json)
        names = [f"hall.{suffix}" for suffix in ("exr", "json", "png")]
    else:
        model = demo_transfer(folder, progress=True)
        click.echo(json.dumps(model.report.to_dict(), indent=2) if as_json else str(model))
        names = ["room", "room.npz", "room_direct.exr", "room_lightmap.exr"]
        names += ["room.png", "room_parts.png"]
    say_written([str(Path(folder) / name) for name in names])
