"""`envlights convert`: a map in another layout, turned, resized or limited."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
import numpy as np

from envlights._map_pixels import PROJECTION
from envlights.cli.map_input import MapFile, map_argument
from envlights.cli.outputs import say_written
from envlights.envmap import EnvMap
from envlights.io.image_output import MAP_SUFFIXES
from envlights.layouts.picture import check_picture_path


def layout_option(what: str) -> Callable[[Any], Any]:
    """Option ``--to``; its value is for `write_map`."""
    return click.option(
        "--to",
        "layout",
        default=PROJECTION,
        show_default=True,
        help=f"Layout of {what}: equirectangular, cube, octahedral, octahedral-equal-area, angular,"
        " mirror-ball, fisheye, cylinder, planar, or source, which is that of MAP.",
    )


@click.command("convert")
@map_argument
@click.argument("output", metavar="OUT")
@layout_option("OUT")
@click.option("--width", type=int, help="Columns of OUT; of a cube, those of one face.")
@click.option("--rotate", type=float, metavar="DEGREES", help="Turn the map to the left about +y.")
@click.option(
    "--order",
    default="opengl",
    show_default=True,
    help="Order of the faces of a cube: opengl, openexr, py360convert, pannellum, directxtex.",
)
@click.option("--view", type=float, metavar="DEGREES", help="Field of view of a photograph, ...")
@click.option(
    "--limit",
    type=float,
    metavar="MAXIMUM",
    help="Spread radiance above this value over the pixels around it, such as 65504 for half"
    " floats.",
)
def command(
    map_file: MapFile,
    output: str,
    layout: str,
    width: int | None,
    rotate: float | None,
    order: str,
    view: float | None,
    limit: float | None,
) -> None:
    """Write MAP in another layout to OUT (.exr, .hdr, .tif, .png; sky_{face}.exr for six files)."""
    check_picture_path(output)
    env = map_file.open()
    if rotate is not None:
        env = _rotate(env, math.radians(rotate))
    if limit is not None:
        env = env.limited(limit)
    say_written(write_map(env, output, layout, width=width, faces=order, fov=view))


def write_map(
    env: EnvMap, output: str, layout: str, *, width: int | None = None, **options: Any
) -> list[str]:
    """Write a map in a layout of `EnvMap.to`; return the names of the files."""
    if layout == PROJECTION and Path(output).suffix.lower() in MAP_SUFFIXES:
        (env if width is None else env.resized(width)).save(output)
        return [output]
    return [str(path) for path in env.to(layout, width=width, **options).save(output)]


def _rotate(env: EnvMap, angle: float) -> EnvMap:
    """Map after a rotation about +y, from +z towards +x."""
    sine, cosine = math.sin(angle), math.cos(angle)
    return env.rotated(np.array([[cosine, 0, sine], [0, 1, 0], [-sine, 0, cosine]]))
