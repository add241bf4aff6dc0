"""The command line: one subcommand, one public function, one file."""

from __future__ import annotations

import errno
from typing import Any

import click

from envlights._native import EnvLightsError
from envlights.cli import demo, detect, export, fit, split
from envlights.cli.transfer import transfer


class _Refusing(click.Group):
    """A group that turns a refusal into one sentence and the exit code 2, not a traceback."""

    def invoke(self, context: click.Context) -> Any:
        try:
            return super().invoke(context)
        except EnvLightsError as refusal:
            click.echo(f"envlights: {refusal}", err=True)
            context.exit(2)
        except OSError as error:
            if error.errno == errno.EPIPE:
                raise  # `| head`: click ends quietly
            click.echo(f"envlights: cannot print the answer: {error.strerror}", err=True)
            context.exit(2)


@click.group(cls=_Refusing, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="envlights", prog_name="envlights")
def main() -> None:
    """Turn an environment map into a handful of lights."""


for _command in (
    fit.command,
    detect.command,
    split.command,
    export.command,
    demo.command,
    transfer,
):
    main.add_command(_command)
