"""Option ``--set`` for method settings without an option of their own."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import fields, replace
from inspect import signature
from typing import Any

import click

from envlights._native import EnvLightsError


def settings_of(functions: Iterable[Callable[..., Any]], besides: Collection[str]) -> list[str]:
    """Parameter names of functions in order, without the first and those in `besides`.

    The fields of a parameter `settings` stand in its place.
    """
    names = []
    for function in functions:
        for each in list(signature(function).parameters.values())[1:]:
            names += _fields(each.default) if each.name == "settings" else [each.name]
    return [name for name in dict.fromkeys(names) if name not in besides]


def with_settings(function: Callable[..., Any], options: dict[str, Any]) -> dict[str, Any]:
    """Arguments of a function, with the fields of its `settings` combined to one value."""
    parameter = signature(function).parameters.get("settings")
    if parameter is None:
        return options
    names = _fields(parameter.default)
    given = {name: value for name, value in options.items() if name in names}
    others = {name: value for name, value in options.items() if name not in names}
    return {**others, "settings": replace(parameter.default, **given)}


def _fields(settings: Any) -> list[str]:
    return [each.name for each in fields(settings)]


def settings_option(of: str, names: Sequence[str] = ()) -> Callable[[Any], Any]:
    """Repeatable option ``--set``; pass its values to `settings_from`."""
    listed = f" ({', '.join(names)})" if names else ""
    return click.option(
        "--set",
        "settings",
        multiple=True,
        metavar="NAME=VALUE",
        help=f"Option of the {of}, as in Python{listed}. Can be repeated.",
    )


def settings_from(texts: Iterable[str], of: str, is_known: Callable[[str], bool]) -> dict[str, Any]:
    """Values of settings by name; values that are not valid JSON are text."""
    return dict(_setting(text, of, is_known) for text in texts)


def _setting(text: str, of: str, is_known: Callable[[str], bool]) -> tuple[str, Any]:
    name, equals, value = text.partition("=")
    if not equals or not is_known(name):
        raise EnvLightsError(f"--set must be NAME=VALUE of an option of the {of}; got {text}")
    try:
        return name, json.loads(value)
    except (ValueError, RecursionError):
        return name, value
