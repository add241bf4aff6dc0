"""The command line: one subcommand, one public function, one file."""

from __future__ import annotations

import contextlib
import errno
import sys
from collections.abc import Iterator
from difflib import get_close_matches
from importlib import import_module
from typing import Any

import click

from envlights._common.errors import FileError
from envlights._common.printable import printable
from envlights._native import EnvLightsError
from envlights.cli.examples import with_examples
from envlights.cli.options.quiet import with_quiet
from envlights.cli.options.standard_streams import with_standard_streams
from envlights.cli.refusal_words import with_options

#: Subcommands with their help. The module of a subcommand is imported when it is called.
_COMMANDS = {
    "batch": "Do the same work on many maps.",
    "compare": "Compare the lighting of maps, rigs or folders of them.",
    "convert": "Write a map in another layout, turned or resized.",
    "demo": "Make example files, and draw the result.",
    "detect": "Find the lights of a map.",
    "error-curve": "Fit a map with several numbers of lights, and compare the errors.",
    "export": "Write a rig or lights for other programs.",
    "fit": "Fit an ambient term and a few lights to a map.",
    "follow": "Fit a rig to each map of a sequence.",
    "mcp": "Run an MCP server that gives agents access to chosen folders.",
    "merge": "Merge exposures into one map.",
    "photograph": "Find the lights of a photograph.",
    "place": "Compute the light at any point of a room, from a depth map or the size of the room.",
    "relight": "Move, dim, colour, resize, remove or add lights of a map.",
    "repair": "Estimate the clipped light of a picture.",
    "show": "Write one page on a map: its lights, errors and notes.",
    "split": "Remove the lights from a map.",
    "transfer": "Learn indirect light from pairs of images, and predict it.",
    "vary": "Vary rigs at random, for training.",
    "view": "Make a page that shows things in a map, lit by a few lights.",
}

#: Context key for the arguments on the command line.
_GIVEN = "envlights.given"


def _subcommands(command: click.Command) -> Iterator[click.Command]:
    """Commands of a group, or the command itself."""
    if isinstance(command, click.Group):
        for each in command.commands.values():
            yield from _subcommands(each)
    else:
        yield command


class _Main(click.Group):
    """Group of all subcommands, which prints an error as one sentence.

    "-" is the standard input or output, whose format --format names: envlights fit - -o - --format
    json < map.hdr. Exit codes: 0 for success, 1 for a failure, 2 for wrong arguments.
    """

    def list_commands(self, _: click.Context) -> list[str]:
        return list(_COMMANDS)

    def get_command(self, _: click.Context, name: str) -> click.Command | None:
        if name not in _COMMANDS:
            return None
        command: click.Command = import_module(f"{__name__}.{name.replace('-', '_')}").command
        for each in _subcommands(command):
            with_quiet(each)
            with_standard_streams(each)
        with_examples(command)
        return command

    def resolve_command(self, context: click.Context, args: list[str]) -> Any:
        near = get_close_matches(args[0], _COMMANDS, n=1)
        if args[0] not in _COMMANDS and near:
            context.fail(f"No such command '{args[0]}'. Did you mean {near[0]}?")
        return super().resolve_command(context, args)

    def format_commands(self, _: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(_COMMANDS.items()))

    def parse_args(self, context: click.Context, args: list[str]) -> list[str]:
        context.meta[_GIVEN] = [*args]
        with _printable_usage():
            return super().parse_args(context, args)

    def main(self, *args: Any, **keywords: Any) -> Any:
        try:
            return super().main(*args, **keywords)
        except OSError as error:  # from a help text that cannot be printed
            click.echo(f"envlights: cannot print the answer: {error.strerror}", err=True)
            sys.exit(1)

    def invoke(self, context: click.Context) -> Any:
        try:
            with _printable_usage():
                return super().invoke(context)
        except EnvLightsError as refusal:
            command = self.get_command(context, context.invoked_subcommand or "")
            named = _subcommands(command or self)
            words = with_options(str(refusal), named, context.meta[_GIVEN])
            click.echo(f"envlights: {words}", err=True)
            context.exit(1 if isinstance(refusal, FileError) else 2)
        except OSError as error:
            if error.errno == errno.EPIPE:
                raise  # on `| head`, click exits quietly
            click.echo(f"envlights: cannot print the answer: {error.strerror}", err=True)
            context.exit(1)


@contextlib.contextmanager
def _printable_usage() -> Iterator[None]:
    """Make usage errors printable, because an argument may be a stranger's file name."""
    try:
        yield
    except click.ClickException as refusal:
        vars(refusal)["message"] = printable(refusal.message)  # final for type checkers
        raise


@click.group(cls=_Main, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="envlights", prog_name="envlights")
def main() -> None:
    """Turn an environment map into a handful of lights.

    Exit codes: 0 for success, 1 for a failure, 2 for wrong arguments. Completion of
    names and options in bash: eval "$(_ENVLIGHTS_COMPLETE=bash_source envlights)"; also zsh_source
    and fish_source.
    """
