"""Path ``-`` in subcommands: temporary files that stand for standard input or output."""

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

_STREAM = "-"
#: File stem for standard input.
STANDARD_INPUT = "standard_input"
#: Parameters with paths of output files.
_OUTPUTS = ("output", "outputs", "targets", "names")
#: Parameters with paths of input files, except images, whose reader supports ``-``.
_INPUTS = ("rig_path", "rig", "truth", "guess", "start", "model_path")
_FORMAT = "format_"
#: Context key for the temporary file of standard output.
_KEY = "envlights.standard_output"


def with_standard_streams(command: click.Command) -> None:
    """Support ``-`` in a subcommand, and add ``--format``; repeated calls change nothing."""
    names = {parameter.name for parameter in command.params}
    if _FORMAT in names or not names.intersection((*_OUTPUTS, *_INPUTS)):
        return
    work = command.callback
    assert work is not None

    def callback(*arguments: Any, format_: str | None = None, **options: Any) -> Any:
        with TemporaryDirectory(prefix="envlights-") as folder:
            options |= _inputs(Path(folder, "in"), options)
            with _to_standard_output(Path(folder, "out"), options, format_) as replaced:
                return work(*arguments, **replaced)

    command.callback = callback
    if names.intersection(_OUTPUTS):
        text = "Format of the output '-', which is the standard output, such as json or exr."
        command.params.append(click.Option(["--format", _FORMAT], metavar="FORMAT", help=text))


def is_standard_output(path: str) -> bool:
    """True for the temporary file of standard output."""
    context = click.get_current_context(silent=True)
    return context is not None and context.meta.get(_KEY) == path


def _inputs(folder: Path, options: dict[str, Any]) -> dict[str, Any]:
    """Options with an input ``-`` replaced by a file."""
    names = [name for name in _INPUTS if options.get(name) == _STREAM]
    if names[1:]:
        raise EnvLightsError("only one input can be the standard input; give paths of the others")
    if not names:
        return {}
    if sys.stdin is None or sys.stdin.isatty():
        raise EnvLightsError("the standard input has no file; send one to it with `<` or `|`")
    content = sys.stdin.buffer.read()
    folder.mkdir()
    path = folder / f"{STANDARD_INPUT}{_suffix_of(content)}"
    path.write_bytes(content)
    return {names[0]: str(path)}


def _suffix_of(content: bytes) -> str:
    """Suffix by the first bytes of a file; images do not need one."""
    if content[:2] == b"PK":
        return ".npz"
    if content.lstrip()[:1] == b"{":
        return ".json"
    return ".csv" if content[:1] == b"#" and content[:2] != b"#?" else ""


@contextlib.contextmanager
def _to_standard_output(
    folder: Path, options: dict[str, Any], form: str | None
) -> Iterator[dict[str, Any]]:
    """Options with an output ``-`` replaced by a file, which is copied at the end."""
    name = next((name for name in _OUTPUTS if _STREAM in _each(options.get(name))), "")
    outputs = options.get(name)
    if not name:
        if form is not None:
            raise EnvLightsError("--format is of the output '-'; leave it out, or write to -")
        yield options
        return
    if form is None:
        raise EnvLightsError("the output '-' needs a format, such as --format json")
    if options.get("as_json"):
        raise EnvLightsError("--json and the output '-' both print; leave out one of them")
    folder.mkdir()
    path = folder / f"standard_output{_suffix(form)}"
    replaced = tuple(str(path) if each == _STREAM else each for each in _each(outputs))
    click.get_current_context().meta[_KEY] = str(path)
    binary = sys.stdout.buffer
    try:
        with contextlib.redirect_stdout(sys.stderr), _without_path(path):
            yield {**options, name: replaced if isinstance(outputs, tuple) else replaced[0]}
    except (SystemExit, click.exceptions.Exit):
        _copy(path, binary)  # a comparison of folders is written even after failures
        raise
    _copy(path, binary)


def _each(outputs: Any) -> tuple[Any, ...]:
    """Values of an option that may be repeated."""
    return outputs if isinstance(outputs, tuple) else (outputs,)


@contextlib.contextmanager
def _without_path(path: Path) -> Iterator[None]:
    """Context whose error messages name standard output instead of the file."""
    try:
        yield
    except EnvLightsError as refusal:
        raise type(refusal)(str(refusal).replace(str(path), "the standard output")) from None


def _suffix(form: str) -> str:
    """Suffix for a format, which may be the name of a target."""
    from envlights.export.targets import TARGETS  # import late, because few calls need it

    suffixes = {target.name: target.suffixes[0] for target in TARGETS}
    return suffixes.get(form, f".{form.lstrip('.')}")


def _copy(path: Path, binary: Any) -> None:
    """Copy a file to standard output; raises an error if it needs companion files."""
    others = sorted(other.name for other in path.parent.iterdir() if other != path)
    if others:
        raise EnvLightsError(
            f"this format writes {len(others) + 1} files, and the standard output holds one; give"
            " the path of a file"
        )
    if path.exists():
        with path.open("rb") as file:
            shutil.copyfileobj(file, binary)
        binary.flush()
