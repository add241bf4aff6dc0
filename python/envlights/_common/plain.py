"""Plain values: the numbers, texts, lists and dictionaries that JSON holds."""

from __future__ import annotations

import enum
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from envlights._common.check import describe
from envlights._native import EnvLightsError

#: Word for infinity in files, because JSON has none.
INFINITE = "infinite"


def plain(value: Any, infinity: str | None = INFINITE) -> Any:
    """`value` as numbers, texts, lists and dictionaries alone; NaN becomes None.

    Raises
    ------
    EnvLightsError
        If it holds anything else.
    """
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, enum.Enum):
        return value.name
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else infinity if math.isinf(value) else None
    if hasattr(value, "_asdict"):
        value = value._asdict()
    if isinstance(value, Mapping):
        return {str(name): plain(each, infinity) for name, each in value.items()}
    if isinstance(value, list | tuple | range | set | frozenset):
        return [plain(each, infinity) for each in value]
    if hasattr(value, "to_dict"):
        return plain(value.to_dict(), infinity)
    raise EnvLightsError(
        f"a row holds numbers, texts, lists and dictionaries of them; got {describe(value)};"
        " return its numbers instead"
    )
