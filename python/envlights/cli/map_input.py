"""Argument MAP of a subcommand, with the options on how its file is read."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import click

from envlights.cli.numbers import numbers
from envlights.environment.envmap import EnvMap
from envlights.environment.layouts.projections import (
    ARGUMENTS,
    EYES,
    PROJECTIONS,
    REGISTRATIONS,
    Layout,
)

#: Heading of the options on how a file is read, in the help.
_HEADING = "Options on how MAP is read"
#: Options of `EnvMap.calibrated`; the others are of `EnvMap.open`.
_READINGS = ("lux", "normal", "shaded", "nits", "at", "patch", "ev100")
_DIRECTION = "0.5,0.7,0.5"


class MapFile(NamedTuple):
    """File of a map, and the options on how it is read."""

    path: str
    """Path; "-" is the standard input."""

    options: Mapping[str, Any] = MappingProxyType({})
    """Options of `EnvMap.open` that were given."""

    readings: Mapping[str, Any] = MappingProxyType({})
    """Options of `EnvMap.calibrated`."""

    def open(self, fill: Any = None) -> EnvMap:
        """Map of the file, calibrated if there is a reading."""
        env = EnvMap.open(self.path, **self.options)
        return env.calibrated(**self.readings, fill=fill) if self.readings else env

    def unread(self, fill: Any = None) -> str | EnvMap:
        """Path, which is read by rows; the map itself if options say how to read it."""
        return self.open(fill) if self.options or self.readings else self.path


class _MapOption(click.Option):
    """Option on how a map is read."""


class MapCommand(click.Command):
    """Subcommand with MAP: its help lists the options on how MAP is read after the others."""

    def format_options(self, context: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options as two lists."""
        for heading, is_of_map in (("Options", False), (_HEADING, True)):
            records = [
                parameter.get_help_record(context)
                for parameter in self.get_params(context)
                if isinstance(parameter, click.Option)
                and isinstance(parameter, _MapOption) is is_of_map
            ]
            rows = [record for record in records if record is not None]
            if rows:
                with formatter.section(heading):
                    formatter.write_dl(rows)


def map_argument(function: Callable[..., None]) -> Callable[..., None]:
    """Argument MAP and its options; `function` takes them as a `MapFile` first."""

    @functools.wraps(function)
    def command(map_path: str, **options: Any) -> None:
        given = {name: options.pop(name) for name in _OPTIONS}
        given = {name: value for name, value in given.items() if value not in (None, False)}
        for name, example in _VECTORS.items():
            if name in given:
                given[name] = numbers(f"--{name}", given[name], example)
        if "channels" in given:
            given["channels"] = given["channels"].split(",")
        layout = {name: given.pop(name) for name in ARGUMENTS if name in given}
        if layout:
            given["layout"] = Layout(**layout)
        readings = {name: given.pop(name) for name in _READINGS if name in given}
        if "map_width" in given:
            given["width"] = given.pop("map_width")
        function(MapFile(map_path, given, readings), **options)

    wrapped: Any = command
    for name, settings in reversed(_OPTIONS.items()):
        flag = f"--{name.replace('_', '-')}"
        wrapped = click.option(flag, name, cls=_MapOption, **settings)(wrapped)
    return click.argument("map_path", metavar="MAP")(wrapped)  # type: ignore[no-any-return]


#: Examples of the options that are numbers between commas.
_VECTORS = {"circle": "512,512,500", "forward": _DIRECTION, "normal": _DIRECTION, "at": _DIRECTION}
#: Options by the name of the parameter; `map_width` is `width` of `EnvMap.open`.
_OPTIONS: dict[str, dict[str, Any]] = {
    "colour": {
        "metavar": "SPACE",
        "help": "Colour space of MAP instead of what the file says: linear, srgb, p3, rec2020, ...,"
        " or the path of an ICC profile.",
    },
    "part": {"help": "Part or layer of MAP, by name or number from 0; the finished picture else."},
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
        "help": "Row of elevation 0 in a cylinder or a part of a panorama; the middle else.",
    },
    "circle": {
        "metavar": "X,Y,RADIUS",
        "help": "Circle of a fisheye or mirror ball, in pixels.",
    },
    "forward": {
        "metavar": "X,Y,Z",
        "help": "Direction of the centre of a circle or a photograph; +z else.",
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
    "patch": {"type": float, "metavar": "DEGREES", "help": "Radius of that patch; 1 by default."},
    "ev100": {
        "type": float,
        "metavar": "EV",
        "help": "Exposure value of MAP at ISO 100, for lux.",
    },
}


def unseen_option() -> Callable[[Any], Any]:
    """Option ``--fill``; its value is for `radiance_or_name`."""
    return click.option(
        "--fill",
        metavar="CHOICE",
        help="Radiance where MAP shows nothing (alpha, a crop): black, harmonic, ground, a number,"
        " or R,G,B. Needed if less than 85 % of the sphere is seen.",
    )


def radiance_or_name(text: str | None) -> str | list[float] | float | None:
    """Value of ``--fill``: a number, RGB between commas, or the name of a fill."""
    if text is None:
        return None
    try:
        channels = [float(channel) for channel in text.split(",")]
    except ValueError:
        return text
    return channels if channels[1:] else channels[0]
