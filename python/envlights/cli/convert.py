"""`envlights convert`: a map in another layout, turned or resized."""

from __future__ import annotations

import math
from pathlib import Path

import click
import numpy as np

from envlights.cli.map_input import MapFile, map_argument
from envlights.cli.outputs import say_written
from envlights.envmap import EnvMap
from envlights.io.image_output import MAP_SUFFIXES
from envlights.layouts.picture import check_picture_path


@click.command("convert")
@map_argument
@click.argument("output", metavar="OUT")
@click.option(
    "--to",
    "layout",
    default="equirectangular",
    show_default=True,
    help="Layout of OUT: equirectangular, cube, octahedral, octahedral-equal-area, angular,"
    " mirror-ball, fisheye, cylinder or planar.",
)
@click.option("--width", type=int, help="Columns of OUT; of a cube, those of one face.")
@click.option("--rotate", type=float, metavar="DEGREES", help="Turn the map to the left about +y.")
@click.option(
    "--order",
    default="opengl",
    show_default=True,
    help="Order of the faces of a cube: opengl, openexr, py360convert, pannellum, directxtex.",
)
@click.option("--view", type=float, metavar="DEGREES", help="Field of view of a photograph, ...")
def command(
    map_file: MapFile,
    output: str,
    layout: str,
    width: int | None,
    rotate: float | None,
    order: str,
    view: float | None,
) -> None:
    """Write MAP in another layout to OUT (.exr, .hdr, .tif, .png; sky_{face}.exr for six files)."""
    check_picture_path(output)
    env = map_file.open()
    if rotate is not None:
        env = _rotate(env, math.radians(rotate))
    if layout == "equirectangular" and Path(output).suffix.lower() in MAP_SUFFIXES:
        (env if width is None else env.resized(width)).save(output)
        say_written([output])
        return
    written = env.to(layout, width=width, faces=order, fov=view).save(output)
    say_written([str(path) for path in written])


def _rotate(env: EnvMap, angle: float) -> EnvMap:
    """Map after a rotation about +y, from +z towards +x."""
    sine, cosine = math.sin(angle), math.cos(angle)
    return env.rotated(np.array([[cosine, 0, sine], [0, 1, 0], [-sine, 0, cosine]]))
