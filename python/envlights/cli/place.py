"""`envlights place`: the lights of a room where they hang, or the light at a point."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from envlights._native import EnvLightsError
from envlights.cli.options.map_input import (
    MapCommand,
    MapFile,
    map_argument,
    radiance_or_name,
    unseen_option,
)
from envlights.cli.options.numbers import numbers
from envlights.cli.options.outputs import (
    check_outputs,
    check_source,
    json_option,
    output_option,
    print_losses,
    print_result,
    say_written,
    stage_of,
    stage_options,
)
from envlights.environment.files.image_output import MAP_SUFFIXES
from envlights.export.links import paths_of, plan
from envlights.export.targets import SUFFIXES
from envlights.placing.place import place
from envlights.placing.placed_lights import PlacedLights
from envlights.placing.planes import READINGS

_POINT = "1,0.2,-0.5"


@click.command("place", cls=MapCommand)
@map_argument
@click.option("--depth", metavar="FILE", help="Depth of MAP in metres (.exr, .png, .npy).")
@click.option(
    "--depth-reading",
    type=click.Choice(list(READINGS)),
    help="Meaning of the depth; measured by default.",
)
@click.option("--scale", type=float, help="Metres of a depth of 1, such as 0.001.")
@click.option("--room", metavar="W,H,D", help="Size of the room in metres, instead of a depth.")
@click.option(
    "--camera-position", metavar="X,Y,Z", help="Camera in the room; the middle by default."
)
@click.option(
    "--point",
    metavar="X,Y,Z",
    help="Point for -o, in metres from the camera, in the axes of MAP. Default: lights with"
    " positions.",
)
@click.option(
    "--remainder-at",
    metavar="X,Y,Z",
    help="Point whose map lies around lights with positions. Default: the camera.",
)
@unseen_option()
@output_option(
    "Lights with positions in metres (.usda, .py, .xml, .pbrt, .gltf, .three.json), or their"
    " remainder (.exr). With --point, the map or a rig (as of `fit`) there. Can be repeated."
)
@stage_options
@json_option("lights")
def command(
    map_file: MapFile,
    depth: str | None,
    depth_reading: str | None,
    scale: float | None,
    room: str | None,
    camera_position: str | None,
    point: str | None,
    remainder_at: str | None,
    fill: str | None,
    outputs: Sequence[str],
    stage: dict[str, Any],
    as_json: bool,
) -> None:
    """Give the lights of MAP positions in a room, and write them, or the light at a point."""
    inputs = {"the map": map_file.path} | ({"the depth": depth} if depth else {})
    check_outputs(outputs, (*SUFFIXES, *MAP_SUFFIXES), inputs, stage)
    if point and not outputs:
        raise EnvLightsError("--point is a point for files; give -o as well")
    if remainder_at and (point or not outputs):
        raise EnvLightsError(
            "--remainder-at is a point for lights with positions; give -o, and no --point"
        )
    stage |= {} if remainder_at is None else {"at": numbers("--remainder-at", remainder_at, _POINT)}
    where = None if point is None else numbers("--point", point, _POINT)
    placed = place(
        map_file.open(),
        depth,
        reading=depth_reading,
        scale=scale,
        room=None if room is None else numbers("--room", room, "6,3,5"),
        camera=None
        if camera_position is None
        else numbers("--camera-position", camera_position, "3,1.6,2.5"),
        fill=radiance_or_name(fill),
    )
    written = outputs
    if where is not None:
        _write(placed, where, outputs, stage)
    elif outputs:
        for path in paths_of(plan(placed.remainder, outputs, placed.cards)):
            check_source(str(path), inputs)
        with print_losses():
            written = list(map(str, placed.save(*outputs, **stage)))
    print_result(placed, as_json)
    say_written(written)


def _write(
    placed: PlacedLights, point: list[float], outputs: Sequence[str], stage: dict[str, Any]
) -> None:
    """Write maps and rigs at a point."""
    for output in outputs:
        is_map = Path(output).suffix.lower() in MAP_SUFFIXES
        light = placed.map_at(point) if is_map else placed.at(point)
        known = (*placed.notes, *placed.remainder.notes)
        for note in (each for each in light.notes if each not in known):
            click.echo(f"note: {note}", err=True)
        with print_losses():
            light.save(output, **stage_of(output, stage))
