"""Fields of a report in JSON, which holds no infinity."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from envlights._check import amount
from envlights._native import EnvLightsError


def finite(value: float) -> float | str:
    """`value`, or a word for infinity."""
    return value if np.isfinite(value) else "infinite"


def number(value: float | str) -> float:
    """Number of a file, with "infinite" for infinity."""
    return np.inf if value == "infinite" else amount("report", value)


def optional(name: str, value: float | None) -> float | None:
    """Number of a file, or None."""
    return None if value is None else amount(name, value)


def rgb(values: list[float | str]) -> tuple[float, float, float]:
    """Three numbers of a file."""
    red, green, blue = (number(value) for value in values)
    return red, green, blue


def bands(values: Sequence[Sequence[float]]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Energies by degree of a map and of a difference, or a refusal."""
    rows = [tuple(amount("gloss_bands", value) for value in row) for row in values]
    if len(rows) != 2 or len(rows[0]) != len(rows[1]):
        raise EnvLightsError("gloss_bands must be two lists of the same length")
    return rows[0], rows[1]
