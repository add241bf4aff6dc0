"""`envlights demo`: `envlights.demo.demo`, which imports Matplotlib only when it runs."""

from __future__ import annotations

from pathlib import Path

import click

from envlights.cli.outputs import print_rig, say_written


@click.command("demo")
@click.option(
    "-o",
    "--output",
    "folder",
    default=".",
    metavar="FOLDER",
    help="Where the files go.",
    show_default=True,
)
@click.option("--json", "as_json", is_flag=True, help="Print the rig as JSON.")
def command(folder: str, as_json: bool) -> None:
    """Make a hall with three bright windows, fit it, and draw the result."""
    from envlights.demo import demo

    print_rig(demo(folder), as_json)
    say_written([str(Path(folder) / f"hall.{suffix}") for suffix in ("exr", "json", "png")])
