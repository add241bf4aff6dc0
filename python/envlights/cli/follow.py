"""`envlights follow`: `envlights.follow` on the frames of a sequence."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from envlights.cli.options.fit_input import radius_of, shape_options
from envlights.cli.options.map_input import (
    MapCommand,
    radiance_or_name,
    reading_options,
    unseen_option,
)
from envlights.cli.options.outputs import (
    check_outputs,
    default_of,
    json_option,
    output_option,
    print_result,
    say_written,
    stage_of,
    stage_options,
)
from envlights.environment.reading import Reading
from envlights.fitting.request import AMBIENTS
from envlights.sequence.follow import follow
from envlights.sequence.formats import SUFFIXES


@click.command("follow", cls=MapCommand)
@click.argument("frames", metavar="FRAMES")
@click.option(
    "-n",
    "--lights",
    type=int,
    help=f"Largest number of lights; {default_of(follow, 'lights')} by default, 32 with --error.",
)
@click.option(
    "--error", type=float, help="Largest error; the fewest lights that reach it are used."
)
@click.option(
    "--steadiness",
    default=str(default_of(follow, "steadiness")),
    metavar="FRAMES",
    help="Half-width of the window of the mean, in frames, or in seconds with --fps: 0.2s.",
    show_default=True,
)
@click.option("--fps", type=float, help="Frames in a second; that of a video by default.")
@shape_options
@click.option(
    "--ambient",
    type=click.Choice([*AMBIENTS]),
    default=default_of(follow, "ambient"),
    help="Light from all directions.",
    show_default=True,
)
@unseen_option()
@stage_options
@output_option(f"File to write ({', '.join(SUFFIXES)}). Can be repeated.")
@json_option("sequence")
@reading_options
def command(
    frames: str,
    lights: int | None,
    error: float | None,
    steadiness: str,
    max_radius: float | None,
    fill: str | None,
    outputs: Sequence[str],
    stage: dict[str, Any],
    as_json: bool,
    reading: Reading,
    **options: Any,
) -> None:
    """Fit a rig to each map of FRAMES; each light keeps its identity.

    FRAMES is a pattern in quotes ('frames/*.exr'), a folder or a video.
    """
    inputs = {"the sequence": frames} if Path(frames).is_file() else {}
    check_outputs(outputs, SUFFIXES, inputs, stage)
    if lights is None and error is None:
        lights = default_of(follow, "lights")
    rigs = follow(
        frames,
        lights,
        steadiness=int(steadiness) if steadiness.isdecimal() else steadiness,
        error=error,
        max_radius=radius_of(max_radius),
        fill=radiance_or_name(fill),
        reading=reading or None,
        **options,
    ).sequence()
    for output in outputs:
        rigs.save(output, **stage_of(output, stage))
    print_result(rigs, as_json)
    say_written(outputs)
