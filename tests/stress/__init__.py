"""Extreme cases with their bounds: checked by tests, printed by `python -m benchmarks stress`."""

from tests.stress import extremes, laws, precision

#: All cases, in the order of the table.
CASES = [*extremes.CASES, *precision.CASES, *laws.CASES]
