"""`envlights repair`: `EnvMap.repaired` on a file."""

from __future__ import annotations

from typing import Any

import click

from envlights.cli.options.map_input import (
    MapCommand,
    MapFile,
    map_argument,
    radiance_or_name,
    unseen_option,
)
from envlights.cli.options.outputs import check_output, say_written
from envlights.cli.options.sun_input import reading_options, sun_options
from envlights.environment.envmap import EnvMap
from envlights.environment.files.image_output import MAP_SUFFIXES
from envlights.sun.choice import AnySun, is_of_map, sun_of
from envlights.sun.sun_split import with_sun
from envlights.sun.wording import HOLDS_SUN


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
    check_output(output, MAP_SUFFIXES, {"the map": map_file.path})
    choice = radiance_or_name(fill)
    readings: dict[str, Any] = {"irradiance": irradiance, "ratio": ratio, "fill": choice}
    env = map_file.open(choice)
    env = env.repaired(**readings) if sun is None else repair_with_sun(env, sun, **readings)
    env.save(output)
    click.echo(str(env))
    say_written([output])


def repair_with_sun(env: EnvMap, sun: AnySun, **readings: Any) -> EnvMap:
    """Map with the sky and disc of a sun; without a sun, the map repaired without it."""
    found = sun_of(env, sun)
    if is_of_map(found):
        return env.with_radiance(env.radiance, (*env.notes, HOLDS_SUN)).repaired(**readings)
    parts = with_sun(env, found, **readings)
    return parts.to_map() if len(parts.lights) else parts.remainder.repaired(**readings)
