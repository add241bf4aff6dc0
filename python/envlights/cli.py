"""The command line: one subcommand, one public function."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click

import envlights
from envlights.files import check_writable, write_atomically
from envlights.rig import Rig


class _Refusing(click.Group):
    """A group whose refusals are a sentence and the exit code 2, not a traceback."""

    def invoke(self, context: click.Context) -> Any:
        try:
            return super().invoke(context)
        except envlights.EnvLightsError as refusal:
            click.echo(f"envlights: {refusal}", err=True)
            context.exit(2)


def _outputs(help_text: str) -> Callable[[Any], Any]:
    return click.option("-o", "--output", "outputs", multiple=True, metavar="OUT", help=help_text)


@click.group(cls=_Refusing, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(envlights.__version__, prog_name="envlights")
def main() -> None:
    """Turn an environment map into a handful of lights."""


@main.command()
@click.argument("map_path", metavar="MAP")
@click.option("-n", "--lights", type=int, help="Directional lights, at most; 4 when left out.")
@click.option("--error", type=float, help="Use the fewest lights with at most this error: 0.01.")
@click.option(
    "--ambient",
    type=click.Choice(["constant", "none", "sh2"]),
    default="constant",
    show_default=True,
    help="The environment beside the lights; sh2: nine spherical harmonics.",
)
@click.option(
    "--normals",
    type=click.Choice(["sphere", "upper"]),
    default="sphere",
    show_default=True,
    help="Surfaces that count; upper: those that face up, for things on a floor.",
)
@_outputs("Write the rig (.json) or a picture (.png, .pdf, .svg); may be given again.")
@click.option("--json", "as_json", is_flag=True, help="Print the rig as JSON.")
def fit(
    map_path: str,
    lights: int | None,
    error: float | None,
    ambient: str,
    normals: str,
    outputs: Sequence[str],
    as_json: bool,
) -> None:
    """Fit ambient and directional lights to MAP (.hdr, .exr, .png, .jpg, .tif)."""
    for output in outputs:
        _check_output(output, map_path)
    env = envlights.EnvMap.open(map_path)
    rig = envlights.fit(env, lights, error=error, ambient=ambient, normals=normals)
    _print(rig, as_json)
    for output in outputs:
        _write(env, rig, output)
        click.echo(f"wrote {output}", err=True)


@main.command()
@click.argument("map_path", metavar="MAP")
@click.option("-n", "--max-lights", type=int, help="Merge neighbours until there are no more.")
@click.option(
    "--method",
    type=click.Choice(["tree", "article"]),
    default="tree",
    show_default=True,
    help="How bright places are found.",
)
@_outputs("Write the lights (.json) or a picture (.png, .pdf, .svg); may be given again.")
@click.option("--json", "as_json", is_flag=True, help="Print the lights as JSON.")
def detect(
    map_path: str, max_lights: int | None, method: str, outputs: Sequence[str], as_json: bool
) -> None:
    """Find the bright places of MAP (.hdr, .exr, .png, .jpg, .tif)."""
    for output in outputs:
        _check_output(output, map_path)
    env = envlights.EnvMap.open(map_path)
    lights = envlights.detect(env, method, max_lights=max_lights)
    click.echo(json.dumps(lights.to_dict(), indent=2) if as_json else str(lights))
    for output in outputs:
        _write_lights(env, lights, output)
        click.echo(f"wrote {output}", err=True)


@main.command()
@click.option(
    "-o",
    "--output",
    "folder",
    default=".",
    metavar="FOLDER",
    help="Where the files go.",
    show_default=True,
)
@click.option("--json", "as_json", is_flag=True, help="Print the rig as JSON.")
def demo(folder: str, as_json: bool) -> None:
    """Make a hall with three bright windows, fit it, and draw the result."""
    from envlights.demo import demo as run

    _print(run(folder), as_json)
    for suffix in ("exr", "json", "png"):
        click.echo(f"wrote {Path(folder) / 'hall'}.{suffix}", err=True)


def _print(rig: Rig, as_json: bool) -> None:
    click.echo(json.dumps(rig.to_dict(), indent=2) if as_json else f"{rig}\n\n{rig.report}")


def _check_output(output: str, map_path: str) -> None:
    known = (".json", ".png", ".pdf", ".svg")
    if Path(output).suffix.lower() not in known:
        raise envlights.EnvLightsError(
            f"cannot write {output}: the suffix must be one of {', '.join(known)}"
        )
    target = check_writable(output)
    if _is_same(target, Path(map_path)):
        raise envlights.EnvLightsError(f"cannot write {output}: it is the map; give another name")


def _is_same(target: Path, source: Path) -> bool:
    return target.exists() and source.exists() and target.samefile(source)


def _write(env: envlights.EnvMap, rig: Rig, output: str) -> None:
    if Path(output).suffix.lower() == ".json":
        rig.save(output)
        return
    # Drawing takes a second to import; a rig alone does not need it.
    from envlights import plot

    plot.save(plot.picture(env, rig), output)


def _write_lights(env: envlights.EnvMap, lights: envlights.DetectedLights, output: str) -> None:
    if Path(output).suffix.lower() == ".json":
        text = json.dumps(lights.to_dict(), indent=2, allow_nan=False) + "\n"
        write_atomically(output, lambda beside: beside.write_text(text, encoding="utf-8"))
        return
    from envlights import plot

    plot.save(plot.detection_picture(env, lights), output)
