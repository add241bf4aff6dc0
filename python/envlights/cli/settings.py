"""Option ``--set`` for settings of a method that have no option of their own."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterable, Sequence
from inspect import signature
from typing import Any

import click

from envlights._native import EnvLightsError


def settings_of(functions: Iterable[Callable[..., Any]], besides: Collection[str]) -> list[str]:
    """Parameters of functions in their order, except for the first and some others."""
    names = [name for function in functions for name in list(signature(function).parameters)[1:]]
    return [name for name in dict.fromkeys(names) if name not in besides]


def settings_option(of: str, names: Sequence[str] = ()) -> Callable[[Any], Any]:
    """Repeatable option ``--set``; its values are for `settings_from`."""
    listed = f" ({', '.join(names)})" if names else ""
    return click.option(
        "--set",
        "settings",
        multiple=True,
        metavar="NAME=VALUE",
        help=f"Option of the {of}, as in Python{listed}. Can be repeated.",
    )


def settings_from(texts: Iterable[str], of: str, is_known: Callable[[str], bool]) -> dict[str, Any]:
    """Values of settings by name; a value that is not JSON is text."""
    return dict(_setting(text, of, is_known) for text in texts)


def _setting(text: str, of: str, is_known: Callable[[str], bool]) -> tuple[str, Any]:
    name, equals, value = text.partition("=")
    if not equals or not is_known(name):
        raise EnvLightsError(f"--set must be NAME=VALUE of an option of the {of}; got {text}")
    try:
        return name, json.loads(value)
    except ValueError:
        return name, value
