"""`envlights split`: `envlights.split` on a file."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import click

from envlights._links import paths_of, plan
from envlights.cli.map_input import MapFile, map_argument
from envlights.cli.outputs import (
    check_output,
    check_source,
    output_option,
    say_written,
    verbose_option,
)
from envlights.detection.split import Split, split
from envlights.envmap import EnvMap
from envlights.export.targets import SUFFIXES
from envlights.io.files import PICTURES
from envlights.io.image_output import MAP_SUFFIXES


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
    "File to write: the map without the lights (.exr, .hdr), a scene of the lights with that map"
    " for the program of the suffix (list: envlights export -h), or a picture (.png, .pdf, .svg)."
    " Can be repeated; scenes name the .exr file."
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
        check_output(output, (*SUFFIXES, *MAP_SUFFIXES, *PICTURES), {"the map": map_file.path})
    env = map_file.open()
    parts = split(env, lights, share=share)
    written = _write(env, parts, map_file.path, outputs)
    removed = parts.lights
    text = removed.verbose() if verbose else str(removed)
    click.echo(json.dumps(removed.to_dict(), indent=2) if as_json else text)
    say_written(written)


def _write(env: EnvMap, parts: Split, source: str, outputs: Sequence[str]) -> list[str]:
    """Write all outputs; paths of all files, with the maps that scenes bring."""
    pictures = [output for output in outputs if Path(output).suffix.lower() in PICTURES]
    scenes = [output for output in outputs if output not in pictures]
    written = list(map(str, paths_of(plan(parts.rest, scenes))))
    for path in written:
        check_source(path, {"the map": source})
    if scenes:
        parts.save(*scenes)
    for output in pictures:
        from envlights import plot

        plot.save(plot.split_picture(env, parts), output)
    return [*written, *pictures]
