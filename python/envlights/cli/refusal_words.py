"""Refusals in the words of the command line: options instead of Python arguments."""

from __future__ import annotations

import re
from collections.abc import Iterable

import click

#: An argument as Python writes it: its name, and a value in quotes, a plain one, or none.
_ARGUMENT = r"\b([a-z]\w*)=('[^']*'|\w*)(?=(\()?)"


def with_options(text: str, commands: Iterable[click.Command], given: Iterable[str] = ()) -> str:
    """Text in which arguments are options of the commands; words that were given stay."""
    parameters = [each for command in commands for each in command.params]
    options = {each.name: max(each.opts, key=len) for each in parameters if each.opts}
    # A file may be named like an argument.
    kept = "|".join(re.escape(word) for word in given if "=" in word)

    def option(found: re.Match[str]) -> str:
        name, value, bracket = found.groups()
        if name not in options or value == "False":
            return found[0]
        words = [options[name], *([] if value in ("", "True") else [value.strip("'")])]
        return " ".join(words) + (" " if bracket else "")

    return re.sub(f"{kept}|{_ARGUMENT}" if kept else _ARGUMENT, option, text)
