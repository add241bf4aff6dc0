"""Output ``-`` of all subcommands: the file goes to the standard output, and texts to the error."""

from __future__ import annotations

import contextlib
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import click

from envlights._native import EnvLightsError

_NAMES = ("output", "outputs")
_FORMAT = "format_"
#: Stem of the file that is written before it goes to the standard output.
_STEM = "standard_output"


def with_standard_output(command: click.Command) -> None:
    """Add ``--format`` to a subcommand that writes files; a second call changes nothing."""
    if isinstance(command, click.Group):
        for each in command.commands.values():
            with_standard_output(each)
        return
    names = {parameter.name for parameter in command.params}
    if _FORMAT in names or not names.intersection(_NAMES):
        return
    work = command.callback
    assert work is not None

    def callback(*arguments: Any, format_: str | None, **options: Any) -> Any:
        name = next(name for name in _NAMES if name in options)
        with _standard_output(options[name], format_) as options[name]:
            return work(*arguments, **options)

    command.callback = callback
    text = "Format of the standard output, for an output of '-': a suffix such as json or exr."
    command.params.append(click.Option(["--format", _FORMAT], metavar="SUFFIX", help=text))


@contextlib.contextmanager
def _standard_output(outputs: Any, suffix: str | None) -> Iterator[Any]:
    """Outputs with a file instead of ``-``, which is copied to the standard output at the end."""
    several = outputs if isinstance(outputs, tuple) else (outputs,)
    if "-" not in several:
        if suffix is not None:
            raise EnvLightsError("--format is for an output of '-'; leave it out, or write to -")
        yield outputs
        return
    if suffix is None:
        raise EnvLightsError("an output of '-' needs --format, such as --format json")
    binary = sys.stdout.buffer
    with TemporaryDirectory() as folder:
        path = Path(folder, f"{_STEM}.{suffix.lstrip('.')}")
        replaced = [str(path) if each == "-" else each for each in several]
        with contextlib.redirect_stdout(sys.stderr):
            yield tuple(replaced) if isinstance(outputs, tuple) else replaced[0]
        _check_alone(path)
        with path.open("rb") as file:
            shutil.copyfileobj(file, binary)
        binary.flush()


def _check_alone(path: Path) -> None:
    """Refuse an output of several files."""
    others = sorted(other.name for other in path.parent.iterdir() if other != path)
    if others:
        raise EnvLightsError(
            f"the output has {len(others) + 1} files, and the standard output holds one; write it"
            " to a path"
        )


def is_standard_output(path: str) -> bool:
    """True for the file that goes to the standard output."""
    return Path(path).stem == _STEM
