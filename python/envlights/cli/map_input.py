"""Argument MAP of a subcommand, with the options on how its file is read."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import click

from envlights.envmap import EnvMap


class MapFile(NamedTuple):
    """File of a map, and the options on how it is read."""

    path: str
    """Path; "-" is the standard input."""

    colour: str | None
    """Colour space by hand."""

    part: str | None
    """Part or layer by hand."""

    projection: str | None = None
    """Layout by hand."""

    faces: str | None = None
    """Order of the faces of a cube by hand."""

    fov: float | None = None
    """Field of view in degrees."""

    mapping: str | None = None
    """Mapping of a fisheye by hand."""

    lux: float | None = None
    """Measured illuminance of a horizontal surface."""

    shaded: float | None = None
    """Second reading with the sun shaded."""

    ev100: float | None = None
    """Exposure value at ISO 100."""

    def open(self) -> EnvMap:
        """Map of the file, calibrated if there is a reading."""
        options = self._asdict()
        readings = {name: options.pop(name) for name in ("lux", "shaded", "ev100")}
        env = EnvMap.open(options.pop("path"), **options)
        is_measured = any(reading is not None for reading in readings.values())
        return env.calibrated(**readings) if is_measured else env

    def unread(self) -> str | EnvMap:
        """Path, which is read by rows; the map itself if options say how to read it."""
        return self.open() if any(option is not None for option in self[1:]) else self.path


def map_argument(function: Callable[..., None]) -> Callable[..., None]:
    """Argument MAP and its options; `function` takes them as a `MapFile` first."""

    @click.argument("map_path", metavar="MAP")
    @click.option(
        "--colour",
        metavar="SPACE",
        help="Colour space of MAP instead of what the file says: linear, srgb, p3, rec2020, ...,"
        " or the path of an ICC profile.",
    )
    @click.option(
        "--part", help="Part or layer of MAP, by name or number from 0; the finished picture else."
    )
    @click.option(
        "--projection",
        metavar="LAYOUT",
        help="Layout of MAP if it cannot be recognised: equirectangular, cube, octahedral,"
        " octahedral-equal-area, angular, mirror-ball, fisheye, cylinder or planar.",
    )
    @click.option("--faces", metavar="ORDER", help="Order of the faces of a cube: opengl, ...")
    @click.option("--fov", type=float, metavar="DEGREES", help="Horizontal field of view of MAP.")
    @click.option(
        "--mapping",
        metavar="NAME",
        help="Mapping of a fisheye: equidistant, equisolid, stereographic or orthographic.",
    )
    @click.option(
        "--lux",
        type=float,
        metavar="LUX",
        help="Measured illuminance of a horizontal surface; lights are then in lux.",
    )
    @click.option(
        "--shaded",
        type=float,
        metavar="LUX",
        help="Second reading with the sun shaded, if the sun is clipped.",
    )
    @click.option(
        "--ev100", type=float, metavar="EV", help="Exposure value of MAP at ISO 100, for lux."
    )
    @functools.wraps(function)
    def command(map_path: str, **options: Any) -> None:
        of_map = {name: options.pop(name) for name in MapFile._fields[1:]}
        function(MapFile(map_path, **of_map), **options)

    return command


def unseen_option() -> Callable[[Any], Any]:
    """Option ``--unseen``; its value is for `radiance_or_name`."""
    return click.option(
        "--unseen",
        metavar="CHOICE",
        help="Radiance where MAP shows nothing (alpha, a crop): black, harmonic, ground, a number,"
        " or R,G,B. Needed if less than 85 % of the sphere is seen.",
    )


def radiance_or_name(text: str | None) -> str | list[float] | float | None:
    """Value of ``--unseen``: a number, RGB between commas, or the name of a fill."""
    if text is None:
        return None
    try:
        channels = [float(channel) for channel in text.split(",")]
    except ValueError:
        return text
    return channels if channels[1:] else channels[0]
