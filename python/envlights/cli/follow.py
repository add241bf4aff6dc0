"""`envlights follow`: `envlights.follow` on the frames of a sequence."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import click

from envlights.cli.fit_input import radius_of, shape_options
from envlights.cli.map_input import radiance_or_name, unseen_option
from envlights.cli.outputs import check_output, default_of, output_option, say_written
from envlights.fitting.request import AMBIENTS
from envlights.sequence.follow import follow
from envlights.sequence.formats import SUFFIXES


@click.command("follow")
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
@output_option(f"File to write ({', '.join(SUFFIXES)}). Can be repeated.")
@click.option("--json", "as_json", is_flag=True, help="Print the sequence as JSON.")
def command(
    frames: str,
    lights: int | None,
    error: float | None,
    steadiness: str,
    fps: float | None,
    sizes: bool,
    max_radius: float | None,
    objective: str,
    ambient: str,
    floor: bool,
    fill: str | None,
    outputs: Sequence[str],
    as_json: bool,
) -> None:
    """Fit a rig to each map of FRAMES; each light keeps its identity.

    FRAMES is a pattern in quotes ('frames/*.exr'), a folder or a video.
    """
    for output in outputs:
        check_output(output, SUFFIXES, {"the sequence": frames} if Path(frames).is_file() else {})
    if lights is None and error is None:
        lights = default_of(follow, "lights")
    rigs = follow(
        frames,
        lights,
        steadiness=int(steadiness) if steadiness.isdecimal() else steadiness,
        fps=fps,
        error=error,
        sizes=sizes,
        max_radius=radius_of(max_radius),
        objective=objective,
        ambient=ambient,
        floor=floor,
        fill=radiance_or_name(fill),
    ).sequence()
    for output in outputs:
        rigs.save(output)
    click.echo(json.dumps(rigs.to_dict(), indent=2) if as_json else str(rigs))
    say_written(outputs)
