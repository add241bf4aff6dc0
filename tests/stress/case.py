"""A case of the stress suite."""

from collections.abc import Callable
from typing import NamedTuple

#: Largest relative error of one rounding.
U32, U64 = 2.0**-24, 2.0**-53


class Case(NamedTuple):
    """What must hold at an extreme; the tests check it, the benchmarks print it."""

    group: str
    name: str
    bound: float
    reason: str
    """Where the bound comes from; derived in `docs/bounds.md` where it names a number there."""

    measure: Callable[[], float]
    """The largest error, relative unless the name says otherwise."""

    float32: Callable[[], float] | None = None
    """The same error of plain sums in float32, where they are compared."""

    is_open: bool = False
    """True where the bound is known not to hold: a defect to be mended."""
