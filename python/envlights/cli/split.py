"""`envlights split`: `envlights.split` on a file."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import click

from envlights.cli.map_input import MapFile, map_argument
from envlights.cli.outputs import (
    check_output,
    output_option,
    save_lights,
    say_written,
    verbose_option,
)
from envlights.detection.split import Split, split
from envlights.envmap import EnvMap
from envlights.export.targets import SUFFIXES
from envlights.io.files import PICTURES

#: Formats of the map without the lights.
MAPS = (".exr", ".hdr")


@click.command("split")
@map_argument
@click.option(
    "-n",
    "--lights",
    type=int,
    help="Largest number of lights to remove, brightest first, such as 1 for the sun.",
)
@click.option(
    "--share",
    type=float,
    help="Remove the fewest lights that together give this fraction of the flux of all lights, such"
    " as 0.9.",
)
@output_option(
    "File to write: the map without the lights (.exr, .hdr), the lights for the program of the"
    " suffix (list: envlights export -h) or a picture (.png, .pdf, .svg). Can be repeated."
)
@verbose_option()
@click.option("--json", "as_json", is_flag=True, help="Print the lights as JSON.")
def command(
    map_file: MapFile,
    lights: int | None,
    share: float | None,
    outputs: Sequence[str],
    verbose: bool,
    as_json: bool,
) -> None:
    """Remove the lights from MAP (.hdr, .exr, .png, .jpg, .tif)."""
    for output in outputs:
        check_output(output, (*SUFFIXES, *MAPS, *PICTURES), {"the map": map_file.path})
    env = map_file.open()
    parts = split(env, lights, share=share)
    for output in outputs:
        _write(env, parts, output)
    removed = parts.lights
    text = removed.verbose() if verbose else str(removed)
    click.echo(json.dumps(removed.to_dict(), indent=2) if as_json else text)
    say_written(outputs)


def _write(env: EnvMap, parts: Split, output: str) -> None:
    suffix = Path(output).suffix.lower()
    if suffix in MAPS:
        parts.rest.save(output)
    elif suffix not in PICTURES:
        save_lights(parts.lights, output, strict=False)
    else:
        from envlights import plot

        plot.save(plot.split_picture(env, parts), output)
