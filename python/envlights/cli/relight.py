"""`envlights relight`: `Split.with_lights` on a file."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import click
import numpy as np

from envlights._common.check import amount
from envlights._common.words import quantity
from envlights._native import EnvLightsError
from envlights.cli.convert import layout_option, write_map
from envlights.cli.options.map_input import MapCommand, MapFile, map_argument
from envlights.cli.options.numbers import numbers
from envlights.cli.options.outputs import check_output, say_written
from envlights.detection.lights_file import load_lights
from envlights.environment.files.image_output import MAP_SUFFIXES
from envlights.kernels.angles import direction_at
from envlights.rigs.lights import Lights
from envlights.rigs.rig import Rig
from envlights.splitting.split import split

#: Options that change a light by number: an example, and the function that applies the change.
_CHANGES: dict[str, tuple[str, Callable[[Lights, int, str], Lights]]] = {
    "move": ("1=120,35", lambda lights, row, text: lights.moved(row, **_angles(text))),
    "turn": (
        "1=0,-20",
        lambda lights, row, text: _turn(lights, row, numbers("--turn", text, "0,-20")),
    ),
    "gain": (
        "1=0.5",
        lambda lights, row, text: lights.dimmed(row, *numbers("--gain", text, "0.5")),
    ),
    "tint": (
        "1=1,0.8,0.6",
        lambda lights, row, text: lights.coloured(row, **_colour(text)),
    ),
    "radius": (
        "1=0.27",
        lambda lights, row, text: lights.resized(row, _radius(*numbers("--radius", text, "0.27"))),
    ),
    "remove": ("1", lambda lights, row, _: lights.without(row)),
}
#: Names of all edits.
EDITS = (*_CHANGES, "add")


def _by_number(name: str, metavar: str, help_text: str) -> Callable[[Any], Any]:
    """Option that changes a light by its number."""
    text = f"{help_text}; light N is that of `envlights split MAP`. Can be repeated."
    return click.option(f"--{name}", multiple=True, metavar=metavar, help=text)


@click.command("relight", cls=MapCommand)
@map_argument
@_by_number(
    "move",
    "N=AZ,EL",
    "Move light N to an azimuth and elevation in degrees; leave one out to keep it, as in 1=,15",
)
@_by_number("turn", "N=AZ,EL", "Move light N by degrees of azimuth and elevation, as in 1=0,-20")
@_by_number("gain", "N=FACTOR", "Dim or brighten light N")
@_by_number("tint", "N=COLOUR", "Colour light N, as in 1=1,0.8,0.6 (linear) or 1=2500K")
@_by_number("radius", "N=DEGREES", "Draw light N as a disc of this radius")
@_by_number("remove", "N", "Leave out light N")
@click.option(
    "--add",
    multiple=True,
    metavar="AZ,EL,IRRADIANCE",
    help="Add a white light at an azimuth and elevation in degrees. Can be repeated.",
)
@click.option(
    "--lights",
    "file",
    metavar="FILE",
    help="Lights to draw: of `envlights split MAP -o lights.json`, changed by you, or of a rig, as"
    " a page of `envlights view` saves it.",
)
@click.option("-o", "--output", required=True, help="File to write (.exr, .hdr).")
@layout_option("the new map")
def command(
    map_file: MapFile, file: str | None, output: str, target: str, **edits: Sequence[str]
) -> None:
    """Move, dim, colour, resize, remove or add lights of MAP (.hdr, .exr, .png, .jpg, .tif)."""
    check_output(output, tuple(MAP_SUFFIXES), {"the map": map_file.path})
    if (file is not None) == any(edits.values()):
        raise EnvLightsError("give --lights, or what to change: --move, --gain, --remove, ...")
    given = None if file is None else _lights_of(file)
    parts = split(map_file.open())
    lights = apply_edits(parts.lights, edits) if given is None else given
    _say_below(parts.lights, lights)
    env = parts.with_lights(lights)
    click.echo(str(lights))
    say_written(write_map(env, output, target))


def _lights_of(file: str) -> Lights:
    """Lights of a file, or those of a rig."""
    given = load_lights(file)
    return given.lights if isinstance(given, Rig) else given


def apply_edits(removed: Lights, edits: Mapping[str, Sequence[str]]) -> Lights:
    """Lights after all edits; numbers refer to the table of the split."""
    lights = removed
    for option, (example, change) in _CHANGES.items():
        for text in edits[option]:
            number, value = _number_and_text(f"--{option}", text, example)
            lights = change(lights, _row(f"--{option}", number, removed, lights), value)
    for text in edits["add"]:
        azimuth, elevation, level = numbers("--add", text, "120,35,10")
        amount("--add: the elevation in degrees", elevation, -90.0, 90.0)
        towards = direction_at(*np.deg2rad([azimuth, elevation]))
        lights = lights.with_light(towards, [level] * 3)
    return lights


def _number_and_text(option: str, text: str, example: str) -> tuple[int, str]:
    """Number of a light, and the text after the number."""
    number, equals, value = text.partition("=")
    if not number.strip().isdecimal() or bool(equals) != ("=" in example):
        raise EnvLightsError(f"{option} must be such as {example}; got {text}")
    return int(number), value


def _row(option: str, number: int, removed: Lights, lights: Lights) -> int:
    """Index in the changed lights of a removed light."""
    if not 1 <= number <= len(removed):
        found = quantity(len(removed), "light")
        raise EnvLightsError(f"{option} names light {number}; the map has {found}")
    known, now = removed.origin or (), lights.origin or ()
    if known[number - 1] not in now:
        raise EnvLightsError(f"{option} names light {number} twice")
    return now.index(known[number - 1])


def _turn(lights: Lights, row: int, degrees: Sequence[float]) -> Lights:
    """Lights with one of them moved by degrees of azimuth and elevation."""
    before = np.rad2deg([lights.azimuth[row], lights.elevation[row]])
    azimuth, elevation = before + [amount("--turn: degrees", each, -math.inf) for each in degrees]
    amount("--turn: the new elevation in degrees", elevation.item(), -90.0, 90.0)
    return lights.moved(row, azimuth=math.radians(azimuth), elevation=math.radians(elevation))


def _radius(degrees: float) -> float:
    return math.radians(amount("--radius in degrees", degrees, 0.0, 90.0))


def _colour(text: str) -> dict[str, Any]:
    """Colour as RGB, or as a temperature that ends with K."""
    if text.strip().upper().endswith("K"):
        return {"kelvin": numbers("--tint", text.strip()[:-1], "2500")[0]}
    return {"rgb": numbers("--tint", text, "1,0.8,0.6")}


def _say_below(before: Lights, after: Lights) -> None:
    """Print a note on lights that were moved below the horizon."""
    known = dict(zip(before.origin or (), before.elevation, strict=False))
    for origin, elevation in zip(after.origin or (), after.elevation, strict=False):
        if origin in known and elevation < 0 <= known[origin]:
            click.echo(
                f"note: a light was moved below the horizon, from {np.rad2deg(known[origin]):.1f}"
                f" to {np.rad2deg(elevation):.1f} degrees; --turn moves by degrees",
                err=True,
            )


def _angles(text: str) -> dict[str, float]:
    """Given angles of azimuth and elevation in radians, by name."""
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
