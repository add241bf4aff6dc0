"""Output of a subcommand: options, checks before the work, and printed text."""

from __future__ import annotations

import contextlib
import inspect
import json
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from envlights._common.errors import FileError
from envlights._common.files import NO_MATPLOTLIB, PICTURES, can_draw, check_writable
from envlights._common.printable import printable
from envlights._native import EnvLightsError
from envlights.cli.standard_streams import is_standard_output
from envlights.rigs.rig import Rig

#: Help of ``-o`` for subcommands that write lights.
OUTPUTS = (
    "File to write: lights for the program of the suffix (list: envlights export -h) or a picture"
    " (.png, .pdf, .svg). Can be repeated."
)


def default_of(function: Callable[..., Any], parameter: str) -> Any:
    """Default of a parameter, read from its Python signature."""
    return inspect.signature(function).parameters[parameter].default


def output_option(help_text: str) -> Callable[[Any], Any]:
    """Repeatable option ``-o``."""
    return click.option("-o", "--output", "outputs", multiple=True, metavar="OUT", help=help_text)


def verbose_option() -> Callable[[Any], Any]:
    """Option ``--verbose``."""
    return click.option("-v", "--verbose", is_flag=True, help="Print all details of the report.")


def strict_option() -> Callable[[Any], Any]:
    """Option ``--strict``."""
    return click.option(
        "--strict",
        is_flag=True,
        help="Write no file whose program shows the lights with a larger error than printed.",
    )


@contextlib.contextmanager
def print_losses(*, strict: bool = False) -> Iterator[None]:
    """Print what programs lose of lights that are written inside, or refuse to write them."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("error" if strict else "always", UserWarning)
        try:
            yield
        except UserWarning as loss:
            raise FileError(f"--strict refuses a file: {loss}") from None
    for each in caught:
        click.echo(f"warning: {each.message}", err=True)


def check_output(output: str, suffixes: tuple[str, ...], inputs: Mapping[str, str]) -> None:
    """Refuse an output with an unknown suffix, or one that would overwrite an input."""
    # The dot of a hidden file begins no suffix.
    if not Path(output).name[1:].lower().endswith(suffixes):
        wanted = f"one of {', '.join(suffixes)}" if suffixes[1:] else suffixes[0]
        raise EnvLightsError(f"cannot write {output}: the suffix must be {wanted}")
    if Path(output).suffix.lower() in PICTURES:
        check_can_draw(output)
    check_source(output, inputs)


def check_can_draw(output: str) -> None:
    """Refuse an output with pictures if Matplotlib is not installed."""
    if not can_draw():
        raise EnvLightsError(f"cannot write {output}: a picture {NO_MATPLOTLIB}")


def check_source(output: str, inputs: Mapping[str, str]) -> None:
    """Refuse an output that cannot be written, or that would overwrite an input."""
    target = check_writable(output)
    for what, path in inputs.items():
        if _is_same(target, Path(path)):
            raise EnvLightsError(f"cannot write {output}: it is {what}; give another name")


def _is_same(target: Path, source: Path) -> bool:
    return target.exists() and source.exists() and target.samefile(source)


def print_rig(rig: Rig, as_json: bool, verbose: bool) -> None:
    """Print `rig` as JSON, or as text with its report."""
    text = rig.verbose() if verbose else f"{rig}\n\n{rig.report}".rstrip()
    click.echo(json.dumps(rig.to_dict(), indent=2) if as_json else text)


def say_written(paths: Sequence[str]) -> None:
    """Name the written files at the end, so that a closed pipe does not prevent writing."""
    for path in paths:
        if not is_standard_output(path):
            click.echo(f"wrote {printable(path)}", err=True)
