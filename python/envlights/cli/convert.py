"""`envlights convert`: a map in another layout, turned, resized or limited."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import click

from envlights.cli.map_input import MapCommand, MapFile, map_argument
from envlights.cli.numbers import numbers
from envlights.cli.outputs import default_of, say_written
from envlights.environment.envmap import EnvMap
from envlights.environment.files.image_output import COMPRESSIONS, MAP_SUFFIXES
from envlights.environment.layouts.picture import check_picture_path
from envlights.environment.layouts.projections import (
    PROJECTIONS,
    REGISTRATIONS,
    Layout,
    with_target_arguments,
)
from envlights.environment.pixels import PROJECTION


def layout_option(what: str) -> Callable[[Any], Any]:
    """Option ``--to``; its value is for `write_map`."""
    return click.option(
        "--to",
        "target",
        default=PROJECTION,
        show_default=True,
        help=f"Layout of {what}: {', '.join(PROJECTIONS)}, or source, which is that of MAP.",
    )


@click.command("convert", cls=MapCommand)
@map_argument
@click.argument("output", metavar="OUT")
@layout_option("OUT")
@click.option("--width", type=int, help="Columns of OUT; of a cube, those of one face.")
@click.option(
    "--order",
    default="opengl",
    show_default=True,
    help="Order of the faces of a cube: opengl, openexr, py360convert, pannellum, directxtex.",
)
@click.option("--view", type=float, metavar="DEGREES", help="Field of view of a photograph, ...")
@click.option(
    "--to-registration",
    type=click.Choice(REGISTRATIONS),
    help="Position of the pixels of OUT: in cells, or the outer ones on seam and poles.",
)
@click.option(
    "--to-mapping",
    metavar="NAME",
    help="Mapping of a fisheye: equidistant, equisolid, stereographic or orthographic.",
)
@click.option(
    "--to-forward",
    metavar="X,Y,Z",
    help="Direction of the centre of a photograph or a fisheye.",
)
@click.option("--half", is_flag=True, help="16 instead of 32 bits for each sample of an .exr.")
@click.option(
    "--compression",
    type=click.Choice(COMPRESSIONS),
    default=default_of(EnvMap.save, "compression"),
    help="Compression of an .exr, without loss.",
    show_default=True,
)
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
    target: str,
    width: int | None,
    order: str,
    view: float | None,
    to_registration: str | None,
    to_mapping: str | None,
    to_forward: str | None,
    half: bool,
    compression: str,
    limit: float | None,
) -> None:
    """Write MAP in another layout to OUT (.exr, .hdr, .tif, .png; sky_{face}.exr for six files)."""
    check_picture_path(output)
    saving = {"half": half, "compression": compression}
    layout = with_target_arguments(
        target,
        faces=order,
        registration=to_registration,
        mapping=to_mapping,
        fov=view,
        forward=None if to_forward is None else numbers("--to-forward", to_forward, "0,0,1"),
    )
    env = map_file.open()
    if limit is not None:
        env = env.limited(limit)
    say_written(write_map(env, output, layout, saving, width))


def write_map(
    env: EnvMap,
    output: str,
    layout: str | Layout,
    saving: Mapping[str, Any] = MappingProxyType({}),
    width: int | None = None,
) -> list[str]:
    """Write a map in a layout of `EnvMap.to`; return the names of the files.

    `saving` holds options of `EnvMap.save`.
    """
    if layout == PROJECTION and Path(output).suffix.lower() in MAP_SUFFIXES:
        (env if width is None else env.resized(width)).save(output, **saving)
        return [output]
    picture = env.to(layout, width=width)
    return [str(path) for path in picture.save(output, **saving)]
