"""The command line: one subcommand, one public function, one file."""

from __future__ import annotations

import errno
from importlib import import_module
from typing import Any

import click

from envlights._native import EnvLightsError

#: Subcommands with their help. The file of a subcommand is imported when it is called.
_COMMANDS = {
    "batch": "Do the same work on many maps.",
    "compare": "Compare the lighting of maps, rigs or folders of them.",
    "convert": "Write a map in another layout, turned or resized.",
    "demo": "Make example files, and draw the result.",
    "detect": "Find the lights of a map.",
    "export": "Write a rig or lights for other programs.",
    "fit": "Fit an ambient term and a few lights to a map.",
    "merge": "Merge exposures into one map.",
    "photograph": "Find the lights of a photograph.",
    "repair": "Estimate the clipped light of a picture.",
    "split": "Remove the lights from a map.",
    "transfer": "Learn indirect light from pairs of images, and predict it.",
    "view": "Make a page that shows things in a map, lit by a few lights.",
}


class _Main(click.Group):
    """Group of all subcommands, which prints a refusal as one sentence with exit code 2."""

    def list_commands(self, _: click.Context) -> list[str]:
        return list(_COMMANDS)

    def get_command(self, _: click.Context, name: str) -> click.Command | None:
        if name not in _COMMANDS:
            return None
        command: click.Command = import_module(f"{__name__}.{name}").command
        return command

    def format_commands(self, _: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(_COMMANDS.items()))

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


@click.group(cls=_Main, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="envlights", prog_name="envlights")
def main() -> None:
    """Turn an environment map into a handful of lights."""
