"""`envlights relight`: `Split.with_lights` on a file."""

from __future__ import annotations

import math
from collections.abc import Sequence

import click
import numpy as np

from envlights._common.check import amount
from envlights._common.words import quantity
from envlights._native import EnvLightsError
from envlights.cli.convert import layout_option, write_map
from envlights.cli.map_input import MapCommand, MapFile, map_argument
from envlights.cli.numbers import numbers
from envlights.cli.outputs import check_output, say_written
from envlights.environment.files.image_output import MAP_SUFFIXES
from envlights.kernels.angles import direction_at
from envlights.rigs.lights import Lights
from envlights.splitting.split import split

_NUMBERED = "; light N is that of `envlights split MAP`. Can be repeated."


@click.command("relight", cls=MapCommand)
@map_argument
@click.option(
    "--move",
    "moves",
    multiple=True,
    metavar="N=AZ,EL",
    help="Move light N to an azimuth and elevation in degrees; nothing in place of one keeps it,"
    f" as in 1=,15{_NUMBERED}",
)
@click.option(
    "--gain", "gains", multiple=True, metavar="N=FACTOR", help=f"Dim or brighten light N{_NUMBERED}"
)
@click.option(
    "--tint",
    "tints",
    multiple=True,
    metavar="N=R,G,B",
    help=f"Colour light N, linear, at the same luminance{_NUMBERED}",
)
@click.option(
    "--remove", "removals", multiple=True, metavar="N", help=f"Leave out light N{_NUMBERED}"
)
@click.option(
    "--add",
    "additions",
    multiple=True,
    metavar="AZ,EL,IRRADIANCE",
    help="Add a white light at an azimuth and elevation in degrees. Can be repeated.",
)
@click.option(
    "--lights",
    "file",
    metavar="FILE",
    help="Lights to draw, which `envlights split MAP -o lights.json` wrote and you changed.",
)
@click.option("-o", "--output", required=True, help="File to write (.exr, .hdr).")
@layout_option("the new map")
def command(
    map_file: MapFile,
    moves: Sequence[str],
    gains: Sequence[str],
    tints: Sequence[str],
    removals: Sequence[str],
    additions: Sequence[str],
    file: str | None,
    output: str,
    target: str,
) -> None:
    """Move, dim, colour, remove or add lights of MAP (.hdr, .exr, .png, .jpg, .tif)."""
    check_output(output, tuple(MAP_SUFFIXES), {"the map": map_file.path})
    edits = [moves, gains, tints, removals, additions]
    if (file is not None) == any(edits):
        raise EnvLightsError("give --lights, or what to change: --move, --gain, --remove, ...")
    parts = split(map_file.open())
    if file is not None:
        lights = Lights.load(file)
    else:
        changes = _Changes(parts.lights)
        changes.apply(moves, gains, tints, removals, additions)
        lights = changes.lights
    env = parts.with_lights(lights)
    click.echo(str(lights))
    say_written(write_map(env, output, target))


class _Changes:
    """Lights by the numbers that the table of the split has."""

    def __init__(self, lights: Lights) -> None:
        self.lights = lights
        self._origin = lights.origin or ()

    def apply(
        self,
        moves: Sequence[str],
        gains: Sequence[str],
        tints: Sequence[str],
        removals: Sequence[str],
        additions: Sequence[str],
    ) -> None:
        """Make all changes; what is removed goes last, so that every number is known."""
        for text in moves:
            row, value = self._row("--move", text, "1=120,35")
            self.lights = self.lights.moved(row, **_angles(value))
        for text in gains:
            row, value = self._row("--gain", text, "1=0.5")
            self.lights = self.lights.dimmed(row, numbers("--gain", value, "0.5")[0])
        for text in tints:
            row, value = self._row("--tint", text, "1=1,0.8,0.6")
            self.lights = self.lights.coloured(row, numbers("--tint", value, "1,0.8,0.6"))
        for text in additions:
            azimuth, elevation, level = numbers("--add", text, "120,35,10")
            towards = direction_at(*np.deg2rad([azimuth, elevation]))
            self.lights = self.lights.with_light(towards, [level] * 3)
        for text in removals:
            row, _ = self._row("--remove", f"{text}=", "1")
            self.lights = self.lights.without(row)

    def _row(self, option: str, text: str, example: str) -> tuple[int, str]:
        """Row of a numbered light now, and the text of its new value."""
        number, equals, value = text.partition("=")
        if not number.strip().isdecimal() or not equals:
            raise EnvLightsError(f"{option} must be such as {example}; got {text.rstrip('=')}")
        index = int(number) - 1
        if not 0 <= index < len(self._origin):
            found = quantity(len(self._origin), "light")
            raise EnvLightsError(f"{option} names light {int(number)}; the map has {found}")
        origin = self.lights.origin or ()
        if self._origin[index] not in origin:
            raise EnvLightsError(f"{option} names light {int(number)} twice")
        return origin.index(self._origin[index]), value


def _angles(text: str) -> dict[str, float]:
    """Azimuth and elevation in radians, those that are given."""
    parts = text.split(",")
    if len(parts) != 2 or not any(part.strip() for part in parts):
        raise EnvLightsError(f"--move must be such as 1=120,35 or 1=,35; got {text}")
    limits = zip(("azimuth", "elevation"), parts, (math.inf, 90.0), strict=True)
    return {
        name: math.radians(
            amount(f"--move: {name} in degrees", numbers("--move", part, "120")[0], -most, most)
        )
        for name, part, most in limits
        if part.strip()
    }
