"""Options on the sun of a map, for several subcommands."""

from __future__ import annotations

import datetime
import functools
from collections.abc import Callable
from typing import Any

import click

from envlights._native import EnvLightsError
from envlights.cli.options.map_input import MapOption, direction_in
from envlights.sun.almanac import SunAt
from envlights.sun.choice import AUTO, AnySun


def sun_options(function: Callable[..., None]) -> Callable[..., None]:
    """Decorator that adds the sun options as an argument `sun`, None if none is given."""

    @click.option("--sun", "is_auto", is_flag=True, help="Find the sun in a clipped MAP.")
    @click.option(
        "--sun-direction",
        cls=MapOption,
        metavar="X,Y,Z",
        help="Direction towards the sun, if it is known.",
    )
    @click.option(
        "--sun-time",
        cls=MapOption,
        metavar="TIME",
        help="Time of MAP with its zone, such as 2024-06-21T12:00+02:00, with --latitude and"
        " --longitude: the elevation of the sun.",
    )
    @click.option(
        "--latitude",
        cls=MapOption,
        type=float,
        metavar="DEGREES",
        help="Latitude; north is positive.",
    )
    @click.option(
        "--longitude",
        cls=MapOption,
        type=float,
        metavar="DEGREES",
        help="Longitude; east is positive.",
    )
    @click.option(
        "--north",
        cls=MapOption,
        type=float,
        metavar="DEGREES",
        help="Azimuth of north in MAP: 0 at its left edge, 180 in the middle.",
    )
    @functools.wraps(function)
    def command(
        *arguments: Any,
        is_auto: bool,
        sun_direction: str | None,
        sun_time: str | None,
        latitude: float | None,
        longitude: float | None,
        north: float | None,
        **options: Any,
    ) -> None:
        sun: AnySun | None = AUTO if is_auto else None
        if sun_direction is not None:
            frame = click.get_current_context().params["frame"]
            sun = direction_in(frame, "--sun-direction", sun_direction)
        if any(each is not None for each in (sun_time, latitude, longitude, north)):
            if sun_direction is not None:
                raise EnvLightsError("give --sun-direction or --sun-time, not both")
            sun = _sun_at(sun_time, latitude, longitude, north)
        function(*arguments, sun=sun, **options)

    return command


def reading_options(function: Callable[..., None]) -> Callable[..., None]:
    """Options ``--irradiance`` and ``--ratio``."""
    of_irradiance = click.option(
        "--irradiance", type=float, help="Measured irradiance of a horizontal surface."
    )
    of_ratio = click.option(
        "--ratio",
        type=float,
        help="Irradiance in full sun divided by irradiance with the sun blocked, both horizontal.",
    )
    return of_irradiance(of_ratio(function))


def _sun_at(
    time: str | None, latitude: float | None, longitude: float | None, north: float | None
) -> SunAt:
    if time is None or latitude is None or longitude is None:
        raise EnvLightsError("--sun-time, --latitude and --longitude go together; give all three")
    try:
        # Replace Z, which Python 3.10 does not parse as UTC.
        at = datetime.datetime.fromisoformat(time.replace("Z", "+00:00"))
    except ValueError:
        raise EnvLightsError(
            f"--sun-time must be a time with its zone, such as 2024-06-21T12:00+02:00; got {time}"
        ) from None
    return SunAt(at, latitude, longitude, north)
