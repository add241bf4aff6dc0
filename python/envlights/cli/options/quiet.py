"""Option ``--quiet`` of all subcommands."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click

_NAME = "quiet"


def with_quiet(command: click.Command) -> None:
    """Add ``--quiet`` to a subcommand; repeated calls change nothing."""
    if any(parameter.name == _NAME for parameter in command.params):
        return
    work = command.callback
    assert work is not None

    def callback(*arguments: Any, quiet: bool, **options: Any) -> Any:
        with _silence() if quiet else contextlib.nullcontext():
            return work(*arguments, **options)

    command.callback = callback
    text = "Print only errors."
    command.params.append(click.Option(["-q", f"--{_NAME}"], is_flag=True, help=text))


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    """Context that discards printed text."""
    with (
        Path(os.devnull).open("w", encoding="utf-8") as nothing,
        contextlib.redirect_stdout(nothing),
        contextlib.redirect_stderr(nothing),
    ):
        yield
