"""Each case of the stress suite holds its bound, or is listed as open."""

import pytest

from tests.stress import CASES


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.group}: {case.name}")
def test_the_bound_holds_or_is_listed_as_open(case):
    seen = case.measure()
    if case.is_open:
        assert case.bound < seen < 1e-3, f"{seen:.2g}: no longer open, or worse than was listed"
    else:
        assert seen <= case.bound, f"{seen:.2g}, bound {case.bound:.2g}: {case.reason}"


@pytest.mark.parametrize(
    "case", [case for case in CASES if case.float32], ids=lambda case: case.name
)
def test_float32_alone_would_not_hold_the_bounds_of_float64(case):
    """Otherwise the case would not test precision."""
    assert case.float32() > case.bound
