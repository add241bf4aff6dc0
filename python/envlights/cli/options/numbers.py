"""Comma-separated numbers as option values."""

from __future__ import annotations

import contextlib

from envlights._native import EnvLightsError

#: Largest number of a range, because ranges are expanded to lists.
_MOST = 10000


def numbers(option: str, text: str, example: str) -> list[float]:
    """Comma-separated numbers, as many as in the example."""
    with contextlib.suppress(ValueError):
        values = [float(value) for value in text.split(",")]
        if len(values) == len(example.split(",")):
            return values
    count = {1: "a number", 2: "two numbers", 3: "three numbers"}[len(example.split(","))]
    raise EnvLightsError(f"{option} must be {count}, such as {example}; got {text}")


def whole_numbers(option: str, text: str) -> list[int]:
    """Comma-separated whole numbers and ranges: "0-4,8" is 0, 1, 2, 3, 4, 8."""
    found: list[int] = []
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        if not first.isdecimal() or (dash and not last.isdecimal()):
            raise EnvLightsError(
                f"{option} must be whole numbers and ranges, such as 0-8 or 1,2,4; got {text}"
            )
        end = int(last if dash else first)
        if end >= _MOST:
            raise EnvLightsError(f"{option} must be less than {_MOST}; got {end}")
        found += range(int(first), end + 1)
    return found
