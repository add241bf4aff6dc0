"""`envlights detect`: `envlights.detect` on a file."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import click

from envlights.cli.outputs import OUTPUTS, check_output, default_of, output_option, say_written
from envlights.detection.detect import METHODS, detect
from envlights.detection.lights import DetectedLights
from envlights.envmap import EnvMap
from envlights.export.targets import SUFFIXES
from envlights.io.files import PICTURES


@click.command("detect")
@click.argument("map_path", metavar="MAP")
@click.option(
    "-n",
    "--max-lights",
    type=int,
    help="Most lights: tree merges neighbours, article drops the dimmest.",
)
@click.option(
    "--method",
    type=click.Choice(list(METHODS)),
    default=default_of(detect, "method"),
    show_default=True,
    help="Detector: the component tree, or the steps of Loghin (2021).",
)
@output_option(OUTPUTS)
@click.option("--json", "as_json", is_flag=True, help="Print the lights as JSON.")
@click.option("--verbose", is_flag=True, help="Print details for authors of detectors too.")
def command(
    map_path: str,
    max_lights: int | None,
    method: str,
    outputs: Sequence[str],
    as_json: bool,
    verbose: bool,
) -> None:
    """Find the lights of MAP (.hdr, .exr, .png, .jpg, .tif)."""
    for output in outputs:
        check_output(output, (*SUFFIXES, *PICTURES), {"the map": map_path})
    env = EnvMap.open(map_path)
    lights = detect(env, method, max_lights=max_lights)
    for output in outputs:
        _write(env, lights, output)
    text = lights.described(verbose=verbose)
    click.echo(json.dumps(lights.to_dict(), indent=2) if as_json else text)
    say_written(outputs)


def _write(env: EnvMap, lights: DetectedLights, output: str) -> None:
    if Path(output).suffix.lower() not in PICTURES:
        lights.save(output)
        return
    from envlights import plot

    plot.save(plot.detection_picture(env, lights), output)
