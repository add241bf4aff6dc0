"""`envlights split`: `envlights.split` or `envlights.limit` on a file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import click

from envlights._common.files import PICTURES
from envlights._native import EnvLightsError
from envlights.batches.work import check_options
from envlights.cards.card_split import CardSplit, at_place
from envlights.cards.cut import with_discs
from envlights.cli.convert import layout_option, write_map
from envlights.cli.options.detection_input import detection_settings
from envlights.cli.options.map_input import MapCommand, MapFile, map_argument
from envlights.cli.options.outputs import (
    check_outputs,
    check_source,
    json_option,
    output_option,
    print_losses,
    print_result,
    say_written,
    stage_options,
    verbose_option,
)
from envlights.cli.options.settings import settings_of, settings_option
from envlights.cli.options.sun_input import reading_options, sun_options
from envlights.detection.detect import detect
from envlights.environment.envmap import EnvMap
from envlights.environment.files.image_output import MAP_SUFFIXES
from envlights.environment.pixels import PROJECTION
from envlights.export.links import paths_of, plan, save_with_map
from envlights.export.targets import SUFFIXES
from envlights.splitting.limit import Limit, limit
from envlights.splitting.split import Split, split
from envlights.sun.choice import AnySun, sun_of
from envlights.sun.result import Sun
from envlights.sun.sun_split import SunSplit, with_sun

_Parts = Split | CardSplit | Limit | SunSplit


@click.command("split", cls=MapCommand)
@map_argument
@click.option(
    "-n",
    "--lights",
    type=int,
    help="Largest number of lights to remove, such as 1 for the sun; the others are left where they"
    " are.",
)
@click.option(
    "--fraction",
    type=float,
    help="Remove the fewest lights that together give this fraction of the flux of all lights, such"
    " as 0.9.",
)
@click.option(
    "--limit",
    "maximum",
    type=float,
    metavar="MAXIMUM",
    help="Remove only the radiance above this value, such as 65504 for half floats: one light for"
    " each region.",
)
@click.option(
    "--shapes",
    is_flag=True,
    help="Remove the lights as cards: rectangles, tubes and discs with their textures.",
)
@click.option(
    "--distance",
    type=float,
    help="Distance of the cards from the origin in scenes. Default: 1000 times --radius.",
)
@click.option("--radius", type=float, help="Radius of the scene that the cards light. Default: 1.")
@settings_option("detection", settings_of([detect], ("lights",)))
@sun_options
@reading_options
@layout_option("the map without the lights")
@output_option(
    "File to write: the map without the lights (.exr, .hdr), a scene of the lights with that map"
    " for the program of the suffix (list: envlights export -h), or a picture (.png, .pdf, .svg)."
    " Can be repeated; scenes name the .exr file."
)
@stage_options
@verbose_option()
@json_option("lights")
def command(
    map_file: MapFile,
    lights: int | None,
    fraction: float | None,
    maximum: float | None,
    shapes: bool,
    distance: float | None,
    radius: float | None,
    settings: Sequence[str],
    sun: AnySun | None,
    irradiance: float | None,
    ratio: float | None,
    target: str,
    outputs: Sequence[str],
    stage: dict[str, Any],
    verbose: bool,
    as_json: bool,
) -> None:
    """Remove the lights from MAP (.hdr, .exr, .png, .jpg, .tif)."""
    check_outputs(outputs, (*SUFFIXES, *MAP_SUFFIXES, *PICTURES), {"the map": map_file.path}, stage)
    options = detection_settings(settings, "tree")
    if options and ((sun is not None and not shapes) or maximum is not None):
        raise EnvLightsError("--set is of detected lights; leave out --sun and --limit, or --set")
    check_options("split", {"lights": lights, "fraction": fraction, "shapes": shapes, **options})
    if maximum is not None and (pictures := _pictures(outputs)):
        raise EnvLightsError(
            f"cannot write {pictures[0]}: pictures show lights of a split without --limit"
        )
    env = map_file.open()
    found = None if sun is None else sun_of(env, sun)
    readings = {"irradiance": irradiance, "ratio": ratio}
    parts = _parts(env, lights, fraction, maximum, found, readings, shapes, options)
    parts = _at_place(parts, distance, radius)
    draw = partial(_draw, env, parts, found)
    written = _write(parts, map_file.path, outputs, target, stage, draw)
    removed = parts.lights
    print_result(removed, as_json, verbose, map_file.frame)
    say_written(written)


def _parts(
    env: EnvMap,
    lights: int | None,
    fraction: float | None,
    maximum: float | None,
    sun: Sun | None,
    readings: dict[str, float | None],
    shapes: bool,
    options: dict[str, Any],
) -> _Parts:
    """Lights and remaining map, by detection, a maximum, or the sun."""
    has_choice = lights is not None or fraction is not None
    if shapes and maximum is not None:
        raise EnvLightsError("cards are detected lights; leave out --limit, or --shapes")
    if shapes and sun is not None:
        own = with_sun(env, sun, **readings)
        most = None if lights is None else max(lights - len(own.lights), 0)
        others = split(own.remainder, most, fraction=fraction, shapes=True, **options)
        return CardSplit(with_discs(others.cards, own.lights), others.remainder)
    if sun is not None:
        if has_choice or maximum is not None:
            raise EnvLightsError(
                "a sun is one light; leave out --lights, --fraction and --limit, or --sun"
            )
        return with_sun(env, sun, **readings)
    if any(reading is not None for reading in readings.values()):
        raise EnvLightsError("--irradiance and --ratio are readings of a sun; add --sun")
    if shapes:
        return split(env, lights, fraction=fraction, shapes=True, **options)
    if maximum is None:
        parts: Split = split(env, lights, fraction=fraction, **options)
        return parts
    if has_choice:
        raise EnvLightsError(
            "--limit takes all radiance above it; leave out --lights and --fraction"
        )
    return limit(env, maximum)


def _at_place(parts: _Parts, distance: float | None, radius: float | None) -> _Parts:
    """Result with its cards placed at a distance."""
    if isinstance(parts, CardSplit):
        return parts._replace(cards=at_place(parts.cards, distance, radius))
    if distance is not None or radius is not None:
        raise EnvLightsError("--distance and --radius place cards; add --shapes")
    return parts


def _write(
    parts: _Parts,
    source: str,
    outputs: Sequence[str],
    target: str,
    stage: dict[str, Any],
    draw: Callable[[str], None],
) -> list[str]:
    """Write all outputs; return the paths of all files, including the maps of scenes."""
    pictures = _pictures(outputs)
    # Scenes reference only equirectangular maps, because programs read no other layout.
    maps = [output for output in outputs if target != PROJECTION and _is_map(output)]
    scenes = [output for output in outputs if output not in (*pictures, *maps)]
    written = list(map(str, paths_of(plan(parts.remainder, scenes, parts.lights))))
    for path in written:
        check_source(path, {"the map": source})
    if scenes:
        with print_losses():
            save_with_map(parts.lights, parts.remainder, scenes, **stage)
    for output in maps:
        written += write_map(parts.remainder, output, target)
    for output in pictures:
        draw(output)
    return [*written, *pictures]


def _draw(env: EnvMap, parts: _Parts, sun: Sun | None, output: str) -> None:
    from envlights import plot

    if isinstance(parts, CardSplit):
        plot.save(plot.cards(env, parts.cards), output)
    elif isinstance(parts, Split):
        plot.save(plot.split_picture(env, parts), output)
    elif sun is not None:
        if len(parts.lights):  # a meter reading replaces the estimate
            sun = replace(sun, irradiance=parts.lights.irradiance[0])
        plot.save(plot.sun(env, sun), output)


def _pictures(outputs: Sequence[str]) -> list[str]:
    return [output for output in outputs if Path(output).suffix.lower() in PICTURES]


def _is_map(output: str) -> bool:
    return Path(output).suffix.lower() in MAP_SUFFIXES
