"""Extreme cases, each with its bound and its measured error.

Errors are relative, directions in radians. `float32` is the error of the same formula in float32.
The cases are those of `tests/stress/`. Numbered bounds are derived in [bounds.md](bounds.md).
"""

from tests.stress import CASES

TITLE = "Numbers under stress"


def rows(_maps, _effort):
    """Yield a row for each case."""
    for case in CASES:
        seen = case.measure()
        yield {
            "group": case.group,
            "case": case.name,
            "bound": case.bound,
            "seen": float(seen),
            "float32": float(case.float32()) if case.float32 else "",
            "holds": "open" if case.is_open else "yes" if seen <= case.bound else "NO",
            "why this bound": case.reason,
        }
