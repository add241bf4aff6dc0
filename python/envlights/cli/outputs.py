"""The output of a subcommand: its option, the checks before the work, and the text at the end."""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from envlights._native import EnvLightsError
from envlights.io.files import check_writable
from envlights.rig import Rig

#: The help of ``-o`` where lights are written.
OUTPUTS = (
    "Write lights for a program that the suffix names, .json for envlights itself (see envlights"
    " export -h), or a picture (.png, .pdf, .svg); may be given again."
)


def default_of(function: Callable[..., Any], parameter: str) -> Any:
    """The default of a parameter, which is written once, in its Python signature."""
    return inspect.signature(function).parameters[parameter].default


def output_option(help_text: str) -> Callable[[Any], Any]:
    """The option ``-o``, which may be given again."""
    return click.option("-o", "--output", "outputs", multiple=True, metavar="OUT", help=help_text)


def check_output(output: str, suffixes: tuple[str, ...], inputs: Mapping[str, str]) -> None:
    """Refuse an output with another suffix, or one that would overwrite an input."""
    # A name may begin with a dot, which begins no suffix then.
    if not Path(output).name[1:].lower().endswith(suffixes):
        wanted = f"one of {', '.join(suffixes)}" if suffixes[1:] else suffixes[0]
        raise EnvLightsError(f"cannot write {output}: the suffix must be {wanted}")
    target = check_writable(output)
    for what, path in inputs.items():
        if _is_same(target, Path(path)):
            raise EnvLightsError(f"cannot write {output}: it is {what}; give another name")


def _is_same(target: Path, source: Path) -> bool:
    return target.exists() and source.exists() and target.samefile(source)


def print_rig(rig: Rig, as_json: bool) -> None:
    """Print `rig` as JSON, or as text with its report."""
    click.echo(json.dumps(rig.to_dict(), indent=2) if as_json else f"{rig}\n\n{rig.report}")


def say_written(paths: Sequence[str]) -> None:
    """Name the files, once all are whole: a closed pipe must not keep any from being written."""
    for path in paths:
        click.echo(f"wrote {path}", err=True)
