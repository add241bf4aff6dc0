"""`envlights repair`: `EnvMap.repaired` on a file."""

from __future__ import annotations

import click

from envlights.cli.map_input import (
    MapCommand,
    MapFile,
    map_argument,
    radiance_or_name,
    unseen_option,
)
from envlights.cli.outputs import check_output, say_written
from envlights.cli.sun_input import reading_options, sun_options
from envlights.sun.choice import AnySun

#: Formats that can hold radiance above the clip level.
MAPS = (".exr", ".hdr")


@click.command("repair", cls=MapCommand)
@map_argument
@click.option("-o", "--output", required=True, help="File to write (.exr, .hdr).")
@reading_options
@sun_options
@unseen_option()
def command(
    map_file: MapFile,
    output: str,
    irradiance: float | None,
    ratio: float | None,
    fill: str | None,
    sun: AnySun | None,
) -> None:
    """Estimate the clipped light of MAP, such as a JPEG or PNG."""
    check_output(output, MAPS, {"the map": map_file.path})
    choice = radiance_or_name(fill)
    env = map_file.open(choice).repaired(sun=sun, irradiance=irradiance, ratio=ratio, fill=choice)
    env.save(output)
    click.echo(str(env))
    say_written([output])
