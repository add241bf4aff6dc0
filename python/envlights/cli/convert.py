"""`envlights convert`: a map in another layout, turned, resized or limited."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

import click

from envlights._common.errors import FileError
from envlights._native import EnvLightsError
from envlights.cli.options.map_input import MapCommand, MapFile, direction_in, map_argument
from envlights.cli.options.outputs import check_source, default_of, say_written
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
    """Option ``--to``; pass its value to `write_map`."""
    return click.option(
        "--to",
        "target",
        default=PROJECTION,
        show_default=True,
        help=f"Layout of {what}: {', '.join(PROJECTIONS)}, or source, which is that of MAP.",
    )


@click.command("convert", cls=MapCommand)
@map_argument
@click.argument("names", metavar="[MAP...]", nargs=-1)
@click.option(
    "-o",
    "--output",
    metavar="OUT",
    help="File to write, or for several maps a folder. Without -o, the second name is OUT.",
)
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
    names: Sequence[str],
    output: str | None,
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
    """Write each MAP in another layout to OUT.

    OUT is a file (.exr, .hdr, .tif, .png; sky_{face}.exr for six files), or a folder.
    """
    if output is None:
        if len(names) != 1:
            raise EnvLightsError("give -o: a file for one map, or a folder for several")
        (output,), names = names, ()
    paths = [map_file.path, *names]
    outputs = [output] if Path(output).suffix else _in_folder(output, paths)
    if len(outputs) != len(paths):
        raise EnvLightsError(f"{len(paths)} maps need a folder; got -o {output}, which is a file")
    for path, each in zip(paths, outputs, strict=True):
        check_picture_path(each)
        check_source(each, {"the map": path})
    saving = {"half": half, "compression": compression}
    layout = with_target_arguments(
        target,
        faces=order,
        registration=to_registration,
        mapping=to_mapping,
        fov=view,
        forward=to_forward and direction_in(map_file.frame, "--to-forward", to_forward),
    )
    for path, each in zip(paths, outputs, strict=True):
        env = map_file._replace(path=path).open()
        if limit is not None:
            env = env.limited(limit)
        say_written(write_map(env, each, layout, saving, width))


def _in_folder(folder: str, paths: Sequence[str]) -> list[str]:
    """Output paths in a folder, named after the maps; .exr for unsupported suffixes."""
    given = (Path(folder, Path(path).name) for path in paths)
    files = [
        str(file if file.suffix.lower() in MAP_SUFFIXES else file.with_suffix(".exr"))
        for file in given
    ]
    if len(set(files)) < len(files):
        raise EnvLightsError("two maps have the same name; give one of them another folder")
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(f"cannot make the folder {folder}: {error.strerror}") from None
    return files


def write_map(
    env: EnvMap,
    output: str,
    layout: str | Layout,
    saving: Mapping[str, Any] = MappingProxyType({}),
    width: int | None = None,
) -> list[str]:
    """Write a map in a layout of `EnvMap.to`; return the file names.

    `saving` holds options of `EnvMap.save`.
    """
    if layout == PROJECTION and Path(output).suffix.lower() in MAP_SUFFIXES:
        (env if width is None else env.resized(width)).save(output, **saving)
        return [output]
    picture = env.to(layout, width=width)
    return [str(path) for path in picture.save(output, **saving)]
