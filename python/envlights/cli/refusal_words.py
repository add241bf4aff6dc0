"""Refusals in the words of the command line: options instead of Python arguments."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable

import click

#: An argument ``layout=`` as Python writes it: a name in quotes, or a class method with arguments.
_LAYOUT = r"\blayout=(?:'([\w-]+)'|el\.io\.Layout\.?(\w*)\(([^()]*)\))?"
#: An argument as Python writes it: its name, and a value in quotes, a plain one, or none.
_ARGUMENT = r"\b([a-z]\w*)=('[^']*'|\w*)(?=(\()?)"


def with_options(text: str, commands: Iterable[click.Command], given: Iterable[str] = ()) -> str:
    """Text in which arguments are options of the commands; words that were given stay."""
    parameters = [each for command in commands for each in command.params]
    options = {each.name: max(each.opts, key=len) for each in parameters if each.opts}
    # A file may be named like an argument.
    kept = "|".join(re.escape(word) for word in given if "=" in word)

    def rewrite(argument: str, by: Callable[[re.Match[str]], str], text: str) -> str:
        return re.sub(f"{kept}|{argument}" if kept else argument, by, text)

    def option(found: re.Match[str]) -> str:
        name, value, bracket = found.groups()
        if name not in options or value == "False":
            return found[0]
        words = [options[name], *([] if value in ("", "True") else [value.strip("'")])]
        return " ".join(words) + (" " if bracket else "")

    if "projection" in options:
        text = rewrite(_LAYOUT, _arguments, text)
    return rewrite(_ARGUMENT, option, text)


def _arguments(found: re.Match[str]) -> str:
    """Arguments of a layout, which the command line has one by one."""
    name, method, arguments = found.groups("")
    projection = name or method.replace("_", "-")
    if found[0] == "layout=":
        return "projection="
    each = [f"projection='{projection}'"] if projection else []
    return ", ".join(each + [arguments] * bool(arguments)) or found[0]
