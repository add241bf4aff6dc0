"""`envlights place`: the light at a point of a room."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from envlights._native import EnvLightsError
from envlights.cli.map_input import MapCommand, MapFile, map_argument
from envlights.cli.numbers import numbers
from envlights.cli.outputs import (
    check_outputs,
    json_option,
    output_option,
    print_losses,
    print_result,
    say_written,
)
from envlights.environment.files.image_output import MAP_SUFFIXES
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
    "--point", metavar="X,Y,Z", help="Point for -o, in metres from the camera, in the axes of MAP."
)
@output_option("Map (.exr, .hdr) or rig (as of `fit`) at the point. Can be repeated.")
@json_option("lights")
def command(
    map_file: MapFile,
    depth: str | None,
    depth_reading: str | None,
    scale: float | None,
    room: str | None,
    camera_position: str | None,
    point: str | None,
    outputs: Sequence[str],
    as_json: bool,
) -> None:
    """Give the lights of MAP positions in a room, and write the light at a point."""
    inputs = {"the map": map_file.path} | ({"the depth": depth} if depth else {})
    check_outputs(outputs, (*SUFFIXES, *MAP_SUFFIXES), inputs)
    if bool(outputs) != (point is not None):
        raise EnvLightsError("-o writes the light at a --point; give both, or none of them")
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
    )
    if where is not None:
        _write(placed, where, outputs)
    print_result(placed, as_json)
    say_written(outputs)


def _write(placed: PlacedLights, point: list[float], outputs: Sequence[str]) -> None:
    """Write maps and rigs at a point."""
    for output in outputs:
        is_map = Path(output).suffix.lower() in MAP_SUFFIXES
        light = placed.map_at(point) if is_map else placed.at(point)
        for note in set(light.notes).difference(placed.notes):
            click.echo(f"note: {note}", err=True)
        with print_losses():
            light.save(output)
