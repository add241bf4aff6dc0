"""Options of subcommands that fit lights to maps."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import click

from envlights.batches.work import check_options
from envlights.cli.options.map_input import direction_in, radiance_or_name, unseen_option
from envlights.cli.options.outputs import default_of
from envlights.detection.lights_file import SUFFIXES, load_lights
from envlights.fitting.fit import fit
from envlights.fitting.map_fit import OBJECTIVES
from envlights.fitting.request import AMBIENTS, AUTO
from envlights.rigs.lights import Lights
from envlights.rigs.rig import Rig


def shape_options(function: Callable[..., None]) -> Callable[..., None]:
    """Options ``--sizes``, ``--max-radius``, ``--objective`` and ``--floor``."""
    of_sizes = click.option(
        "--sizes/--points",
        default=default_of(fit, "sizes"),
        help="Lights with a size, for soft shadows, or points.",
        show_default=True,
    )
    of_radius = click.option(
        "--max-radius", type=float, help="Largest angular radius of a light in degrees."
    )
    of_objective = click.option(
        "--objective",
        type=click.Choice(OBJECTIVES),
        default=default_of(fit, "objective"),
        help="Error to minimise with sized lights: shadows, probe (no shadows), or a mean of both.",
        show_default=True,
    )
    of_floor = click.option(
        "--floor",
        is_flag=True,
        help="The scene has a floor, which hides light from below the horizon.",
    )
    return of_sizes(of_radius(of_objective(of_floor(function))))


def roughness_option(of: str) -> Callable[[Any], Any]:
    """Option ``--roughness``."""
    return click.option(
        "--roughness",
        type=float,
        default=default_of(fit, "roughness"),
        help=f"Roughness of {of}, from 0.3 to 1.",
        show_default=True,
    )


def curve_options(function: Callable[..., None]) -> Callable[..., None]:
    """Options of `error_curve` except the numbers; pass their values to `curve_arguments`."""
    of_ambient = click.option(
        "--ambient", type=click.Choice([*AMBIENTS, AUTO]), help="Light from all directions."
    )
    of_roughness = roughness_option("the metal of the gloss error")
    return shape_options(of_roughness(of_ambient(unseen_option()(function))))


def curve_arguments(lights: Sequence[int], options: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of `error_curve`, checked before a map is read."""
    arguments = {
        "lights": lights,
        **options,
        "max_radius": radius_of(options["max_radius"]),
        "fill": radiance_or_name(options["fill"]),
    }
    check_options("error_curve", arguments)
    return arguments


def start_options(function: Callable[..., None]) -> Callable[..., None]:
    """Options ``--start`` and ``--fixed``; pass their values to `start_of` and `fixed_of`."""
    of_start = click.option(
        "--start",
        default=default_of(fit, "start"),
        metavar="START",
        help="First directions: greedy (the full search), detect, even, or those of a file of a rig"
        " or of lights (.json, .csv).",
        show_default=True,
    )
    of_fixed = click.option(
        "--fixed",
        multiple=True,
        metavar="X,Y,Z",
        help="Direction towards a light that does not move, or a file of such lights. Can be"
        " repeated.",
    )
    return of_start(of_fixed(function))


def start_of(text: str) -> str | Rig | Lights:
    """Value of ``--start``: a name, or the lights of a file."""
    return load_lights(text) if text.lower().endswith(SUFFIXES) else text


def fixed_of(texts: Sequence[str], frame: str | None) -> list[list[float]] | None:
    """Values of ``--fixed`` as unit vectors; None if not given."""
    rows = [row for text in texts for row in _fixed(text, frame)]
    return rows or None


def _fixed(text: str, frame: str | None) -> list[list[float]]:
    if text.lower().endswith(SUFFIXES):
        held = load_lights(text)
        rows: list[list[float]] = (
            held.lights if isinstance(held, Rig) else held
        ).direction.tolist()
        return rows
    towards = direction_in(frame, "--fixed", text)
    length = math.hypot(*towards)
    # Normalise, because typed digits never have length exactly 1; the fit rejects a length of 0.
    return [[value / (length or 1.0) for value in towards]]


def radius_of(degrees: float | None) -> float | None:
    """Value of ``--max-radius`` in radians."""
    return None if degrees is None else math.radians(degrees)
