"""Argument MAP of a subcommand, with the options for reading its file."""

from __future__ import annotations

import contextlib
import functools
import math
from collections.abc import Callable
from types import MappingProxyType
from typing import Any, NamedTuple

import click

from envlights._native import EnvLightsError
from envlights.cli.options.numbers import numbers
from envlights.environment.envmap import EnvMap
from envlights.environment.layouts.projections import (
    ARGUMENTS,
    EYES,
    PROJECTIONS,
    REGISTRATIONS,
    Layout,
)
from envlights.environment.reading import Reading, as_envmap
from envlights.frames import FRAMES, frame_named, rotation

#: Heading of the reading options in the help.
_HEADING = "Options on how MAP is read"
_DIRECTION = "0.5,0.7,0.5"


class MapFile(NamedTuple):
    """File of a map, with the options for reading it."""

    path: str
    """Path; "-" is standard input."""

    reading: Reading = MappingProxyType({})
    """Reading options from the command line."""

    frame: str | None = None
    """Frame for input and output of directions."""

    def open(self, fill: Any = None) -> EnvMap:
        """Map of the file, read with the options."""
        return as_envmap(self.path, {**self.reading, "fill": fill})

    def unread(self, fill: Any = None) -> str | EnvMap:
        """Path, if the file can be read by rows; the map itself if reading options are given."""
        return self.open(fill) if self.reading else self.path


class MapOption(click.Option):
    """Option on the content or reading of MAP, listed by ``--help-map``."""


class MapCommand(click.Command):
    """Subcommand with MAP: ``--help-map`` lists the options on MAP, ``--help`` all others."""

    def format_options(
        self, context: click.Context, formatter: click.HelpFormatter, of_map: bool = False
    ) -> None:
        """Write the options on MAP, or all others."""
        records = [
            parameter.get_help_record(context)
            for parameter in self.get_params(context)
            if isinstance(parameter, click.Option) and isinstance(parameter, MapOption) is of_map
        ]
        with formatter.section(_HEADING if of_map else "Options"):
            formatter.write_dl([record for record in records if record is not None])


def _print_map_options(context: click.Context, _: click.Parameter, value: bool) -> None:
    """Print the help of the options on MAP."""
    if value and isinstance(context.command, MapCommand):
        formatter = context.make_formatter()
        context.command.format_options(context, formatter, of_map=True)
        click.echo(formatter.getvalue().rstrip())
        context.exit()


def reading_options(function: Callable[..., None]) -> Callable[..., None]:
    """Decorator that adds the options for reading maps, as the argument `reading`."""

    @functools.wraps(function)
    def command(*context: click.Context, **options: Any) -> None:
        given = {name: options.pop(name) for name in _OPTIONS}
        given = {name: value for name, value in given.items() if value not in (None, False)}
        frame = given.get("frame") if "camera" in given else given.pop("frame", None)
        function(*context, reading=_reading(given, frame), **options)

    wrapped: Any = command
    for name, settings in reversed(_OPTIONS.items()):
        flag = f"--{name.replace('_', '-')}"
        wrapped = click.option(flag, name, cls=MapOption, **settings)(wrapped)
    return click.option(  # type: ignore[no-any-return]
        "--help-map",
        is_flag=True,
        is_eager=True,
        expose_value=False,
        callback=_print_map_options,
        help="Options on how MAP is read: colour, layout, lux, ...",
    )(wrapped)


def map_argument(function: Callable[..., None]) -> Callable[..., None]:
    """Decorator that adds MAP and its options, as a first argument of type `MapFile`."""

    @functools.wraps(function)
    def command(map_path: str, reading: Reading, **options: Any) -> None:
        frame = click.get_current_context().params["frame"]
        function(MapFile(map_path, reading, frame), **options)

    return click.argument("map_path", metavar="MAP")(reading_options(command))


def direction_in(frame: str | None, option: str, text: str) -> list[float]:
    """Direction converted from the user's frame to that of `EnvMap`."""
    typed = numbers(option, text, _DIRECTION)
    ours: list[float] = frame_named(frame or "envlights").from_target(typed).tolist()
    return ours


def _reading(given: dict[str, Any], frame: str | None) -> dict[str, Any]:
    """Option values converted to Python arguments."""
    for name in ("forward", "normal", "at", "level"):
        if name in given:
            given[name] = direction_in(frame, f"--{name}", given[name])
    if "circle" in given:
        given["circle"] = numbers("--circle", given["circle"], "512,512,500")
    if "channels" in given:
        given["channels"] = given["channels"].split(",")
    if "camera" in given:
        given["camera"] = _camera(given["camera"])
    if "rotate" in given:
        angles = given.pop("rotate")
        count = angles.count(",") + 1
        turn = numbers("--rotate", angles, "90" if count == 1 else "90,10,5")
        given["matrix"] = rotation(*map(math.radians, turn))
    given = {_OTHER_NAMES.get(name, name): value for name, value in given.items()}
    layout = {name: given.pop(name) for name in ARGUMENTS if name in given}
    if layout:
        given["layout"] = Layout(**layout)
    return given


def _camera(text: str) -> list[list[float]]:
    """Rows of a camera matrix, from 9, 12 or 16 numbers."""
    with contextlib.suppress(ValueError):
        values = [float(value) for value in text.split(",")]
        if len(values) in (9, 12, 16):
            columns = 3 if len(values) == 9 else 4
            return [values[row : row + columns] for row in range(0, len(values), columns)]
    raise EnvLightsError(
        "--camera must be 9, 12 or 16 numbers between commas, the rows of the matrix of a camera;"
        f" got {text}"
    )


#: Python names of options that differ from the name on the command line.
_OTHER_NAMES = {"map_width": "width", "level": "up", "ball_distance": "distance"}
#: Options by parameter name.
_OPTIONS: dict[str, dict[str, Any]] = {
    "colour": {
        "metavar": "SPACE",
        "help": "Colour space of MAP instead of what the file says: linear, srgb, p3, rec2020, ...,"
        " or the path of an ICC profile.",
    },
    "part": {
        "help": "Part or layer of MAP, by name or number from 0  [default: the beauty layer]."
    },
    "channels": {
        "metavar": "NAMES",
        "help": "Names of red, green and blue, or of one grey channel, then perhaps alpha, between"
        " commas.",
    },
    "projection": {
        "metavar": "LAYOUT",
        "help": f"Layout of MAP if it cannot be recognised: {', '.join(PROJECTIONS)}.",
    },
    "faces": {"metavar": "ORDER", "help": "Order of the faces of a cube: opengl, ..."},
    "registration": {
        "type": click.Choice(REGISTRATIONS),
        "help": "Position of the pixels: in cells, or the outer ones on the seam and the poles.",
    },
    "fov": {"type": float, "metavar": "DEGREES", "help": "Horizontal field of view of MAP."},
    "mapping": {
        "metavar": "NAME",
        "help": "Mapping of a fisheye: equidistant, equisolid, stereographic or orthographic.",
    },
    "horizon": {
        "type": float,
        "metavar": "ROW",
        "help": "Row of elevation 0 in a cylinder or a part of a panorama  [default: the middle].",
    },
    "circle": {
        "metavar": "X,Y,RADIUS",
        "help": "Circle of a fisheye or mirror ball, in pixels.",
    },
    "ball_distance": {
        "type": float,
        "metavar": "RADII",
        "help": "Distance of the camera from a mirror ball, in its radii  [default: far away].",
    },
    "forward": {
        "metavar": "X,Y,Z",
        "help": "Direction of the centre of a circle or a photograph  [default: +z].",
    },
    "eye": {"type": click.Choice(EYES), "help": "Half of a stereo panorama."},
    "map_width": {
        "type": int,
        "metavar": "COLUMNS",
        "help": "Columns of the map that MAP becomes if it has another layout.",
    },
    "clip_level": {
        "type": float,
        "metavar": "LEVEL",
        "help": "Clip level of MAP; known for files of integers.",
    },
    "max_pixels": {"type": int, "metavar": "COUNT", "help": "Largest number of pixels to read."},
    "any_format": {
        "is_flag": True,
        "help": "Try all formats of OpenImageIO (extra `formats`); not for files of strangers.",
    },
    "lux": {
        "type": float,
        "metavar": "LUX",
        "help": "Measured illuminance of a horizontal surface; lights are then in lux.",
    },
    "normal": {
        "metavar": "X,Y,Z",
        "help": "Normal of that surface, if it is not horizontal.",
    },
    "shaded": {
        "type": float,
        "metavar": "LUX",
        "help": "Second reading with the sun shaded, if the sun is clipped.",
    },
    "nits": {
        "type": float,
        "metavar": "NITS",
        "help": "Measured luminance of a patch of MAP, in cd/m2.",
    },
    "at": {"metavar": "X,Y,Z", "help": "Direction of that patch."},
    "patch": {"type": float, "metavar": "DEGREES", "help": "Diameter of that patch; 1 by default."},
    "ev100": {
        "type": float,
        "metavar": "EV",
        "help": "Exposure value of MAP at ISO 100, for lux.",
    },
    "level": {"metavar": "X,Y,Z", "help": "Direction in MAP that is up; it becomes the zenith."},
    "rotate": {
        "metavar": "YAW[,PITCH,ROLL]",
        "help": "Turn MAP by angles in degrees: its centre to the left, then up, its zenith to the"
        " left.",
    },
    "camera": {
        "metavar": "MATRIX",
        "help": "Turn MAP into the view of a camera of --frame: 9, 12 or 16 numbers, row by row, as"
        " COLMAP, nerfstudio, ... store them.",
    },
    "frame": {
        "type": click.Choice([*FRAMES]),
        "help": "Axes of --camera and of directions that you type or that are printed.",
    },
}


def unseen_option() -> Callable[[Any], Any]:
    """Option ``--fill``; pass its value to `radiance_or_name`."""
    return click.option(
        "--fill",
        cls=MapOption,
        metavar="CHOICE",
        help="Radiance where MAP shows nothing (alpha, a crop): black, harmonic, ground, a number,"
        " or R,G,B. Needed if less than 85 % of the sphere is seen.",
    )


def radiance_or_name(text: str | None) -> str | list[float] | float | None:
    """Value of ``--fill``: a number, comma-separated RGB, or the name of a fill."""
    if text is None:
        return None
    try:
        channels = [float(channel) for channel in text.split(",")]
    except ValueError:
        return text
    return channels if channels[1:] else channels[0]
