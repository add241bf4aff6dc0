"""`envlights merge`: `EnvMap.from_exposures` on files."""

from __future__ import annotations

from collections.abc import Sequence
from glob import glob, has_magic
from pathlib import Path

import click

from envlights._native import EnvLightsError
from envlights.cli.options.outputs import check_output, say_written
from envlights.environment.envmap import EnvMap
from envlights.environment.files.image_output import MAP_SUFFIXES


@click.command("merge")
@click.argument("patterns", metavar="GLOB...", nargs=-1, required=True)
@click.option("-o", "--output", required=True, help="File to write (.exr, .hdr).")
@click.option(
    "--times",
    help="Exposure times, separated by commas, such as 1/250,1/30,2; one for each picture, in the"
    " order of their names. Default: time, sensitivity and aperture in the files.",
)
@click.option(
    "--response",
    type=click.Choice(["srgb", "linear"]),
    help="Response of the camera. Default: it is recognised, or estimated; then the radiance is"
    " relative.",
)
def command(patterns: Sequence[str], output: str, times: str | None, response: str | None) -> None:
    """Merge exposures into one map.

    GLOB is a file, or a pattern such as 'shots/*.jpg', whose files are sorted by name.
    """
    paths = [path for pattern in patterns for path in _paths(pattern)]
    check_output(output, MAP_SUFFIXES, {f"exposure {n}": path for n, path in enumerate(paths, 1)})
    seconds = None if times is None else [_seconds(time) for time in times.split(",")]
    env = EnvMap.from_exposures(paths, seconds, response=response)
    env.save(output)
    click.echo(str(env))
    say_written([output])


def _paths(pattern: str) -> list[str]:
    """Files that match a pattern, sorted by name."""
    if Path(pattern).exists() or not has_magic(pattern):
        return [pattern]
    found = sorted(glob(pattern))  # noqa: PTH207, patterns may be absolute
    if not found:
        raise EnvLightsError(f"no file matches {pattern}; give files, or another pattern")
    return found


def _seconds(time: str) -> float:
    """Exposure time as a number, from text such as 0.02 or 1/50."""
    above, _, below = time.partition("/")
    try:
        return float(above) / float(below or 1)
    except (ValueError, ZeroDivisionError):
        raise EnvLightsError(
            f"times must be numbers or fractions such as 1/50, separated by commas; got {time!r}"
        ) from None
