"""Output of subcommands: options, checks before the work, and printed text."""

from __future__ import annotations

import contextlib
import inspect
import json
import os
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

import click

from envlights._common.errors import FileError
from envlights._common.files import NO_MATPLOTLIB, PICTURES, can_draw, check_writable
from envlights._common.printable import printable
from envlights._native import EnvLightsError
from envlights.cli.options.standard_streams import is_standard_output
from envlights.export.saving import check_options
from envlights.export.targets import SUFFIXES, target_of
from envlights.frames import frame_named
from envlights.rigs.rig import Rig

#: Help of ``-o`` for subcommands that write lights.
OUTPUTS = (
    "File to write: lights for the program of the suffix (list: envlights export -h) or a picture"
    " (.png, .pdf, .svg). Can be repeated."
)


def default_of(function: Callable[..., Any], parameter: str) -> Any:
    """Default of a parameter, from the Python signature."""
    return inspect.signature(function).parameters[parameter].default


def output_option(help_text: str) -> Callable[[Any], Any]:
    """Repeatable option ``-o``."""
    return click.option("-o", "--output", "outputs", multiple=True, metavar="OUT", help=help_text)


def stage_options(command: Any) -> Any:
    """OpenUSD options ``--up`` and ``--metres-per-unit``, combined as the argument `stage`."""

    def collect(context: click.Context, option: click.Parameter, value: Any) -> None:
        stage = context.params.setdefault("stage", {})
        if value is not None:
            stage[option.name] = value

    option = partial(click.option, callback=collect, expose_value=False)
    up = option("--up", type=click.Choice(["y", "z"]), help="Up axis of files for OpenUSD.")
    metres = option(
        "--metres-per-unit", type=float, help="Unit of length for OpenUSD; 1 by default."
    )
    return up(metres(command))


def stage_of(output: str, stage: Mapping[str, Any]) -> dict[str, Any]:
    """Values of `stage_options` that the program of an output supports."""
    known = target_of(output).options if _is_scene(output) else ()
    return {name: stage[name] for name in stage if name in known}


def _is_scene(output: str) -> bool:
    """True for a file of lights for a target program."""
    return output.lower().endswith(SUFFIXES)


def json_option(what: str) -> Callable[[Any], Any]:
    """Option ``--json``."""
    return click.option("--json", "as_json", is_flag=True, help=f"Print the {what} as JSON.")


def verbose_option() -> Callable[[Any], Any]:
    """Option ``--verbose``."""
    return click.option("-v", "--verbose", is_flag=True, help="Print all details of the report.")


def strict_option() -> Callable[[Any], Any]:
    """Option ``--strict``."""
    return click.option(
        "--strict",
        is_flag=True,
        help="Write no file if its program would show a larger error than the printed one.",
    )


@contextlib.contextmanager
def print_losses(*, strict: bool = False) -> Iterator[None]:
    """Context that prints what programs lose of the written lights; raises an error if `strict`."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("error" if strict else "always", UserWarning)
        try:
            yield
        except UserWarning as loss:
            raise FileError(f"--strict refuses a file: {loss}") from None
    for each in caught:
        click.echo(f"warning: {printable(str(each.message))}", err=True)


def check_output(output: str, suffixes: tuple[str, ...], inputs: Mapping[str, str]) -> None:
    """Raise an error for an output with an unknown suffix, or for overwriting an input."""
    # The leading dot of a hidden file does not begin a suffix.
    if not Path(output).name[1:].lower().endswith(suffixes):
        wanted = f"one of {', '.join(suffixes)}" if suffixes[1:] else suffixes[0]
        raise EnvLightsError(f"cannot write {output}: the suffix must be {wanted}")
    if is_picture(output):
        check_can_draw(output)
    check_source(output, inputs)


def check_outputs(
    outputs: Sequence[str],
    suffixes: tuple[str, ...],
    inputs: Mapping[str, str],
    stage: Iterable[str] = (),
) -> None:
    """Check outputs; raises an error for `stage` options without an OpenUSD file."""
    for output in outputs:
        check_output(output, suffixes, inputs)
    check_options(map(target_of, filter(_is_scene, outputs)), stage)


def is_picture(output: str) -> bool:
    """True for an output file that is a picture."""
    return Path(output).suffix.lower() in PICTURES


def write(
    outputs: Iterable[str],
    save: Callable[..., Any],
    draw: Callable[[Any], Any],
    *,
    strict: bool = False,
    stage: Mapping[str, Any] | None = None,
) -> None:
    """Write each output with `save`, or draw pictures with `draw` and `envlights.plot`."""
    for output in outputs:
        if is_picture(output):
            # Import late, because Matplotlib takes a second.
            from envlights import plot

            plot.save(draw(plot), output)
        else:
            with print_losses(strict=strict):
                save(output, **stage_of(output, stage or {}))


def check_can_draw(output: str) -> None:
    """Refuse an output with pictures if Matplotlib is not installed."""
    if not can_draw():
        raise EnvLightsError(f"cannot write {output}: a picture {NO_MATPLOTLIB}")
    if os.environ.get("MPLBACKEND"):
        try:
            import_module("matplotlib")
        except ValueError as error:
            raise EnvLightsError(f"cannot write {output}: MPLBACKEND is wrong: {error}") from None


def check_source(output: str, inputs: Mapping[str, str]) -> None:
    """Raise an error for an output that cannot be written, or for overwriting an input."""
    target = check_writable(output)
    for what, path in inputs.items():
        if _is_same(target, Path(path)):
            raise EnvLightsError(f"cannot write {output}: it is {what}; give another name")


def _is_same(target: Path, source: Path) -> bool:
    return target.exists() and source.exists() and target.samefile(source)


def print_result(
    result: Any, as_json: bool, verbose: bool = False, frame: str | None = None
) -> None:
    """Print a result as JSON or text; a rig includes its report.

    With a frame, the directions of its lights are printed in this frame too.
    """
    text = result.verbose() if verbose else str(result)
    if isinstance(result, Rig) and not verbose:
        text = f"{result}\n\n{result.report}".rstrip()
    if frame is not None:
        text += f"\n\ndirections (x, y, z) in the frame {frame}"
        for number, row in enumerate(as_dict(result, frame)["in_frame"]["direction"], 1):
            text += f"\n{number:>5}  " + "  ".join(f"{value:>9.6f}" for value in row)
    click.echo(json.dumps(as_dict(result, frame), indent=2) if as_json else text)


def as_dict(result: Any, frame: str | None) -> dict[str, Any]:
    """Result as a dictionary for JSON; with a frame, also the light directions in that frame."""
    data: dict[str, Any] = result.to_dict()
    if frame is not None:
        lights = result.lights if isinstance(result, Rig) else result
        there = frame_named(frame).to_target(lights.direction)
        data["in_frame"] = {"name": frame, "direction": there.tolist()}
    return data


def say_written(paths: Sequence[str]) -> None:
    """Print the names of written files, after writing, so that a closed pipe does no harm."""
    for path in paths:
        if not is_standard_output(path):
            click.echo(f"wrote {printable(path)}", err=True)
