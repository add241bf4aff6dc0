"""Error messages for the command line, with options instead of Python arguments."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable

import click

#: Pattern for an argument ``layout=`` in Python: a quoted name, or a class method with arguments.
_LAYOUT = r"\blayout=(?:'([\w-]+)'|el\.io\.Layout\.?(\w*)\(([^()]*)\))?"
#: Pattern for an argument in Python: its name, and a quoted value, a plain value, or none.
_ARGUMENT = r"\b([a-z]\w*)=('[^']*'|\w*)(?=(\()?)"


def with_options(text: str, commands: Iterable[click.Command], given: Iterable[str] = ()) -> str:
    """Text with Python arguments replaced by options; words typed by the user are unchanged."""
    parameters = [each for command in commands for each in command.params]
    options = {each.name: max(each.opts, key=len) for each in parameters if each.opts}
    # Protect file names that look like arguments.
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
    """Arguments of a layout, which are separate options on the command line."""
    name, method, arguments = found.groups("")
    projection = name or method.replace("_", "-")
    if found[0] == "layout=":
        return "projection="
    each = [f"projection='{projection}'"] if projection else []
    return ", ".join(each + [arguments] * bool(arguments)) or found[0]
